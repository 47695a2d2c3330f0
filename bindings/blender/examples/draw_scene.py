"""Draws a frame that the example program `crash` wrote, in Blender without a window:

    pip install bpy==5.0.1
    python draw_scene.py frame_03.obj PICTURE.png
"""

import os
import sys

import bpy
from mathutils import Vector

if len(sys.argv) != 3:
    raise SystemExit(__doc__)
scene = bpy.context.scene
for one in list(bpy.data.objects):
    bpy.data.objects.remove(one)
bpy.ops.wm.obj_import(filepath=os.path.abspath(sys.argv[1]), forward_axis="Y", up_axis="Z")
corners = [one.matrix_world @ Vector(corner) for one in bpy.data.objects for corner in one.bound_box]
low, high = (Vector(map(end, *corners)) for end in (min, max))
middle = (low + high) / 2
bpy.ops.mesh.primitive_plane_add(size=100, location=(0, 0, low.z))
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
camera.location = middle + 1.45 * max(high - low) * Vector((0.0, -1.0, 0.5)).normalized()
camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()
light = bpy.data.objects.new("light", bpy.data.lights.new("light", "SUN"))
light.rotation_euler = Vector((1.0, 0.3, -0.45)).to_track_quat("-Z", "Y").to_euler()
light.data.energy = 4
for one in (camera, light):
    scene.collection.objects.link(one)
scene.camera, scene.render.engine, scene.cycles.samples = camera, "CYCLES", 64
scene.render.resolution_x, scene.render.resolution_y = 640, 280
scene.render.filepath = os.path.abspath(sys.argv[2])
bpy.ops.render.render(write_still=True)
os._exit(0)
