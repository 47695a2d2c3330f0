"""Strikes the car with MuJoCo, one blow after the other, and keeps what each leaves:

    python strike_car.py CAR_FOLDER HITS_FOLDER [--jobs 2] [--only NAME ...]

CAR_FOLDER is what make_car.py wrote, HITS_FOLDER gets a file for each blow; those that are there are not made again. The solver is that of
`crumple examples` (the Python package in bindings/python). A shell of the whole car would have edges of 13 cm at a cost of four seconds a
blow, so each blow has a shell of its own: the part of the skin around it. It is held where it was cut. Engine, cabin floor,
dashboard and axles stand behind it as rigid solids. The blows are a table, and others that vary those of the table by a fixed seed. Each is
tried once: its energy is a guess from the depth that is meant, and the dent that comes is kept.
"""

import argparse
import json
import time
from concurrent.futures import ProcessPoolExecutor
from copy import copy
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from crumple.examples import inner, remesh, run, shell
from crumple.examples.body import Body
from crumple.examples.flight import Blow
from crumple.examples.materials import MATERIALS
from crumple.examples.solver import Solver
from scipy.spatial import cKDTree
from scipy.stats import qmc

MATERIAL, THICKNESS = "steel", 0.0008
POINTS = 1000
"""Of a shell."""
# The solids of car_inner.glb that no blow bends. Sills, pillars, roof frames and bumper beams give way in a crash.
RIGID = ("engine", "cell", "dashboard", "axle_front", "axle_rear")
EXPONENT = 1.2
"""Energy grows with this power of the depth."""
STIFFNESS = {
    "front pole": 230, "side pole": 360, "rear pole": 250, "front edge": 260, "side edge": 360, "rear edge": 270, "front wall": 400, "side wall": 600,
    "rear wall": 500, "front corner": 180, "side corner": 310, "rear corner": 250, "roof corner": 80, "stone": 18, "hail": 20,
}  # fmt: skip
OTHER = 80.0
"""A guess of a blow's energy by depth ** EXPONENT and by the sheet's strength, from trials."""
WORST = 0.3
"""m; the deepest displacement of an example."""
DRAWN, SEED = 320, 35
"""Blows beside the table's."""
PLACE, DEPTH, TURN, RADIUS = 0.28, (0.35, 1.15), 25.0, 0.35
"""How a drawn blow may differ from one of the table: by this share of the shell's reach along each axis, by factors of the depth, by degrees of the
flight, by a factor of e to this power of the radius."""


@dataclass(frozen=True)
class Wanted:
    name: str
    shape: str
    aim: tuple[float, float, float]
    """Left, up, forward; the nearest point of the skin is meant."""
    radius: float
    """m"""
    depth: float
    """m"""
    reach: float
    """Of the shell around the aim, m."""
    turn: float = 0.0
    """Degrees between flight and the skin's normal, about the vertical; for balls above the belt about the car's length."""
    normal: tuple[float, float, float] | None = None
    spin: float = 0.0

    @property
    def kind(self):
        return self.name.rsplit(" ", 1)[0]


def table():
    """The blows, all on the left half or in the middle: the library mirrors them."""
    out = []

    def add(kind, shape, radius, reach, *blows):
        for aim, depth, *more in blows:
            out.append(Wanted(f"{kind} {sum(one.name.startswith(kind) for one in out) + 1}", shape, aim, radius, depth, reach, *more))

    front, rear = (0, 0, 1), (0, 0, -1)
    # A lamp post and a tree, a wall's edge, a flat wall, another car's corner, a ball as large as its bumper; then what is small.
    add("side pole", "pole", 0.13, 1.05, ((0.9, 0.6, 0.25), 0.10), ((0.9, 0.6, 0.05), 0.20), ((0.9, 0.6, -0.65), 0.09), ((0.9, 0.6, -0.75), 0.18), ((0.9, 0.6, -1.75), 0.12), ((0.9, 0.6, 0.85), 0.13))
    add("front edge", "pole", 0.05, 1.05, ((0.2, 0.5, 2.2), 0.15, 0, front), ((0.55, 0.5, 2.1), 0.24, 0, front), ((0.72, 0.5, 1.95), 0.12, 20))
    small = (((0.1, 0.95, 1.4), 0.016), ((0.5, 0.93, 1.5), 0.024), ((0.25, 0.88, 1.9), 0.010), ((0.88, 0.75, 0.2), 0.020), ((0.9, 0.6, -0.5), 0.028), ((0.9, 0.85, -1.6), 0.014), ((0.85, 0.8, 1.6), 0.016), ((0.1, 1.45, -0.1), 0.016), ((0.45, 1.42, -0.4), 0.026), ((0.2, 1.1, -1.95), 0.018))
    add("stone", "ball", 0.06, 0.35, *small)
    add("front corner", "corner", 0.5, 1.1, ((0.55, 0.55, 2.1), 0.14), ((0.25, 0.72, 2.1), 0.10), ((0.80, 0.72, 1.75), 0.12))
    add("hood ball", "ball", 0.18, 0.9, ((0.0, 0.95, 1.5), 0.07), ((0.45, 0.95, 1.25), 0.05), ((0.3, 0.9, 1.8), 0.09))
    add("rear pole", "pole", 0.13, 1.05, ((0, 0.6, -2.3), 0.13, 0, rear), ((0.4, 0.6, -2.25), 0.22, 0, rear))
    add("side ball", "ball", 0.25, 1.0, ((0.9, 0.6, 0.15), 0.09), ((0.9, 0.55, -0.6), 0.14), ((0.9, 0.75, -1.75), 0.10), ((0.9, 0.7, 1.75), 0.07))
    add("front pole", "pole", 0.13, 1.1, ((0, 0.5, 2.2), 0.14, 0, front), ((0, 0.5, 2.2), 0.20, 0, front), ((0.35, 0.5, 2.2), 0.10, 0, front), ((0.38, 0.5, 2.2), 0.22, 8, front), ((0.62, 0.5, 2.1), 0.16, 0, front))
    add("roof ball", "ball", 0.2, 1.0, ((0.0, 1.45, -0.3), 0.07), ((0.4, 1.42, 0.1), 0.10), ((0.55, 1.15, -0.75), 0.08))
    add("side corner", "corner", 0.5, 1.0, ((0.9, 0.62, 0.3), 0.10), ((0.9, 0.7, -0.5), 0.15), ((0.9, 0.55, -1.75), 0.10), ((0.9, 0.55, 0.75), 0.06))
    add("rear corner", "corner", 0.5, 1.0, ((0.6, 0.6, -2.2), 0.13), ((0.15, 0.85, -2.25), 0.09))
    add("side edge", "pole", 0.05, 1.05, ((0.9, 0.6, 0.45), 0.12), ((0.9, 0.6, -0.45), 0.16, 15), ((0.9, 0.6, -1.9), 0.10))
    add("front ball", "ball", 0.22, 1.0, ((0.0, 0.6, 2.2), 0.10), ((0.55, 0.5, 2.1), 0.13), ((0.82, 0.7, 1.75), 0.08))
    add("rear ball", "ball", 0.22, 1.0, ((0.0, 0.7, -2.3), 0.09), ((0.7, 0.6, -2.1), 0.11), ((0.3, 1.05, -1.95), 0.07))
    add("front wall", "wall", 5.0, 1.15, ((0, 0.5, 2.2), 0.10, 0, front), ((0.5, 0.5, 2.1), 0.14, 0, (0.35, 0, 1)))
    add("rear edge", "pole", 0.05, 1.1, ((0.55, 0.6, -2.2), 0.15, 0, rear),)
    add("side wall", "wall", 5.0, 1.05, ((0.9, 0.65, -0.2), 0.07, 0, (1, 0, 0)))
    add("rear wall", "wall", 5.0, 1.05, ((0.3, 0.6, -2.3), 0.10, 0, rear),)
    add("roof corner", "corner", 0.4, 1.0, ((0.15, 1.45, -0.2), 0.10), ((0.6, 1.33, 0.1), 0.09, 0, None, 0.6))
    add("hail", "ball", 0.03, 0.22, ((0.2, 0.95, 1.4), 0.006), ((0.5, 0.93, 1.4), 0.009), ((0.1, 1.45, -0.3), 0.006), ((0.45, 1.42, -0.1), 0.010), ((0.3, 1.1, -1.95), 0.007))
    return out


def drawn(base):
    """Further blows: those of the table in turn, each at another place, with another energy, direction and radius."""
    count = {}
    for one in base:
        count[one.kind] = count.get(one.kind, 0) + 1
    order = np.random.default_rng(SEED).permutation(len(base))
    out = []
    for k, u in enumerate(qmc.Sobol(7, seed=SEED).random(DRAWN)):
        one = base[order[k % len(base)]]
        count[one.kind] += 1
        aim = np.array(one.aim) + PLACE * one.reach * (2 * u[:3] - 1)
        # The library mirrors the left half.
        aim[0] = abs(aim[0])
        low, high = DEPTH
        depth = one.depth * low * (high / low) ** u[3]
        turn, radius = one.turn + TURN * (2 * u[4] - 1), one.radius * np.exp(RADIUS * (2 * u[5] - 1))
        out.append(replace(one, name=f"{one.kind} {count[one.kind]}", aim=tuple(aim), radius=float(radius), depth=depth, turn=turn, spin=2 * np.pi * u[6]))
    return out


def patch(body, aim, reach, solids):
    """The shell of the skin around `aim`, before solids, and the point of it that is meant."""
    middles = body.points[body.triangles].mean(1)
    at = middles[np.linalg.norm(middles - aim, axis=1).argmin()]
    near = np.linalg.norm(middles - at, axis=1) < reach
    one = copy(body)
    one.triangles, one._materials = body.triangles[near], body._materials[near]
    made = shell.make(one, POINTS, "free")
    # Where the patch was cut out it is held. The rims of wheel arches are free.
    def rim(triangles):
        edges, uses = remesh.edges_of(triangles)
        return np.unique(edges[uses == 1])

    own = np.setdiff1d(rim(one.triangles), rim(body.triangles))
    border = rim(made.triangles)
    held = np.zeros(len(made.points), bool)
    held[border] = cKDTree(body.points[own]).query(made.points[border])[0] < 0.8 * made.edge
    made = replace(made, held=held)
    close = [s for s in solids if np.linalg.norm(np.clip(at, s.points.min(0), s.points.max(0)) - at) < reach]
    if close:
        room = inner.room(made.points, close)
        # What lies on a solid is fixed to it.
        made = replace(made, solids=inner.hulls(close)[0], room=room, held=made.held | (room < 0.1 * made.edge))
    return made, at


def strike(body, solids, wanted):
    """The shell, and what the blow left, or None."""
    made, at = patch(body, np.array(wanted.aim), wanted.reach, solids)
    material = MATERIALS[MATERIAL]
    solver = Solver(made, material, THICKNESS)
    vertex = int(np.where(made.held, np.inf, np.linalg.norm(made.points - at, axis=1)).argmin())
    normal = made.normals[vertex] if wanted.normal is None else np.array(wanted.normal, float)
    if wanted.shape == "pole":
        normal = normal * [1, 0, 1]
    normal = normal / np.linalg.norm(normal)
    angle = np.radians(wanted.turn)
    side = np.cross([0.0, 1.0, 0.0], normal)
    side /= max(np.linalg.norm(side), 1e-9)
    direction = -np.cos(angle) * normal + np.sin(angle) * side
    energy = STIFFNESS.get(wanted.kind, OTHER) * material.strength(THICKNESS) * wanted.depth**EXPONENT
    speed = 4.0 if energy < 200 else 7.0
    blow = Blow(made.points[vertex], normal, direction, speed, 2 * energy / speed**2, wanted.radius, wanted.shape, wanted.spin)
    result = run.strike(solver, 0, blow)
    depth = result.depth if result.made is None else float(np.linalg.norm(result.made.field, axis=1).max())
    print(
        f"{wanted.name}: {len(made.points)} points, edge {1000 * made.edge:.0f} mm, {energy:.0f} J, {result.trouble or 'good'}, "
        f"{1000 * depth:.0f} of {1000 * wanted.depth:.0f} mm, {result.steps} steps, {result.seconds:.1f} s",
        flush=True,
    )
    return made, result.made if depth < WORST else None


_state = {}


def start(folder):
    body = Body(folder / "car_body.glb")
    solids = inner.read([f"{folder / 'car_inner.glb'}/{name}" for name in RIGID], body, 1.0)
    _state.update(body=body, solids=solids)


def work(wanted, path):
    made, one = strike(_state["body"], _state["solids"], wanted)
    arrays = {}
    if one is not None:
        told = {key: getattr(one, key) for key in ("duration", "mass", "radius", "shape")} | {"name": wanted.name}
        arrays = {key: getattr(one, key) for key in ("field", "point", "normal", "impulse", "velocity")}
        arrays |= {"told": json.dumps(told), "shell": made.points, "triangles": made.triangles, "held": made.held}
    # A blow that failed leaves an empty file and is not made again.
    temporary = path.with_suffix(".part")
    with temporary.open("wb") as file:
        np.savez_compressed(file, **arrays)
    temporary.replace(path)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("car", type=Path)
    p.add_argument("hits", type=Path)
    p.add_argument("--jobs", type=int, default=2)
    p.add_argument("--only", nargs="+", metavar="NAME", help="blows whose names begin so")
    a = p.parse_args()
    a.hits.mkdir(parents=True, exist_ok=True)
    base = table()
    # The first of each kind first, so that an interrupted run has a bit of everything.
    blows = sorted(base, key=lambda one: int(one.name.rsplit(" ", 1)[1])) + drawn(base)
    todo = [(one, a.hits / f"{k:03}_{one.name.replace(' ', '_')}.npz") for k, one in enumerate(blows) if not a.only or one.name.startswith(tuple(a.only))]
    todo = [(one, path) for one, path in todo if not path.exists()]
    with ProcessPoolExecutor(a.jobs, initializer=start, initargs=(a.car,)) as pool:
        for future in [pool.submit(work, *one) for one in todo]:
            future.result()


if __name__ == "__main__":
    main()
