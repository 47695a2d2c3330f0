"""The planes in which a body is its own mirror image. The library uses examples on both sides of them, so only one side is hit."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from .body import Body, Floats

TOLERANCE = 1e-3
"""Greatest distance of a mirrored vertex from a vertex, as a share of the diagonal; the library's own."""
STRAYS = 0.01
"""Share of the vertices that may miss it; the library's own."""
ALIKE = 0.95
"""Share of the shell's points that must be held, or near solids, on both sides alike."""


@dataclass(frozen=True)
class Symmetry:
    """Planes through one point."""

    centre: Floats = field(default_factory=lambda: np.zeros(3))
    normals: list[Floats] = field(default_factory=list)
    """Of the planes, unit."""

    def folded(self, points: Floats) -> Floats:
        """Where points, or their mirror images, lie on the first side."""
        out = np.array(points, float)
        for normal in self.normals:
            beyond = np.minimum((out - self.centre) @ normal, 0.0)
            out = out - 2 * beyond[..., None] * normal
        return out

    def first(self, points: Floats) -> np.ndarray:
        """Which points lie on the first side."""
        sides = [(points - self.centre) @ normal >= 0 for normal in self.normals]
        return np.all(sides, axis=0) if sides else np.ones(len(points), bool)


def find(body: Body, points: Floats, held: np.ndarray, room: Floats) -> tuple[Symmetry, list[str]]:
    """The planes of the body, if what is held and what lies inside are alike on both sides, and notes. `points` are the shell's."""
    local = body.vertices.astype(float)
    low, high = local.min(0), local.max(0)
    centre, size = (low + high) / 2, float(np.linalg.norm(high - low))
    tree, shell = cKDTree(local), cKDTree(points)
    middle = body.world @ centre
    normals, notes = [], []
    for axis in range(3):
        image = local.copy()
        image[:, axis] = 2 * centre[axis] - image[:, axis]
        if high[axis] - low[axis] < 1e-6 * size or (tree.query(image)[0] > TOLERANCE * size).mean() > STRAYS:
            continue
        normal = body.world[:, axis] / np.linalg.norm(body.world[:, axis])
        others = [body.world[:, one] for one in range(3) if one != axis]
        if any(abs(normal @ other) > 1e-4 * np.linalg.norm(other) for other in others):
            continue
        opposite = shell.query(points - 2 * ((points - middle) @ normal)[:, None] * normal)[1]
        near = np.minimum(room, 0.1 * body.size)
        alike = (held == held[opposite]).mean() >= ALIKE and (np.abs(near - near[opposite]) < 0.02 * body.size).mean() >= ALIKE
        if alike:
            normals.append(normal)
        else:
            notes.append(
                f"the mesh is the same on both sides in {'xyz'[axis]}, but what is held or lies inside is not; both sides are hit, and the "
                "library takes mirror images only if the hits do not contradict them"
            )
    if normals:
        notes.append(
            f"the body is the same on both sides of {len(normals)} plane{'s' if len(normals) > 1 else ''}; one side is hit, for both"
        )
    return Symmetry(middle, normals), notes
