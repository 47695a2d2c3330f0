"""Writes the car with examples of dents, from what strike_car.py left:

    python example_car.py HITS_FOLDER OUT_FOLDER [COUNT]

OUT_FOLDER/car_dents.glb has the parts of car.glb with fewer vertices, and a morph target for each blow, or each of the first COUNT, on each part
that it moves. Parts of the skin follow the solver's shell. What is mounted on the skin moves with the place behind it, what lies inside moves the less the further it is from the skin, and
wheels stay. OUT_FOLDER/crash.json is a list of impacts for the demo: some of the blows, and stones and hail at random places."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import glb
import make_car
import numpy as np
from crumple.examples.body import point_normals
from crumple.examples.run import quiet
from panels import left_half, mirrored
from scipy.interpolate import RBFInterpolator
from scipy.spatial import cKDTree

SIZE = 0.026
"""Metres between vertices of the skin."""
CRASH = (("a pole in the front", "front pole 2"), ("a wall's corner in the rear door", "side corner 2"))
"""What hits the car in the demo, and the blow of which example it is."""
RAIN = (
    ("stone", 20, 0.7, (0.6, 0.6, 0.5), ("hood", "roof", "door_front_left", "door_rear_left", "fender_left", "body_left")),
    ("hail", 40, 0.75, (0.0, 1.0, 0.0), ("hood", "roof", "trunk")),
)  # fmt: skip
"""And what hits it at random places of these parts, squarely and with the striker of an example: its kind, how many, and at least how squarely
the place looks into a direction."""
SEED = 35
LEAST = 4e-4
"""m; smaller displacements are faded out."""
INSIDE = 0.45
"""m; what lies deeper behind the skin does not move."""
REACH = 0.5
"""m; parts further from the solver's shell do not move."""
AROUND = 13
"""Points of the shell that tell where a point of the car lies above it; the last one has no weight."""
SMOOTHING = 0.5
"""Of the displacements, which then are off by 1 to 2 mm at the shell's points: what is smaller than its edges is evened out."""


# Wheels never dent. Wipers and seats are no part of the body. What breaks instead of denting is glass.
KINDS = {"rigid": ("wheel",), "moving": ("wipers", "interior"), "glass": ("glass", "glass_clear")}


def kinds(nodes):
    """What is no plain sheet, by the names of nodes and materials."""
    found = {name: kind for kind in ("rigid", "moving") for name, _ in nodes if name.startswith(KINDS[kind])}
    return found | {name: "glass" for name in KINDS["glass"]}


def parts():
    """The nodes of the car, and which of them are cut from the skin."""
    skin, made = left_half(SIZE), make_car.Parts()
    make_car.skin_parts(made, skin)
    cut = set(made.nodes)
    make_car.mounted_parts(made, fine=False)
    # The car is its own mirror image, which the library uses; so are its wheels here.
    for end in ("front", "rear"):
        left = made.nodes[f"wheel_{end}_left"]
        made.nodes[f"wheel_{end}_right"] = {name: [mirrored(*mesh) for mesh in some] for name, some in left.items()}
    return made.list(), cut


def read(path):
    """A hit and what carries its shell's displacements, or None if the file is empty, as those of blows that failed are."""
    with np.load(path) as file:
        if not file.files:
            return None
        hit = SimpleNamespace(**{key: file[key] for key in file.files if key != "told"}, **json.loads(str(file["told"])))
    hit.edge = np.linalg.norm(hit.shell[hit.triangles[:, 0]] - hit.shell[hit.triangles[:, 1]], axis=1).mean()
    hit.outward = point_normals(hit.shell, hit.triangles)
    # Lengths in edges of the shell.
    hit.tree = cKDTree(hit.shell / hit.edge)
    hit.smooth = RBFInterpolator(hit.shell / hit.edge, hit.field, kernel="cubic", smoothing=SMOOTHING)
    return hit


def moved(hit, points, skin):
    """The displacements of points; `skin` says that they are cut from the skin. They are those of the places on the shell that lie
    below or above the points, by a smooth function (cubic radial basis functions), so that the edges of the shell's triangles, which are
    longer than the car's, do not show."""
    out = np.zeros_like(points)
    points = points / hit.edge
    distance, near = hit.tree.query(points, k=AROUND)
    close = np.flatnonzero((distance[:, 0] < REACH / hit.edge) & hit.field[near].any((1, 2)))
    if len(close) == 0:
        return out
    points, distance, near = points[close], distance[close], near[close]
    weight = (1 - np.minimum(distance / distance[:, -1:], 1) ** 2) ** 3
    weight /= weight.sum(1, keepdims=True)
    outward = hit.outward[near]
    depth = np.einsum("nkj,nkj->nk", outward, hit.tree.data[near] - points[:, None])
    there = points + np.einsum("nk,nk,nkj->nj", weight, depth, outward)
    share = np.clip(2 - hit.tree.query(there)[0], 0, 1)
    if not skin:
        share *= np.clip(1 - hit.edge * np.maximum((weight * depth).sum(1), 0) / INSIDE, 0, 1)
    out[close] = share[:, None] * hit.smooth(there)
    return out


def impact(hit):
    """The entry of extras.impacts, as docs/impacts.md describes it."""
    number = lambda value: float(f"{value:.5g}")  # noqa: E731
    numbers = lambda values: [number(value) for value in values]  # noqa: E731
    striker = {"mass": number(hit.mass), "radius": number(hit.radius), "velocity": numbers(hit.velocity), "shape": hit.shape}
    normal = hit.normal / np.linalg.norm(hit.normal)
    told = {"name": hit.name, "point": numbers(hit.point), "normal": numbers(normal), "impulse": numbers(hit.impulse)}
    return told | {"duration": number(hit.duration), "striker": striker}


def crash(hits, nodes):
    """The demo's impacts: blows of CRASH, and stones and hail of RAIN at random places."""
    told = {hit.name: impact(hit) for hit in hits}
    out = [told[blow] | {"name": name} for name, blow in CRASH]
    random = np.random.default_rng(SEED)
    numbers = lambda values: [float(f"{x:.4g}") for x in values]  # noqa: E731
    for kind, count, squarely, towards, panels in RAIN:
        strikers = [told[hit.name]["striker"] for hit in hits if hit.name.rsplit(" ", 1)[0] == kind]
        sheet = [p for name, primitives in nodes if name in panels for p in primitives if p[0].startswith("paint")]
        points, normals = (np.concatenate([glb.to_gltf(p[k]) for p in sheet]) for k in (1, 2))
        # Not the borders that are folded inwards.
        seen = np.flatnonzero(normals @ np.array(towards) / np.linalg.norm(towards) > squarely)
        for k, v in enumerate(random.choice(seen, count, replace=False)):
            one = strikers[random.integers(len(strikers))]
            flies = numbers(-np.linalg.norm(one["velocity"]) * normals[v])
            out.append({"name": f"{kind} {k + 1}", "point": numbers(points[v]), "striker": one | {"velocity": flies}})
    return out


def main():
    folder, out = Path(sys.argv[1]), Path(sys.argv[2]) / "car_dents.glb"
    nodes, cut = parts()
    # In the order of the plan.
    hits = [hit for hit in map(read, sorted(folder.glob("*.npz"))) if hit][: int(sys.argv[3]) if len(sys.argv) > 3 else None]
    if not hits:
        raise SystemExit(f"{folder} has no hits; make them with strike_car.py")
    points = [[glb.to_gltf(p[1]).astype(float) for p in primitives] for _, primitives in nodes]
    targets = {name: [] for name, _ in nodes}
    still = KINDS["rigid"] + KINDS["moving"]
    vertices = cKDTree(np.concatenate([np.concatenate(own) for own in points]))
    kept = 0
    for hit in hits:
        fields = [
            np.zeros((sum(map(len, own)), 3)) if name.startswith(still) else quiet(moved(hit, np.concatenate(own), name in cut), LEAST)
            for (name, _), own in zip(nodes, points)
        ]
        # The library wants an example to move its own contact.
        if not np.concatenate(fields)[vertices.query(hit.point)[1]].any():
            print(f"{hit.name}: nothing is left at its contact")
            continue
        told, kept = impact(hit), kept + 1
        for (name, _), own, field in zip(nodes, points, fields):
            if field.any():
                # One part tells the blow for all.
                targets[name].append((hit.name, told, np.split(field, np.cumsum([len(one) for one in own])[:-1])))
                told = None
        print(hit.name, f"{1000 * np.linalg.norm(hit.field, axis=1).max():.0f} mm", flush=True)
    impacts = json.dumps(crash(hits, nodes))
    out.with_name("crash.json").write_text(impacts.replace('{"name"', '\n  {"name"').replace("]]", "]\n]") + "\n")
    glb.write(out, nodes, targets=targets, kinds=kinds(nodes))
    print(f"{out}: {kept} examples, {sum(len(p) for some in points for p in some)} vertices, {out.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
