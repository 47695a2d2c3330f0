"""Opens SOURCE and DENTED in Blender and compares what an artist would see: everything but the dent must be the same.

Usage: python open_in_blender.py SOURCE DENTED [SOURCE DENTED ...]
"""

import sys

import bpy


def seen(path):
    """What the file shows: node tree, materials and UVs as they are, positions apart."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path)
    nodes, meshes = {}, {}
    for thing in bpy.context.scene.objects:
        matrix = [round(value, 5) for row in thing.matrix_world for value in row]
        nodes[thing.name] = (thing.type, thing.parent and thing.parent.name, matrix)
        if thing.type != "MESH":
            continue
        data = thing.data
        meshes[thing.name] = {
            "materials": [slot.material and slot.material.name for slot in thing.material_slots],
            "faces by material": [polygon.material_index for polygon in data.polygons],
            "corners": [corner.vertex_index for corner in data.loops],
            "UVs": {layer.name: [tuple(round(value, 5) for value in uv.uv) for uv in layer.data] for layer in data.uv_layers},
            "positions": [vertex.co.copy() for vertex in data.vertices],
            "shape keys": len(data.shape_keys.key_blocks) - 1 if data.shape_keys else 0,
        }
    return nodes, meshes


def compare(source, dented):
    nodes, meshes = seen(source)
    dented_nodes, dented_meshes = seen(dented)
    assert meshes, f"{source}: Blender finds no mesh in it"
    assert nodes == dented_nodes, f"{dented}: its nodes are {dented_nodes}, those of {source} are {nodes}"
    moved = 0
    for name, mesh in meshes.items():
        other = dented_meshes[name]
        for key in ("materials", "faces by material", "corners", "UVs"):
            assert mesh[key] == other[key], f"{dented}: {name!r} has other {key} than in {source}"
        distances = [(a - b).length for a, b in zip(mesh["positions"], other["positions"], strict=True)]
        count = sum(distance > 1e-4 for distance in distances)
        assert count == 0 or other["shape keys"] == 0, f"{dented}: {name!r} moved and still has its shape keys"
        moved += count
    assert moved > 0, f"{dented}: no vertex differs from {source}; where is the dent?"
    print(f"Blender {bpy.app.version_string} opens {dented}: {len(nodes)} nodes, {moved} vertices moved, the rest as it was")


arguments = sys.argv[1:]
for pair in zip(arguments[::2], arguments[1::2], strict=True):
    compare(*pair)
