"""Which blows to make: those that fill the space of place, energy, mass, radius, tilt and kind of striker, and first those of which the set
knows least."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from . import Failure
from .body import Floats
from .flight import Blow
from .materials import LIMITS, SPEEDS, STRIKERS, Material, radii
from .shell import Shell
from .symmetry import Symmetry

MARGIN = 0.06
"""Hits keep this share of the body's diagonal away from what is held, or less if the body is narrow."""
POOL = 32
"""Blows that are drawn for each one that is made."""
EXPONENT = 1.2
"""Energy grows with this power of the depth."""
TYPICAL = 45.0
"""Energy of a dent by depth ** EXPONENT and by the material's strength, before any is known."""
CALIBRATION = (0.5, 1.0, 0.0, 0.75)
"""The first hits aim at these places between the shallowest and the deepest dent. They say how much energy a dent takes."""
PLACE, ENERGY, RADIUS, TILT = 0.1, 0.5, 1.0, 0.6
"""Blows that differ by these are equally unlike: a share of the diagonal, of the range of energies, of that of radii, and of the tilt."""


@dataclass(frozen=True)
class Tried:
    """What the plan knows of a blow that was made: its features, the energy's factor, and how well the set knows it (1: as usual)."""

    features: Floats
    worth: float


def energy(depth: float, stiffness: float, strength: float) -> float:
    """Of the motion along the normal that leaves about this depth (m), J."""
    return stiffness * strength * depth**EXPONENT


class Plan:
    """Draws blows on one shell. The same seed and the same results give the same blows."""

    def __init__(
        self, shell: Shell, material: Material, thickness: float, strikers: Sequence[str], tilt: float, seed: int, symmetry: Symmetry,
        depth: tuple[float, float] = (0.0, 0.0), mass: tuple[float, float] | None = None,
        radius: tuple[float, float] | None = None, margin: float = MARGIN,
    ) -> None:  # fmt: skip
        self.shell, self.strikers, self.tilt, self.seed, self.symmetry = shell, tuple(strikers), tilt, seed, symmetry
        self.mass, self.radius = mass, radius
        self.strength = material.strength(thickness)
        far = shell.to_held
        finite = far[np.isfinite(far)]
        needed = min(margin * shell.size, 0.5 * finite.max(initial=0.0)) if len(finite) else 0.0
        usable = ~shell.held & (far >= needed) & (shell.room >= depth[0])
        if not (~shell.held & (far >= needed)).any():
            raise Failure("no place of the body is free enough to be hit; hold less of it (--hold)")
        if not usable.any():
            raise Failure("solids of --inner are everywhere nearer than the shallowest dent; choose a smaller --depth")
        half = usable & symmetry.first(shell.points)
        self.open: NDArray[np.int64] = np.flatnonzero(half if half.any() else usable)
        """Points of the shell that may be hit; of a symmetric body those on one side."""
        order = _along_curve(shell.points[self.open])
        self.open = self.open[order]
        self._area = np.cumsum(shell.areas[self.open])
        self._centre = int(self.open[np.minimum(far[self.open], shell.size).argmax()])

    def calibration(self, index: int, stiffness: float, depth: tuple[float, float], taken: Sequence[int]) -> Blow:
        """One of the first blows: straight on, at a place far from the others, by a striker of middling size."""
        points = self.shell.points
        vertex = self._centre
        if taken:
            away = np.linalg.norm(points[self.open][:, None] - points[list(taken)][None], axis=2).min(1)
            vertex = int(self.open[(away * np.minimum(self.shell.to_held[self.open], 0.2 * self.shell.size)).argmax()])
        wanted = depth[0] * (depth[1] / depth[0]) ** CALIBRATION[index]
        u = np.array([(index + 0.5) / len(CALIBRATION), 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.3])
        return self._blow(u, vertex, energy(wanted, stiffness, self.strength))

    def next(self, index: int, energies: tuple[float, float], known: Sequence[Tried]) -> Blow:
        """Of POOL drawn blows, the one that is least like the known ones; where the set is worse than usual, less unlike is enough."""
        pool = self.draw(index * POOL, POOL, energies)
        if not known:
            return pool[0]
        mine = np.array([self.features(blow, energies) for blow in pool])
        others = np.array([one.features for one in known])
        distance = np.linalg.norm(mine[:, None] - others[None], axis=2)
        near = np.argsort(distance, axis=1)[:, :3]
        worth = np.array([one.worth for one in known])
        return pool[int((distance.min(1) * worth[near].mean(1)).argmax())]

    def draw(self, start: int, count: int, energies: tuple[float, float]) -> list[Blow]:
        """Blows of a scrambled Sobol sequence, from its place `start` on. `count` is a power of two."""
        sequence = qmc.Sobol(8, seed=self.seed)
        if start:
            sequence.fast_forward(start)
        blows = []
        for u in sequence.random(count):
            vertex = int(self.open[min(np.searchsorted(self._area, u[1] * self._area[-1]), len(self.open) - 1)])
            blows.append(self._blow(u, vertex, _between(energies, u[2])))
        return blows

    def features(self, blow: Blow, energies: tuple[float, float]) -> Floats:
        """A blow as a point in a space where equally long steps are equally important."""
        place = self.symmetry.folded(blow.point) / (PLACE * self.shell.size)
        along = float(-blow.direction @ blow.normal)
        own = 0.5 * blow.mass * (blow.speed * along) ** 2
        share = np.log(own / energies[0]) / np.log(energies[1] / energies[0])
        aside = np.linalg.norm(blow.direction + along * blow.normal) / max(np.sin(np.radians(self.tilt)), 1e-6)
        kinds = [float(name == blow.shape) for name in ("ball", "pole", "wall", "corner")]
        return np.array([*place, share / ENERGY, np.log(blow.radius / self.shell.size) / RADIUS, aside * TILT, *kinds])

    def _blow(self, u: Floats, vertex: int, along: float) -> Blow:
        """The blow of eight numbers from 0 to 1, with this energy along the normal, J."""
        shell = self.shell
        name = self.strikers[min(int(u[0] * len(self.strikers)), len(self.strikers) - 1)]
        striker = STRIKERS[name]
        normal = shell.normals[vertex]
        angle, around = np.radians(self.tilt) * u[5], 2 * np.pi * u[6]
        if striker.shape == "pole" and abs(normal[1]) < 0.8:
            # A pole stands upright and moves in the horizontal plane.
            normal = normal * [1, 0, 1] / np.linalg.norm(normal * [1, 0, 1])
            side = np.cross([0.0, 1.0, 0.0], normal) * (1 if around < np.pi else -1)
            shape = "pole"
        else:
            a = np.cross(normal, [0.3, 0.5, 0.8])
            a /= np.linalg.norm(a)
            side = np.cos(around) * a + np.sin(around) * np.cross(normal, a)
            # A pole cannot strike a roof.
            shape = "ball" if striker.shape == "pole" else striker.shape
        direction = -np.cos(angle) * normal + np.sin(angle) * side
        total = along / np.cos(angle) ** 2
        if self.mass is None:
            mass = min(2 * total / _between(SPEEDS, u[3]) ** 2, striker.heaviest)
        else:
            mass = _between(self.mass, u[3])
        speed = float(np.clip(np.sqrt(2 * total / mass), *LIMITS))
        radius = _between(radii(name, shell.size, self.radius), u[4])
        spin = 2 * np.pi * u[7] if shape == "corner" else 0.0
        return Blow(shell.points[vertex], normal, direction, speed, mass, radius, shape, spin)


def _between(ends: tuple[float, float], share: float) -> float:
    """In equal ratios."""
    return float(ends[0] * (ends[1] / ends[0]) ** share)


def _along_curve(points: Floats) -> NDArray[np.int64]:
    """An order in which neighbours in the list are neighbours in space: that of a Z-order curve."""
    low = points.min(0)
    cells = ((points - low) / max(float(np.ptp(points, axis=0).max()), 1e-30) * 1023).astype(np.int64)
    key = np.zeros(len(points), np.int64)
    for bit in range(10):
        for axis in range(3):
            key |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(key, kind="stable")
