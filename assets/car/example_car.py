"""Writes the car with examples of dents, from what strike_car.py left:

    python example_car.py HITS_FOLDER OUT_FOLDER

OUT_FOLDER/car_dents.glb has the parts of car.glb with fewer vertices, and a morph target for each blow on each part that it moves. Parts of the skin follow the
solver's shell. What is mounted on the skin moves with the place behind it, what lies inside moves the less the further it is from the skin, and
wheels stay. OUT_FOLDER/crash.json is a list of impacts for the demo: some of the blows, and twenty stones at random places."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import glb
import make_car
import numpy as np
from crumple.examples import shell as shells
from crumple.examples.run import quiet
from panels import left_half, mirrored
from scipy.spatial import cKDTree

SIZE = 0.045
"""Metres between vertices of the skin."""
CRASH = (
    ("a pole in the front", "front pole 2", None, None), ("a pole in the rear door", "side pole 4", None, None), ("a ball in the front door", "side ball 1", None, None),
    ("a wall's edge in the corner", "front edge 1", (0.66, 0.5, 2.08), (0.35, 0.0, 1.0)), ("a ball on the hood", "hood ball 1", (0.42, 0.93, 1.35), (0.1, 1.0, 0.1)),
    ("a ball on the roof", "roof ball 2", None, None),
)  # fmt: skip
"""What hits the car in the demo: a name, the blow of an example, and another place and normal for it."""
STONES, SEED = 20, 35
LEAST = 4e-4
"""m; smaller displacements are faded out."""
INSIDE = 0.45
"""m; what lies deeper behind the skin does not move."""
REACH = 0.5
"""m; parts further from the solver's shell do not move."""


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


def crash(hits, nodes):
    """The demo's impacts: blows of CRASH, and stones at random places of the sheet that is seen from the front and the left."""
    by_name = {hit.name: impact(hit) for hit, _ in hits}
    out = []
    for name, blow, place, normal in CRASH:
        one = {**by_name[blow], "striker": dict(by_name[blow]["striker"]), "name": name}
        if place:
            n = np.array(normal) / np.linalg.norm(normal)
            along = lambda v: [float(f"{x:.5g}") for x in -np.linalg.norm(v) * n]  # noqa: B023, E731
            one |= {"point": list(place), "normal": n.round(4).tolist(), "impulse": along(one["impulse"])}
            one["striker"]["velocity"] = along(one["striker"]["velocity"])
        out.append(one)
    stone = next((impact(hit) for hit, _ in hits if hit.name.startswith("stone")), None)
    if stone is None:
        return out
    random = np.random.default_rng(SEED)
    panels = ("hood", "roof", "door_front_left", "door_rear_left", "fender_left", "body_left")
    sheet = [p for name, primitives in nodes if name in panels for p in primitives if p[0].startswith("paint")]
    points, normals = (np.concatenate([glb.to_gltf(p[k]) for p in sheet]) for k in (1, 2))
    # Not the borders that are folded inwards, nor what looks down or back.
    seen = np.flatnonzero((normals @ np.array([0.6, 0.6, 0.5]) > 0.35) & (points[:, 1] > 0.4))
    weight = np.linalg.norm(stone["striker"]["velocity"]) * random.uniform(1.2, 2.4, STONES)
    for k, v in enumerate(random.choice(seen, STONES, replace=False)):
        n = normals[v] / np.linalg.norm(normals[v])
        size = np.linalg.norm(stone["impulse"]) * weight[k] / np.linalg.norm(stone["striker"]["velocity"])
        numbers = lambda values: [float(f"{value:.5g}") for value in values]  # noqa: E731
        striker = stone["striker"] | {"velocity": numbers(-weight[k] * n)}
        out.append({"name": f"stone {k + 1}", "point": numbers(points[v]), "normal": numbers(n), "impulse": numbers(-size * n), "striker": striker})
    for one in out:
        one.pop("duration", None)
        one["striker"].pop("shape", None)
    return out


def main():
    folder, out = Path(sys.argv[1]), Path(sys.argv[2]) / "car_dents.glb"
    nodes, cut = parts()
    hits = [read(path) for path in sorted(folder.glob("*.npz"))]
    if not hits:
        raise SystemExit(f"{folder} has no hits; make them with strike_car.py")
    points = [[glb.to_gltf(p[1]).astype(float) for p in primitives] for _, primitives in nodes]
    targets = {name: [] for name, _ in nodes}
    for hit, solid in hits:
        for (name, primitives), own in zip(nodes, points):
            if name.startswith(KINDS["rigid"] + KINDS["moving"]):
                continue
            field = quiet(moved(hit, solid, np.concatenate(own), name in cut), LEAST)
            if field.any():
                pieces = np.split(field, np.cumsum([len(one) for one in own])[:-1])
                targets[name].append((hit.name, impact(hit), pieces))
        print(hit.name, f"{1000 * np.linalg.norm(hit.field, axis=1).max():.0f} mm", flush=True)
    impacts = json.dumps(crash(hits, nodes))
    out.with_name("crash.json").write_text(impacts.replace('{"name"', '\n  {"name"').replace("]]", "]\n]") + "\n")
    glb.write(out, nodes, targets=targets, kinds=kinds(nodes))
    print(f"{out}: {len(hits)} examples, {sum(len(p) for some in points for p in some)} vertices, {out.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
