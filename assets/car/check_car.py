"""Checks the files that make_car.py wrote (numpy): python3 check_car.py FOLDER

It reads the files again, as any program would, and fails with the first thing that is wrong."""

import json
import struct
import sys
from pathlib import Path

import numpy as np

import packing
import shape
from make_car import EXPECTED

PARTS = (
    "hood trunk roof bumper_front bumper_rear grille windscreen rear_window chassis interior plate_front plate_rear wipers".split()
    + [f"{name}_{side}" for name in "body fender door_front door_rear window headlamp taillamp mirror wheel_front wheel_rear".split() for side in ("left", "right")]
)
PANELS = ("hood", "trunk", "roof", "body", "fender", "door", "bumper", "window", "windscreen", "rear_window")
ALONE = ("interior", "wipers", "chassis", "antenna")  # not symmetric to the last bit: nets, and what is on one side
TYPES = {5126: "<f4", 5123: "<u2", 5125: "<u4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}


def read(path):
    """Each node's primitives as (vertices, normals, texture coordinates, triangles), x forward, y left, z up."""
    data = path.read_bytes()
    size = struct.unpack("<I", data[12:16])[0]
    g, body = json.loads(data[20 : 20 + size]), data[28 + size :]

    def array(i):
        a = g["accessors"][i]
        width = WIDTHS[a["type"]]
        at = g["bufferViews"][a["bufferView"]]["byteOffset"]
        return np.frombuffer(body, TYPES[a["componentType"]], a["count"] * width, at).reshape(-1, width)

    nodes = {}
    for node in g["nodes"]:
        nodes[node["name"]] = []
        for p in g["meshes"][node["mesh"]]["primitives"]:
            a = p["attributes"]
            v, n = (array(a[key])[:, [2, 0, 1]].astype(float) for key in ("POSITION", "NORMAL"))
            nodes[node["name"]].append((v, n, array(a["TEXCOORD_0"]), array(p["indices"]).reshape(-1, 3).astype(int)))
    return nodes, g


def require(good, text):
    if not good:
        raise SystemExit(f"check_car.py: {text}")


def vertices(node):
    return np.concatenate([p[0] for p in node])


def positions(v):
    """Each position once, in order, to a hundredth of a millimetre."""
    return np.unique(np.round(v * 1e5).astype(int), axis=0)


def meshes(name, nodes):
    """No empty triangles, unit normals that agree with the triangles, texture coordinates in the unit square."""
    for part, primitives in nodes.items():
        for v, n, uv, t in primitives:
            where = f"{name}, {part}"
            require(np.isfinite(v).all() and t.max() < len(v), f"{where}: vertices or indices are broken")
            f = np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]])
            area = np.linalg.norm(f, axis=1) / 2
            require(area.min() > 1e-11, f"{where}: a triangle of {area.min():.2e} m2")
            require(np.abs(np.linalg.norm(n, axis=1) - 1).max() < 1e-4, f"{where}: a normal is not a unit vector")
            turned = (f * n[t].sum(1)).sum(1) < 0
            allowed = 0.04 if name == "coarse" else 0.003  # slivers beside cuts
            require(area[turned].sum() < allowed * area.sum(), f"{where}: normals and triangles disagree on {area[turned].sum() / area.sum():.1%} of the area")
            require(uv.min() >= 0 and uv.max() <= 1, f"{where}: texture coordinates leave the unit square")


def outward(nodes):
    for part, primitives in nodes.items():
        if part.startswith(PANELS):
            for v, n, _, _ in primitives:
                axis = np.stack([np.clip(v[:, 0], -1.5, 1.3), 0 * v[:, 0], np.full(len(v), 0.6)], 1)
                require(((v - axis) * n).sum(1).mean() > 0, f"{part}: its normals point inwards")


def symmetric(nodes):
    flip = np.array([1, -1, 1])
    for part, primitives in nodes.items():
        if part.endswith("_left"):
            other = vertices(nodes[part.replace("_left", "_right")])
        elif part.endswith("_right") or part.startswith(ALONE):
            continue
        else:
            other = vertices(primitives)
        a, b = positions(vertices(primitives)), positions(other * flip)
        require(len(a) == len(b) and np.abs(a - b).max() <= 1, f"{part}: the sides differ")


def welded(primitives):
    """Vertices by position, and triangles of them."""
    v, t, first = [], [], 0
    for p in primitives:
        v.append(p[0])
        t.append(p[3] + first)
        first += len(p[0])
    v, t = np.concatenate(v), np.concatenate(t)
    at, index = np.unique(v, axis=0, return_inverse=True)
    return at, index.ravel()[t]


def border(t):
    """Directed edges without an opposite."""
    edges = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    there = {tuple(e) for e in edges.tolist()}
    require(len(there) == len(edges), "an edge belongs to two triangles on the same side")
    return np.array([e for e in there if e[::-1] not in there]).reshape(-1, 2)


def closed(name, primitives):
    v, t = welded(primitives)
    require(len(border(t)) == 0, f"{name} is not closed")
    p = v[t]
    volume = np.einsum("ij,ij->i", p[:, 0], np.cross(p[:, 1], p[:, 2])).sum() / 6
    require(volume > 1e-4, f"{name} has a volume of {volume:.2e} m3")
    return v


def unpacks(path):
    """The unpacked file has the bounds that the packed one says."""
    data = packing.unpacked(path.read_bytes())
    size = int.from_bytes(data[12:16], "little")
    g, body = json.loads(data[20 : 20 + size]), data[28 + size :]
    for a in g["accessors"]:
        # A morph target's other vertices do not move.
        view, count = (a["sparse"]["values"], a["sparse"]["count"]) if "sparse" in a else (a, a["count"])
        if "min" not in a or "bufferView" not in view:
            continue
        at = g["bufferViews"][view["bufferView"]]["byteOffset"] + view.get("byteOffset", 0)
        v = np.frombuffer(body, "<f4", 3 * count, at).reshape(-1, 3)
        v = np.concatenate([v, np.zeros((int(count < a["count"]), 3))])
        require((v.min(0) == a["min"]).all() and (v.max(0) == a["max"]).all(), f"{path.name} unpacks to other bounds: {v.min(0)}, {v.max(0)}")


def main():
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    folder = Path(sys.argv[1])
    car, g = read(folder / "car.glb")
    coarse, _ = read(folder / "car_coarse.glb")
    skin, _ = read(folder / "car_body.glb")
    inner, _ = read(folder / "car_inner.glb")
    collider, _ = read(folder / "car_collider.glb")
    for name, nodes in (("car", car), ("coarse", coarse), ("body", skin), ("inner", inner), ("collider", collider)):
        meshes(name, nodes)
    for part in PARTS:
        require(part in car, f"there is no part {part}")
    require(list(coarse) == list(car), "the coarse level has other parts")
    total, few = (sum(len(vertices(n)) for n in nodes.values()) for nodes in (car, coarse))
    require(60_000 <= total <= 120_000, f"the car has {total} vertices")
    require(few < 0.35 * total, f"the coarse level has {few} of {total} vertices")
    for part in PANELS[:3]:
        for end in (np.min, np.max):
            apart = np.abs(end(vertices(car[part]), axis=0) - end(vertices(coarse[part]), axis=0)).max()
            require(apart < 0.03, f"{part} of the coarse level is {apart:.3f} m away from the fine one's")
    paints = [m["name"] for m in g["materials"] if m["name"].startswith("paint")]
    require(len(paints) == 2, f"the paints are {paints}")
    outward(car)
    symmetric(car)
    # The body's skin ends only at the wheel arches.
    v, t = welded(skin["body"])
    edge = v[np.unique(border(t))]
    r = np.min([np.hypot(edge[:, 0] - x, edge[:, 2] - shape.WHEEL_RADIUS) for x in shape.AXLES], 0)
    open_elsewhere = (np.abs(r - shape.ARCH_RADIUS) > 0.01) & ~((np.abs(np.abs(edge[:, 1]) - 0.5) < 0.02) & (r < shape.ARCH_RADIUS))
    require(not open_elsewhere.any(), f"the body is open at {edge[open_elsewhere][:3]}")
    for name, primitives in inner.items():
        v = closed(name, primitives)
        out = shape.car(v).max()
        require(out < -0.012, f"{name} reaches within {-out * 1000:.0f} mm of the skin")
    for name, primitives in collider.items():
        closed(name, primitives)
    told = json.loads((folder / "car.json").read_text())["proportions"]
    for key, (low, high) in EXPECTED.items():
        require(low <= told[key] <= high, f"{key} is {told[key]}")
    low, high = vertices(car["hood"]).min(0), vertices(car["trunk"]).max(0)
    require(low[0] > 0 > high[0], "the hood is not in front of the trunk")
    unpacks(Path(__file__).with_name("car_dents.glb"))
    print(f"the car is as it should be: {len(car)} parts, {total} vertices; {few} in the coarse level; {len(inner)} closed inner solids")


main()
