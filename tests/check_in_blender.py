"""Opens glTF files in Blender: each has a mesh there.

Needs the `bpy` package (pip install bpy==5.0.1, Python 3.11). Exit code 3 where it is not there.
"""

import os
import sys

try:
    import bpy
except ImportError as error:
    print("bpy is not installed:", error, file=sys.stderr)
    sys.exit(3)

for path in sys.argv[1:]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=os.path.abspath(path))
    assert any(thing.type == "MESH" for thing in bpy.context.scene.objects), path
