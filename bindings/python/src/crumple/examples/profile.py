"""Generic dents without a solver: one round profile, as deep as wanted, spread over the body."""

from __future__ import annotations

import numpy as np

from . import Failure
from .body import Body, Floats, Made, point_normals

# Share of the depth over the distance from the contact, in steps of a quarter of the radius: the mean of the permanent dents that
# OpenRadioss left in a hood of 0.8 mm steel (lab/data/steel, training impacts), faded out at its end.
PROFILE = np.array([1.0, 0.812, 0.612, 0.481, 0.368, 0.268, 0.171, 0.101, 0.062, 0.037, 0.0])
STEP = 0.25
RADIUS = 1.97
"""The radius of a dent in metres is this times the square root of its depth in metres."""
BATCH = 2_000_000
"""Distances that are computed at once."""


class Profile:
    """Round dents on some points. What is held does not move, and dents fade towards it."""

    def __init__(self, points: Floats, normals: Floats, held: np.ndarray, size: float) -> None:
        self.points, self.normals, self.size = points, normals, size
        self.fade = np.ones(len(points))
        if held.any():
            fade = np.clip(_distances(points, points[held]) / (0.1 * size), 0, 1)
            self.fade = fade * fade * (3 - 2 * fade)

    def dent(self, at: int, moved: Floats) -> Floats:
        """The displacements of a dent whose contact, the point `at`, moves by `moved`, m."""
        radius = min(RADIUS * np.sqrt(np.linalg.norm(moved)), 0.2 * self.size)
        distance = np.linalg.norm(self.points - self.points[at], axis=1)
        # A dent does not reach around the body: where the surface faces away it ends.
        facing = np.clip(2 * (self.normals @ self.normals[at]), 0, 1)
        share = np.interp(distance / max(radius, 1e-30), STEP * np.arange(len(PROFILE)), PROFILE) * self.fade * facing
        return share[:, None] * moved


def make(body: Body, count: int, depth: tuple[float, float]) -> list[Made]:
    """`count` dents with depths from `depth`, m, at well-spread places. They do not know their blow."""
    used = np.unique(body.triangles)
    points, normals = body.points[used], point_normals(body.points, body.triangles)[used]
    dents = Profile(points, normals, _held(body)[used], body.size)
    places = np.flatnonzero(dents.fade > 0.9) if (dents.fade > 0.9).any() else np.flatnonzero(dents.fade > 0)
    if len(places) == 0:
        raise Failure(f"every vertex of {body.name} is on an open edge, which does not move; subdivide the mesh")
    made = []
    nearest = np.full(len(places), np.inf)
    at = int(places[np.linalg.norm(points[places] - points[places].mean(0), axis=1).argmin()])
    for index in range(count):
        quantile = (index * 0.6180339887) % 1.0
        deep = depth[0] * (depth[1] / depth[0]) ** quantile
        field = np.zeros_like(body.points)
        field[used] = dents.dent(at, -deep * normals[at])
        made.append(Made(f"profile {index + 1}", field, points[at], normals[at]))
        nearest = np.minimum(nearest, np.linalg.norm(points[places] - points[at], axis=1))
        at = int(places[nearest.argmax()])
    return made


def _held(body: Body) -> np.ndarray:
    held = np.zeros(len(body.points), bool)
    held[body.of_vertex[body.marked]] = True
    if not body.marked.any():
        t = body.triangles
        pairs = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
        key, uses = np.unique(pairs[:, 0] * len(body.points) + pairs[:, 1], return_counts=True)
        rim = key[uses == 1]
        held[rim // len(body.points)] = held[rim % len(body.points)] = True
    return held


def _distances(points: Floats, others: Floats) -> Floats:
    """From each point to the nearest of the others. Without SciPy, which Blender's Python lacks."""
    nearest = np.full(len(points), np.inf)
    step = max(1, BATCH // len(points))
    for start in range(0, len(others), step):
        offset = points[:, None] - others[None, start : start + step]
        np.minimum(nearest, np.einsum("ijk,ijk->ij", offset, offset).min(1), out=nearest)
    return np.sqrt(nearest)
