"""Dents the repository's car with the extension, in Blender without a window, and draws it:

    pip install bpy==5.0.1
    python dent_car.py EXTENSION.zip PICTURE.png

It imports the car with its examples, joins the parts that dent to one mesh, and hits this with the operator behind *Click to Hit*.
"""

import json
import os
import sys
import tempfile
from pathlib import Path

import bpy
from mathutils import Vector

CAR = Path(__file__).resolve().parents[3] / "assets/car"
sys.path.insert(0, str(CAR))

import draw_car  # noqa: E402
import packing  # noqa: E402

# Where (x to the car's left, y backwards, z up), whence, kg, m/s, and the radius of what strikes, m.
HITS = [
    ((0.74, -1.98, 0.56), (-0.4, 1, 0), 250, 8.0, 0.05),
    ((0.30, -1.55, 0.88), (0, 0.3, -1), 25, 8.0, 0.12),
    ((0.89, -0.10, 0.62), (-1, 0.1, 0), 286, 7.0, 0.13),
    ((0.88, 0.55, 0.72), (-1, 0.1, -0.2), 118, 6.0, 0.05),
]

if len(sys.argv) != 3:
    raise SystemExit(__doc__)
extension, picture = (os.path.abspath(path) for path in sys.argv[1:])
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.extensions.package_install_files(filepath=extension, repo="user_default", enable_on_install=True)
with tempfile.TemporaryDirectory() as folder:
    # Blender does not read packed files.
    file = Path(folder) / "car.glb"
    file.write_bytes(packing.unpacked((CAR / "car_dents.glb").read_bytes()))
    bpy.ops.import_scene.gltf(filepath=str(file))
parts = list(bpy.context.scene.objects)
dents = [part for part in parts if not part.get("crumple")]
# Of the parts that an example moves, one tells its blow.
blows = [blow.to_dict() for part in dents for blow in part.data.get("impacts", [])]
bpy.ops.object.select_all(action="DESELECT")
for part in dents:
    part.select_set(True)
body = bpy.context.view_layer.objects.active = next(part for part in dents if part.data.shape_keys)
body.name = "Car"
bpy.ops.object.join()
body.data["impacts"] = json.dumps(blows)
for location, direction, mass, speed, radius in HITS:
    bpy.ops.crumple.hit(location=location, direction=direction, by="BLOW", mass=mass, speed=speed, radius=radius)
scene = bpy.context.scene
draw_car.face_x(scene.objects)
draw_car.studio(scene)
draw_car.prepare(scene, (960, 540), 64)
draw_car.aim(scene.camera, Vector((0.0, 0.05, 0.62)), 40, 10, 7.8)
scene.render.filepath = picture
bpy.ops.render.render(write_still=True)
