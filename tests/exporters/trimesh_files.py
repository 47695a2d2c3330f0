"""Reads a glTF with trimesh and writes it: as glTF, and as OBJ files of the mesh and of the same dents as in blender.py.

trimesh_files.py IN.glb FOLDER
"""

import sys
from pathlib import Path

import numpy as np
import trimesh

source, folder = map(Path, sys.argv[1:])
folder.mkdir(parents=True, exist_ok=True)
scene = trimesh.load_scene(source)
scene.export(folder / "scene.glb")

# trimesh does not read morph targets. In glTF y is up, and z is Blender's -y.
(part, *_) = scene.geometry.values()
trimesh.Trimesh(part.vertices, part.faces, process=False).export(folder / "plain.obj")
for name, (x, z), depth in [("Left", (-0.2, 0.0), 0.05), ("Right", (0.25, -0.1), 0.03)]:
    away = np.hypot(part.vertices[:, 0] - x, part.vertices[:, 2] - z)
    down = np.outer(np.maximum(0.0, 1.0 - away / 0.15), [0.0, depth, 0.0])
    trimesh.Trimesh(part.vertices - down, part.faces, process=False).export(folder / f"plain_{name}.obj")
