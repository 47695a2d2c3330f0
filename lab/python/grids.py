"""Bodies as grids: the panel and the tube of shots and presses at any resolution, and fields read between two grids."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Grid:
    """A body over the unit square: vertex `i * nv + j` lies at `(i / (nu - 1), j / (nv - 1))`; a tube wraps in `i`."""

    truth: str
    body: str
    nu: int
    nv: int

    @property
    def wraps(self) -> bool:
        return self.body == "tube"

    def parameters(self) -> tuple[Floats, Floats]:
        """The parameters of every vertex, each of shape [nu * nv]."""
        s = np.arange(self.nu) / (self.nu if self.wraps else self.nu - 1)
        t = np.arange(self.nv) / (self.nv - 1)
        grid_s, grid_t = np.meshgrid(s, t, indexing="ij")
        return grid_s.ravel(), grid_t.ravel()

    def vertices(self) -> Floats:
        """Metres, shape [nu * nv, 3]."""
        s, t = self.parameters()
        if self.wraps:
            low = -0.45 if self.truth == "shots" else 0.0
            angle = 2 * np.pi * s
            return np.stack([0.3 * np.cos(angle), 0.3 * np.sin(angle), low + 0.9 * t], -1)
        x, y = -0.6 + 1.2 * s, -0.45 + 0.9 * t
        crown_x, crown_y = (0.05, 0.04) if self.truth == "shots" else (0.07, 0.035)
        return np.stack([x, y, crown_x * (1 - (x / 0.6) ** 2) + crown_y * (1 - (y / 0.45) ** 2)], -1)

    def triangles(self) -> NDArray[np.int64]:
        """Outward triangles with alternating diagonals, shape [n, 3]."""
        rows = self.nu if self.wraps else self.nu - 1
        i, j = (a.ravel() for a in np.meshgrid(np.arange(rows), np.arange(self.nv - 1), indexing="ij"))
        a, b = i * self.nv + j, ((i + 1) % self.nu) * self.nv + j
        c, d = b + 1, a + 1
        odd = ((i + j) % 2 == 1)[:, None]
        first = np.where(odd, np.stack([a, b, c], 1), np.stack([a, b, d], 1))
        second = np.where(odd, np.stack([a, c, d], 1), np.stack([b, c, d], 1))
        return np.stack([first, second], 1).reshape(-1, 3)

    def pinned(self) -> NDArray[np.bool_]:
        """The rim: all four edges of the panel, both end rings of the tube."""
        i, j = np.divmod(np.arange(self.nu * self.nv), self.nv)
        rim = (j == 0) | (j == self.nv - 1)
        return rim if self.wraps else rim | (i == 0) | (i == self.nu - 1)

    def resized(self, factor: float) -> Grid:
        """The same body with `factor` times as many cells along each side."""
        cells_u = self.nu if self.wraps else self.nu - 1
        cells_u, cells_v = round(cells_u * factor), round((self.nv - 1) * factor)
        # Alternating diagonals close round a tube only if the number of cells is even.
        nu = cells_u + cells_u % 2 if self.wraps else cells_u + 1
        return Grid(self.truth, self.body, nu, cells_v + 1)


def interpolate(field: Floats, source: Grid, target: Grid) -> Floats:
    """`field` [source vertices, k], read bilinearly in the grid's parameters at the vertices of `target`."""
    s, t = target.parameters()
    x = s * (source.nu if source.wraps else source.nu - 1)
    y = t * (source.nv - 1)
    last = source.nu - 1 if source.wraps else source.nu - 2
    i = np.clip(np.floor(x + 1e-9).astype(int), 0, last)
    j = np.clip(np.floor(y + 1e-9).astype(int), 0, source.nv - 2)
    u, v = (x - i)[:, None], (y - j)[:, None]
    table = field.reshape(source.nu, source.nv, -1)
    right = (i + 1) % source.nu
    low = table[i, j] * (1 - u) + table[right, j] * u
    high = table[i, j + 1] * (1 - u) + table[right, j + 1] * u
    return low * (1 - v) + high * v


def face_normals(vertices: Floats, triangles: NDArray[np.int64]) -> Floats:
    """Twice the area times the normal of every triangle."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def vertex_normals(vertices: Floats, triangles: NDArray[np.int64]) -> Floats:
    """Unit normals, weighted by area."""
    faces = face_normals(vertices, triangles)
    sums = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(sums, triangles[:, corner], faces)
    return sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-30)


def inverted(base: Floats, moved: Floats, triangles: NDArray[np.int64]) -> int:
    """How many triangles turned by more than 90 degrees between the two poses."""
    return int(((face_normals(base, triangles) * face_normals(moved, triangles)).sum(1) < 0).sum())


@dataclass(frozen=True)
class FieldError:
    """How far a predicted field is from the true one."""

    relative_l2: float
    scaled_relative_l2: float
    largest_mm: float


def field_error(predicted: Floats | None, truth: Floats, contact: int) -> FieldError:
    """Errors as is, and after one factor gave the contact the true displacement.

    A run that failed (None or not finite) is infinitely wrong. A dent under a twentieth of the true one cannot be scaled:
    it counts as no dent at all (1).
    """
    if predicted is None or not np.isfinite(predicted).all():
        return FieldError(np.inf, np.inf, np.inf)
    length = np.linalg.norm(truth)
    difference = predicted - truth
    at_contact, asked = predicted[contact], truth[contact]
    along = float(at_contact @ asked)
    scaled = 1.0
    if along > 0.05 * float(asked @ asked):
        factor = along / float(at_contact @ at_contact)
        scaled = float(np.linalg.norm(predicted * factor - truth) / length)
    return FieldError(
        float(np.linalg.norm(difference) / length), scaled, float(1e3 * np.linalg.norm(difference, axis=1).max())
    )
