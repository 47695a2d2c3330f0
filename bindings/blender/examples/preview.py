"""Shows a file of `crumple examples` in Blender without a window, and bakes it:

    pip install bpy==5.0.1
    python preview.py EXTENSION.zip hood_examples.glb hood.crumple [PICTURE.png]

It installs the extension, hits the mesh twice, prints how deep the dents are, writes the third file, and draws the mesh.
"""

import os
import sys

import bpy
from mathutils import Vector


def draw(body: bpy.types.Object, file: str) -> None:
    """Draws the body from above its front edge, with a light low over its left edge that shows dents."""
    scene = bpy.context.scene
    corners = [body.matrix_world @ Vector(corner) for corner in body.bound_box]
    middle = sum(corners, Vector()) / 8
    size = max((corner - middle).length for corner in corners)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    light = bpy.data.objects.new("light", bpy.data.lights.new("light", "SUN"))
    for one, direction in ((camera, Vector((0.25, -1.0, 1.1))), (light, Vector((-1.0, -0.1, 0.45)))):
        one.location = middle + 3.7 * size * direction.normalized()
        one.rotation_euler = (middle - one.location).to_track_quat("-Z", "Y").to_euler()
        scene.collection.objects.link(one)
    camera.data.clip_end = 10 * size
    light.data.energy = 6
    scene.camera, scene.render.engine, scene.cycles.samples = camera, "CYCLES", 64
    scene.render.resolution_x, scene.render.resolution_y, scene.render.filepath = 480, 280, file
    bpy.ops.render.render(write_still=True)


if len(sys.argv) not in (4, 5):
    raise SystemExit(__doc__)
extension, file, out = sys.argv[1:4]
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
if len(sys.argv) == 5:
    draw(body, os.path.abspath(sys.argv[4]))
# bpy 4.2 crashes at exit after its own glTF exporter has run.
os._exit(0)
