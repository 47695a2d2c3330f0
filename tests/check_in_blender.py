"""Opens glTF files in Blender and prints what is in them, one JSON object a file, each behind a line 'FILE '.

Needs the `bpy` package (pip install bpy==5.0.1, Python 3.11). Exit code 3 where it is not there.
"""

import json
import os
import sys

try:
    import bpy
except ImportError as error:
    print("bpy is not installed:", error, file=sys.stderr)
    sys.exit(3)


def rounded(values):
    return [round(x, 4) + 0.0 for x in values]


def mesh(data):
    uvs = {}
    for layer in data.uv_layers:
        flat = [0.0] * (len(data.loops) * 2)
        layer.data.foreach_get("uv", flat)
        uvs[layer.name] = rounded(flat)
    return {
        "vertices": len(data.vertices),
        "triangles": len(data.polygons),
        "materials": [m.name if m else None for m in data.materials],
        "material_of_each": [p.material_index for p in data.polygons],
        "uvs": uvs,
    }


def describe():
    objects = {}
    for thing in bpy.context.scene.objects:
        objects[thing.name] = {
            "kind": thing.type,
            "parent": thing.parent.name if thing.parent else None,
            "matrix": rounded(x for row in thing.matrix_world for x in row),
            "mesh": mesh(thing.data) if thing.type == "MESH" else None,
            "properties": {k: str(v) for k, v in thing.items() if k != "_RNA_UI"},
        }
    return {
        "objects": objects,
        "images": {i.name: list(i.size) for i in bpy.data.images if i.name != "Render Result"},
        "actions": sorted(a.name for a in bpy.data.actions),
    }


for path in sys.argv[1:]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=os.path.abspath(path))
    print("FILE " + json.dumps(describe()), flush=True)
