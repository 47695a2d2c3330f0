"""Writes a plate with two dents from Blender, with each of its exporters' options that could matter to them.

blender.py FOLDER
"""

import math
import sys
from pathlib import Path

import bpy

folder = Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
bpy.ops.wm.read_homefile(use_empty=True)
bpy.ops.mesh.primitive_grid_add(x_subdivisions=20, y_subdivisions=20, size=1.0)
body = bpy.context.object
body.name = body.data.name = "Plate"
body["maker"] = "a custom property"
body.data["placements"] = {"Left": "anchored", "Right": "carried"}
body.shape_key_add(name="Basis")
for name, (x, y), depth in [("Left", (-0.2, 0.0), 0.05), ("Right", (0.25, 0.1), 0.03)]:
    key = body.shape_key_add(name=name, from_mix=False)
    for point in key.points:
        away = math.hypot(point.co.x - x, point.co.y - y)
        point.co.z -= depth * max(0.0, 1.0 - away / 0.15)
keys = body.data.shape_keys.key_blocks[1:]
for key in keys:
    key.value = 0.0
for name in ("Paint, red", "Rubber"):
    material = bpy.data.materials.new(name)
    body.data.materials.append(material)
for face in body.data.polygons:
    face.material_index = int(face.center.x > 0.0)
    face.use_smooth = True
body.data.color_attributes.new("Colour", "BYTE_COLOR", "POINT")

# A picture on the first material.
picture = bpy.data.images.new("paint", 4, 4)
picture.pixels = [0.2, 0.4, 0.8, 1.0] * 16
picture.filepath_raw = str(folder / "paint.png")
picture.file_format = "PNG"
picture.save()
tree = body.data.materials[0].node_tree
texture = tree.nodes.new("ShaderNodeTexImage")
texture.image = picture
(shader,) = (node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])


def gltf(name, kind="GLB", **options):
    bpy.ops.export_scene.gltf(filepath=str(folder / name), export_format=kind, **{"export_extras": True, **options})


gltf("plain.glb")
gltf("separate.gltf", "GLTF_SEPARATE", export_texture_dir="pictures")
gltf("no_extras.glb", export_extras=False)
gltf("no_normals.glb", export_normals=False)
gltf("no_key_normals.glb", export_morph_normal=False)
gltf("tangents.glb", export_tangents=True, export_morph_tangent=True)
gltf("dense_keys.glb", export_try_sparse_sk=False)
gltf("omitted_keys.glb", export_try_omit_sparse_sk=True)
gltf("z_up.glb", export_yup=False)
gltf("no_uv_no_material.glb", export_texcoords=False, export_materials="NONE")
gltf("webp.glb", export_image_format="WEBP")
gltf("attributes.glb", export_attributes=True, export_vertex_color="ACTIVE", export_all_vertex_colors=True)
gltf("shared_accessors.glb", export_shared_accessors=True)
gltf("no_shape_keys.glb", export_morph=False)
gltf("draco.glb", export_draco_mesh_compression_enable=True)

# A modifier that is applied takes the shape keys away.
modifier = body.modifiers.new("Bevel", "BEVEL")
gltf("applied.glb", export_apply=True)
gltf("not_applied.glb", export_apply=False)
body.modifiers.remove(modifier)

# Keys that are animated, and a skin.
keys[0].keyframe_insert("value", frame=1)
keys[0].value = 0.0
keys[0].keyframe_insert("value", frame=20)
gltf("animated.glb")
body.data.shape_keys.animation_data_clear()
bpy.ops.object.armature_add(location=(0.1, 0.2, 0.3))
bones = bpy.context.object
group = body.vertex_groups.new(name=bones.data.bones[0].name)
group.add(range(len(body.data.vertices)), 1.0, "REPLACE")
skin = body.modifiers.new("Skin", "ARMATURE")
skin.object = bones
gltf("skinned.glb")
body.modifiers.remove(skin)
bpy.data.objects.remove(bones)

# Several objects under a scaled one, with keys of the same names.
twin = body.copy()
twin.data = body.data.copy()
twin.location = (1.5, 0.0, 0.0)
bpy.context.scene.collection.objects.link(twin)
above = bpy.data.objects.new("centimetres", None)
above.scale = (0.01,) * 3
bpy.context.scene.collection.objects.link(above)
body.parent = twin.parent = above
gltf("scaled_parts.glb")
bpy.data.objects.remove(twin)
body.parent = None


def obj(name, **options):
    """The undented mesh, and beside it one file for each key."""
    for key in [None, *keys]:
        for other in keys:
            other.value = float(other == key)
        path = folder / (f"{name}.obj" if key is None else f"{name}_{key.name}.obj")
        bpy.ops.wm.obj_export(filepath=str(path), path_mode="RELATIVE", **options)


obj("plain")
obj("triangulated", export_triangulated_mesh=True)
obj("bare", export_normals=False, export_uv=False, export_materials=False)
obj("coloured", export_colors=True)
obj("groups", export_object_groups=True, export_material_groups=True, export_vertex_groups=True, export_smooth_groups=True)
obj("z_up", forward_axis="Y", up_axis="Z", global_scale=100.0)
