"""Where a striker starts its flight, and where it first touches the shell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from .body import Floats
from .shell import Shell, _barycentric

PLATE = 0.1
"""Half the thickness of a wall, as a share of half its side."""
CORNER = np.sqrt(3.0)
"""From the middle of a cube to a corner, in half sides."""


@dataclass(frozen=True)
class Blow:
    point: Floats
    """Where the striker is aimed at."""
    normal: Floats
    direction: Floats
    """Of flight, unit."""
    speed: float
    mass: float
    radius: float
    """Of a ball or a pole; half the side of a wall or of the box of a corner. m"""
    shape: str
    """ball; pole, upright; wall, a square plate whose face looks along -normal; corner, a cube whose corner leads."""
    spin: float = 0.0
    """Turn of a cube around its flight, radians."""

    @property
    def is_box(self) -> bool:
        return self.shape in ("wall", "corner")

    @property
    def half_sides(self) -> Floats:
        return np.array([self.radius, self.radius, PLATE * self.radius if self.shape == "wall" else self.radius])

    @property
    def axes(self) -> Floats:
        """Of a box, as columns."""
        lead = self.normal if self.shape == "wall" else self.direction
        x = np.cross(lead, [0.3, 0.5, 0.8])
        x /= np.linalg.norm(x)
        x = np.cos(self.spin) * x + np.sin(self.spin) * np.cross(lead, x)
        frame = np.stack([x, np.cross(lead, x), lead], 1)
        return frame if self.shape == "wall" else frame @ _DIAGONAL


# Its rows are an orthonormal frame whose last one is the diagonal of a cube.
_DIAGONAL = np.array([[1, -1, 0], [1, 1, -2], [1, 1, 1]]) / np.sqrt([[2], [6], [3]])


class Flight:
    """The geometry of strikers before the touch. `skin` is the distance of the shell's contact surface from its points, m."""

    def __init__(self, shell: Shell, skin: float) -> None:
        self.shell, self.skin = shell, skin
        self.half = 0.75 * shell.size
        """Half the length of a pole, m."""
        self._corners = shell.points[shell.triangles]
        middles = self._corners.mean(1)
        self._reach = float(np.linalg.norm(self._corners - middles[:, None], axis=2).max())
        self._middles = cKDTree(middles)

    def touch(self, blow: Blow) -> tuple[Floats, Floats, Floats] | None:
        """Where the striker first touches: its middle, the shell's point, and the outward normal there. None if it misses."""
        centre = self.start(blow)
        assert centre is not None
        rim, flown = self._rim(blow), 0.0
        while flown < 2.5 * self.shell.size:
            distance, at, place = self._near(blow, centre, rim)
            gap = distance - self._thick(blow)
            if gap < 1e-3 * self.shell.edge:
                return centre, at, (place - at) / max(distance, 1e-12)
            centre = centre + blow.direction * gap
            flown += gap
        return None

    def start(self, blow: Blow) -> Floats | None:
        """A place of the striker, on its line of flight, where it is clear of the shell; not further away than the shell is large."""
        rim = self._rim(blow)
        if blow.shape == "corner":
            aim = blow.point + blow.normal * self.skin - blow.direction * (CORNER * blow.radius)
        else:
            aim = blow.point + blow.normal * ((PLATE if blow.shape == "wall" else 1) * blow.radius + self.skin)
        if blow.shape == "pole":
            aim = aim * [1, 0, 1] + self.shell.points.mean(0) * [0, 1, 0]
        for back in np.linspace(0, self.shell.size, 21):
            centre = aim - blow.direction * back
            if self._near(blow, centre, rim)[0] >= self._thick(blow) - 1e-3 * self.shell.edge:
                return centre
        return None

    def _thick(self, blow: Blow) -> float:
        """The distance from `_rim` and the shell's points at which the striker touches."""
        return self.skin + (0.0 if blow.is_box else blow.radius)

    def _rim(self, blow: Blow) -> Floats:
        """Points, relative to the middle: on the axis of a pole, the middle of a ball, on the three edges of a corner that leads."""
        if blow.shape == "ball":
            return np.zeros((1, 3))
        if blow.shape == "wall":
            # A plate is larger than the shell: its face touches points of the shell.
            return np.zeros((0, 3))
        step = 0.5 * self.shell.edge
        if blow.shape == "pole":
            return np.arange(-self.half, self.half + 1e-9, step)[:, None] * np.array([0.0, 1.0, 0.0])
        along = np.linspace(0, 1, int(np.ceil(2 * blow.radius / step)) + 1)[:, None, None]
        edges = blow.radius * (1 - 2 * along * np.eye(3))
        return edges.reshape(-1, 3) @ blow.axes.T

    def _near(self, blow: Blow, centre: Floats, rim: Floats) -> tuple[float, Floats, Floats]:
        """The distance from the striker to the shell, the shell's point, and the striker's."""
        best = (np.inf, centre, centre)
        if blow.is_box:
            best = self._near_box(blow, centre)
        if len(rim) == 0:
            return best
        places = centre + rim
        distances = self._middles.query(places)[0]
        limit = distances.min() + 2 * self._reach
        for place in places[distances <= limit]:
            corners = self._corners[self._middles.query_ball_point(place, limit)]
            at = np.einsum("nk,nkj->nj", _barycentric(np.broadcast_to(place, (len(corners), 3)), corners), corners)
            gaps = np.linalg.norm(at - place, axis=1)
            k = int(gaps.argmin())
            if gaps[k] < best[0]:
                best = (float(gaps[k]), at[k], place)
        return best

    def _near_box(self, blow: Blow, centre: Floats) -> tuple[float, Floats, Floats]:
        """The same for the shell's points; the distance is below 0 inside the box."""
        axes, half = blow.axes, blow.half_sides
        local = (self.shell.points - centre) @ axes
        beyond: NDArray[np.float64] = np.abs(local) - half
        distance = np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(1), 0)
        k = int(distance.argmin())
        return float(distance[k]), self.shell.points[k], centre + axes @ np.clip(local[k], -half, half)
