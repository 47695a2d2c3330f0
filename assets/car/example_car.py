"""Writes the car with examples of dents, from what strike_car.py left:

    python example_car.py HITS_FOLDER OUT.glb

OUT.glb has the parts of car.glb with fewer vertices, and a morph target for each blow on each part that it moves. Parts of the skin follow the
solver's shell. What is mounted on the skin moves with the place behind it, what lies inside moves the less the further it is from the skin, and
wheels stay."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import glb
import make_car
import numpy as np
from crumple.examples import shell as shells
from crumple.examples.run import quiet
from panels import left_half
from scipy.spatial import cKDTree

SIZE = 0.045
"""Metres between vertices of the skin."""
LEAST = 4e-4
"""m; smaller displacements are faded out."""
INSIDE = 0.45
"""m; what lies deeper behind the skin does not move."""
REACH = 0.5
"""m; parts further from the solver's shell do not move."""


# Wheels and wipers move on their own, and nothing dents the seats. What breaks instead of denting is glass.
KINDS = {"moving": ("wheel", "wipers", "interior"), "glass": ("glass", "glass_clear")}


def kinds(nodes):
    """What is no plain sheet, by the names of nodes and materials."""
    found = {name: "moving" for name, _ in nodes if name.startswith(KINDS["moving"])}
    return found | {name: "glass" for name in KINDS["glass"]}


def parts():
    """The nodes of the car, and which of them are cut from the skin."""
    skin, made = left_half(SIZE), make_car.Parts()
    make_car.skin_parts(made, skin)
    cut = set(made.nodes)
    make_car.mounted_parts(made, fine=False)
    return made.list(), cut


def read(path):
    with np.load(path) as file:
        hit = SimpleNamespace(**{key: file[key] for key in file.files if key != "told"}, **json.loads(str(file["told"])))
    solid = shells.Shell(hit.shell, hit.triangles, hit.held, float(np.linalg.norm(hit.shell[hit.triangles[:, 0]] - hit.shell[hit.triangles[:, 1]], axis=1).mean()), [])
    return hit, solid


def moved(hit, solid, points, skin):
    """The displacements of points; `skin` says that they are cut from the skin."""
    out = np.zeros_like(points)
    near = np.flatnonzero(cKDTree(hit.shell).query(points, distance_upper_bound=REACH)[0] < REACH)
    if len(near) == 0:
        return out
    carrier = shells.Carrier(solid, points[near])
    if skin:
        out[near] = carrier.field(hit.field)
    else:
        depth = -np.einsum("ij,ij->i", carrier.off, solid.normals[carrier.corners[:, 0]])
        share = np.clip(1 - np.maximum(depth, 0) / INSIDE, 0, 1)
        out[near] = share[:, None] * np.einsum("nk,nki->ni", carrier.weights, hit.field[carrier.corners])
    return out


def impact(hit):
    """The entry of extras.impacts, as docs/impacts.md describes it."""
    numbers = lambda values: [float(f"{value:.7g}") for value in values]  # noqa: E731
    striker = {"mass": hit.mass, "radius": hit.radius, "velocity": numbers(hit.velocity), "shape": hit.shape}
    normal = hit.normal / np.linalg.norm(hit.normal)
    return {"name": hit.name, "point": numbers(hit.point), "normal": numbers(normal), "impulse": numbers(hit.impulse), "duration": hit.duration, "striker": striker}


def main():
    folder, out = Path(sys.argv[1]), Path(sys.argv[2])
    nodes, cut = parts()
    hits = [read(path) for path in sorted(folder.glob("*.npz"))]
    if not hits:
        raise SystemExit(f"{folder} has no hits; make them with strike_car.py")
    points = [[glb.to_gltf(p[1]).astype(float) for p in primitives] for _, primitives in nodes]
    targets = {name: [] for name, _ in nodes}
    for hit, solid in hits:
        for (name, primitives), own in zip(nodes, points):
            if name.startswith(KINDS["moving"]):
                continue
            field = quiet(moved(hit, solid, np.concatenate(own), name in cut), LEAST)
            if field.any():
                pieces = np.split(field, np.cumsum([len(one) for one in own])[:-1])
                targets[name].append((hit.name, impact(hit), pieces))
        print(hit.name, f"{1000 * np.linalg.norm(hit.field, axis=1).max():.0f} mm", flush=True)
    glb.write(out, nodes, targets=targets, kinds=kinds(nodes))
    print(f"{out}: {len(hits)} examples, {sum(len(p) for some in points for p in some)} vertices, {out.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
