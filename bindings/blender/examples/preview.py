"""Shows a file of `crumple examples` in Blender without a window, and bakes it:

    pip install bpy==5.0.1
    python preview.py EXTENSION.zip hood_examples.glb hood.crumple

It installs the extension, hits the mesh twice, prints how deep the dents are, and writes the third file.
"""

import os
import sys

import bpy

if len(sys.argv) != 4:
    raise SystemExit(__doc__)
extension, file, out = sys.argv[1:]
bpy.ops.extensions.package_install_files(filepath=extension, repo="user_default", enable_on_install=True)
for one in list(bpy.data.objects):
    bpy.data.objects.remove(one)
bpy.ops.import_scene.gltf(filepath=file)
body = next(one for one in bpy.data.objects if one.type == "MESH" and one.data.shape_keys)
bpy.context.view_layer.objects.active = body
for vertex in (len(body.data.vertices) // 3, len(body.data.vertices) // 2):
    bpy.ops.crumple.hit(location=body.matrix_world @ body.data.vertices[vertex].co, depth=0.02)
base, dents = body.data.shape_keys.reference_key, body.data.shape_keys.key_blocks["Crumple damage"]
depth = max((a.co - b.co).length for a, b in zip(base.points, dents.points, strict=True))
print(f"{body.name}: {len(body.crumple_hits)} hits, {1000 * depth:.1f} mm deep")
bpy.ops.crumple.export(filepath=os.path.abspath(out))
print(bpy.data.texts["Crumple report"].as_string(), flush=True)
# bpy 4.2 crashes at exit after its own glTF exporter has run.
os._exit(0)
