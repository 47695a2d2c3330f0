"""Reads a glTF with trimesh and writes it: as glTF, and as OBJ files of the mesh and of its examples.

trimesh_files.py IN.glb FOLDER
"""

import sys
from pathlib import Path

import numpy as np
import pygltflib
import trimesh

source, folder = map(Path, sys.argv[1:])
folder.mkdir(parents=True, exist_ok=True)
scene = trimesh.load_scene(source)
scene.export(folder / "scene.glb")

# trimesh does not read morph targets.
file = pygltflib.GLTF2().load(str(source))
(body,) = file.meshes
primitive = body.primitives[0]


def array(index):
    accessor = file.accessors[index]
    out = np.zeros((accessor.count, 3), np.float32)

    def read(view, kind, count, offset, width):
        at = file.bufferViews[view].byteOffset + (offset or 0)
        return np.frombuffer(file.binary_blob(), kind, count * width, at).reshape(count, width)

    if accessor.bufferView is not None:
        out = read(accessor.bufferView, np.float32, accessor.count, accessor.byteOffset, 3).copy()
    if accessor.sparse is not None:
        rows, values = accessor.sparse.indices, accessor.sparse.values
        kind = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32}[rows.componentType]
        at = read(rows.bufferView, kind, accessor.sparse.count, rows.byteOffset, 1).ravel()
        out[at] = read(values.bufferView, np.float32, accessor.sparse.count, values.byteOffset, 3)
    return out


(part, *_) = scene.geometry.values()
base = array(primitive.attributes.POSITION)
trimesh.Trimesh(base, part.faces, process=False).export(folder / "plain.obj")
for name, target in zip(body.extras["targetNames"], primitive.targets, strict=True):
    trimesh.Trimesh(base + array(target["POSITION"]), part.faces, process=False).export(folder / f"plain_{name}.obj")
