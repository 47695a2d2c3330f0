"""Draws a car that make_car.py wrote, in Blender without a window (pip install bpy==5.0.1):

    python draw_car.py car.glb [dented.glb ...] PICTURE.png [--views front left ...] [--zebra] [--size 640 400] [--samples 24]

Several views or cars become one picture, two beside each other."""

import argparse
import math
import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

# Azimuth from the front towards the car's left, elevation (degrees), the distance of the camera in metres.
VIEWS = {
    "front": (0, 6, 9.0), "rear": (180, 6, 9.0), "left": (90, 4, 10.5), "right": (270, 4, 10.5), "top": (90, 89, 10.5),
    "front_left": (38, 13, 9.5), "front_right": (-35, 7, 9.0), "rear_left": (140, 14, 9.5), "rear_right": (218, 10, 9.5),
    "hero": (33, 9, 8.6), "high": (40, 35, 9.5),
}


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("glb", type=Path, nargs="+")
    p.add_argument("picture", type=Path)
    p.add_argument("--views", nargs="+", choices=VIEWS, default=["hero"])
    p.add_argument("--zebra", action="store_true", help="bodies reflect black and white stripes")
    p.add_argument("--size", nargs=2, type=int, default=(640, 400))
    p.add_argument("--samples", type=int, default=24)
    p.add_argument("--focus", nargs=4, type=float, help="look at X Y Z (forward, left, up) from this much nearer")
    return p.parse_args(sys.argv[1:])


def node(tree, kind, **values):
    n = tree.nodes.new(kind)
    for key, value in values.items():
        setattr(n, key, value)
    return n


def studio(scene):
    """A dark room with a bright ceiling lamp and a light horizon, and a floor."""
    world = bpy.data.worlds.new("studio")
    world.use_nodes = True
    scene.world = world
    t = world.node_tree
    t.nodes.clear()
    out, back = node(t, "ShaderNodeOutputWorld"), node(t, "ShaderNodeBackground")
    coordinate, split = node(t, "ShaderNodeTexCoord"), node(t, "ShaderNodeSeparateXYZ")
    ramp = node(t, "ShaderNodeValToRGB")
    e = ramp.color_ramp.elements
    e[0].position, e[0].color = 0.0, (0.06, 0.062, 0.066, 1)
    e[1].position, e[1].color = 1.0, (0.16, 0.19, 0.24, 1)
    for at, c in ((0.497, (0.06, 0.062, 0.066, 1)), (0.505, (0.40, 0.44, 0.50, 1)), (0.56, (0.62, 0.66, 0.70, 1)), (0.66, (0.22, 0.26, 0.32, 1))):
        new = e.new(at)
        new.color = c
    half = node(t, "ShaderNodeMath", operation="MULTIPLY_ADD")
    half.inputs[1].default_value = half.inputs[2].default_value = 0.5
    t.links.new(coordinate.outputs["Generated"], split.inputs[0])
    t.links.new(split.outputs[2], half.inputs[0])
    t.links.new(half.outputs[0], ramp.inputs[0])
    t.links.new(ramp.outputs[0], back.inputs[0])
    t.links.new(back.outputs[0], out.inputs[0])
    back.inputs[1].default_value = 0.75
    for where, turn, size, power in (((0.5, 0, 5.5), (0, 0, 0), (6.5, 2.6), 420), ((5, 5, 3.5), (-0.95, 0.35, -0.6), (3, 2.0), 160), ((-5, -4.5, 3), (0.95, -0.35, -0.6), (3, 2), 110)):
        lamp = bpy.data.lights.new("lamp", "AREA")
        lamp.shape, lamp.size, lamp.size_y, lamp.energy = "RECTANGLE", size[0], size[1], power
        o = bpy.data.objects.new("lamp", lamp)
        o.location = where
        if where[1]:
            o.rotation_euler = (Vector((0, 0, 0.6)) - Vector(where)).to_track_quat("-Z", "Y").to_euler()
        scene.collection.objects.link(o)
    bpy.ops.mesh.primitive_circle_add(vertices=64, radius=400, fill_type="NGON", location=(0, 0, 0))
    floor = bpy.data.materials.new("floor")
    floor.use_nodes = True
    b = floor.node_tree.nodes["Principled BSDF"]
    b.inputs["Base Color"].default_value, b.inputs["Roughness"].default_value = (0.10, 0.103, 0.11, 1), 0.38
    bpy.context.object.data.materials.append(floor)


def zebra():
    """Emission by the height of the reflected direction: what a striped room would look like in a mirror."""
    m = bpy.data.materials.new("zebra")
    m.use_nodes = True
    t = m.node_tree
    t.nodes.clear()
    out, glow = node(t, "ShaderNodeOutputMaterial"), node(t, "ShaderNodeEmission")
    coordinate, split = node(t, "ShaderNodeTexCoord"), node(t, "ShaderNodeSeparateXYZ")
    sine = node(t, "ShaderNodeMath", operation="SINE")
    scale = node(t, "ShaderNodeMath", operation="MULTIPLY")
    scale.inputs[1].default_value = 34
    hard = node(t, "ShaderNodeMath", operation="MULTIPLY_ADD", use_clamp=True)
    hard.inputs[1].default_value, hard.inputs[2].default_value = 6, 0.5
    t.links.new(coordinate.outputs["Reflection"], split.inputs[0])
    t.links.new(split.outputs[2], scale.inputs[0])
    t.links.new(scale.outputs[0], sine.inputs[0])
    t.links.new(sine.outputs[0], hard.inputs[0])
    t.links.new(hard.outputs[0], glow.inputs[0])
    t.links.new(glow.outputs[0], out.inputs[0])
    return m


def face_x(objects):
    """The importer turns glTF's z, the car's front, to -y. Here the front is x."""
    for o in [o for o in objects if o.parent is None]:
        o.rotation_mode = "XYZ"
        o.rotation_euler = (o.rotation_euler[0], o.rotation_euler[1], math.radians(90))


def load(scene, glb, striped):
    """The objects of a car."""
    before = set(scene.objects)
    bpy.ops.import_scene.gltf(filepath=str(glb.resolve()))
    new = [o for o in scene.objects if o not in before]
    face_x(new)
    if striped:
        for o in [o for o in new if o.type == "MESH"]:
            for slot in o.material_slots:
                if slot.material.name.split(".")[0] in ("paint", "paint_second", "glass"):
                    slot.material = striped
    return new


def prepare(scene, size, samples):
    """Sets how pictures are drawn, and adds the camera."""
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = samples, True
    scene.cycles.max_bounces, scene.cycles.transparent_max_bounces = 5, 8
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", "AgX - Medium High Contrast"
    scene.view_settings.exposure = 0.35
    camera = scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.lens = 62
    scene.collection.objects.link(camera)


def aim(camera, middle, azimuth, elevation, distance):
    az, el = math.radians(azimuth), math.radians(elevation)
    camera.location = middle + distance * Vector((math.cos(az) * math.cos(el), math.sin(az) * math.cos(el), math.sin(el)))
    camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()


def main():
    a = arguments()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    studio(scene)
    prepare(scene, a.size, a.samples)
    r = scene.render
    if a.zebra:
        scene.view_settings.view_transform, scene.view_settings.look, scene.view_settings.exposure = "Standard", "None", 0
    pictures, striped, car = [], zebra() if a.zebra else None, []
    for glb, view in [(glb, view) for glb in a.glb for view in a.views]:
        if view == a.views[0]:
            for o in car:
                bpy.data.objects.remove(o, do_unlink=True)
            car = load(scene, glb, striped)
        azimuth, elevation, distance = VIEWS[view]
        middle = Vector((-0.05, 0, 0.62))
        if a.focus:
            middle, distance = Vector(a.focus[:3]), distance / a.focus[3]
        aim(scene.camera, middle, azimuth, elevation, distance)
        with tempfile.TemporaryDirectory() as folder:
            r.filepath = os.path.join(folder, "view.png")
            bpy.ops.render.render(write_still=True)
            image = bpy.data.images.load(r.filepath)
            pictures.append(np.array(image.pixels[:]).reshape(a.size[1], a.size[0], 4)[..., :3])
    columns = 1 if len(pictures) == 1 else 2
    if len(pictures) % columns:
        pictures.append(np.zeros_like(pictures[0]))
    rows = [np.concatenate(pictures[i : i + columns], 1) for i in range(0, len(pictures), columns)]
    whole = np.concatenate(rows[::-1], 0)
    height, width = whole.shape[:2]
    image = bpy.data.images.new("whole", width, height)
    image.pixels = np.concatenate([whole, np.ones((height, width, 1))], 2).astype(np.float32).ravel()
    image.filepath_raw, image.file_format = str(a.picture.resolve()), "PNG"
    image.save()
    os._exit(0)


if __name__ == "__main__":
    main()
