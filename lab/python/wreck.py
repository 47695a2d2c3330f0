"""Shoots at the panel and the tube again and again: `wreck.py SOURCE` writes SOURCE/shots/BODY/wreck.npz for store.py.

A wreck is one body after many shots, each at a random place of what the earlier ones left.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from grids import Floats, Grid, vertex_normals
from mujoco_shell import SHOTS, Impact, Shell, truth_grid

SHOTS_A_BODY = 64
KEPT = (1, 4, 16, 64)
"""The surface is kept after so many shots."""
SEEDS = {"panel": 911, "tube": 912}
SPEEDS = {"panel": (4.5, 10.2), "tube": (5.3, 16.3)}
"""The middle part of the other shots' speeds, m/s."""
RADII = (0.08, 0.15)
RIM = 0.15
"""No shot is nearer to a held edge, m."""
TILT = np.radians(40)
DT = 1e-3
LEAST, MOST = 4e-3, 0.4
"""Shots that leave less on an undamaged sheet are no hits, and sheets that moved further have failed, m."""


def shot(grid: Grid, normals: Floats, speeds: tuple[float, float], dice: np.random.Generator) -> Impact:
    """A shot at a random place, against the normal of the undamaged sheet there, tilted to any side."""
    vertices = grid.vertices()
    away = np.abs(vertices[:, 2]) < 0.45 - RIM if grid.wraps else (np.abs(vertices[:, :2]) < np.array([0.6, 0.45]) - RIM).all(1)
    vertex = int(dice.choice(np.flatnonzero(away)))
    normal, tilt, turn = normals[vertex], TILT * dice.random(), 2 * np.pi * dice.random()
    aside = np.cross(normal, [0.3, 0.5, 0.8])
    aside /= np.linalg.norm(aside)
    lean = np.cos(turn) * aside + np.sin(turn) * np.cross(normal, aside)
    direction = np.sin(tilt) * lean - np.cos(tilt) * normal
    speed = float(np.exp(dice.uniform(*np.log(speeds))))
    return Impact(vertex, vertices[vertex], normal, direction, speed, float(dice.uniform(*RADII)))


def wreck(body: str) -> dict[str, np.ndarray]:
    """The shots, and the displacements after those of KEPT."""
    grid = truth_grid("shots", body)
    normals = vertex_normals(grid.vertices(), grid.triangles())
    worn, fresh = Shell(grid, SHOTS, DT), Shell(grid, SHOTS, DT)
    dice = np.random.default_rng(SEEDS[body])
    impacts: list[Impact] = []
    fields: list[Floats] = []
    while len(impacts) < SHOTS_A_BODY:
        impact = shot(grid, normals, SPEEDS[body], dice)
        alone = fresh.hit(impact).field
        if alone is None or np.linalg.norm(alone[impact.vertex]) < LEAST:
            continue
        surface = grid.vertices() if not impacts else grid.vertices() + fields[-1]
        now = replace(impact, point=surface[impact.vertex], normal=vertex_normals(surface, grid.triangles())[impact.vertex])
        field = worn.hit(now, worn=bool(impacts)).field
        if field is None or np.linalg.norm(field, axis=1).max() > MOST:
            raise SystemExit(f"{body}: the sheet failed at shot {len(impacts) + 1}; choose another seed")
        impacts.append(impact)
        fields.append(field)
        print(f"{body}: shot {len(impacts)}, deepest {1e3 * np.linalg.norm(field, axis=1).max():.0f} mm", flush=True)
    return {
        "after": np.array(KEPT),
        "fields_after": np.array([fields[n - 1] for n in KEPT], np.float32),
        "contact_vertex": np.array([i.vertex for i in impacts]),
        "contact_point": np.array([i.point for i in impacts], np.float32),
        "direction": np.array([i.direction for i in impacts], np.float32),
        "speed": np.array([i.amount for i in impacts]),
        "radius": np.array([i.radius for i in impacts]),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", type=Path)
    parser.add_argument("--body", choices=SEEDS, action="append")
    options = parser.parse_args()
    for body in options.body or SEEDS:
        folder = options.source / "shots" / body
        folder.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(folder / "wreck.npz", **wreck(body))


if __name__ == "__main__":
    main()
