"""Opens glTF files in Blender's `bpy`: each has a mesh there."""

import os
import sys

import bpy

for path in sys.argv[1:]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=os.path.abspath(path))
    assert any(thing.type == "MESH" for thing in bpy.context.scene.objects), path
