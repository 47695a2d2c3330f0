"""Where to hit next: first well spread, then where the examples predict each other worst."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

import crumple

from . import Failure
from .body import Floats, Made
from .shell import Shell

SPREAD = 4
"""The first examples are only spread."""
MARGIN = 0.06
"""Hits keep this share of the body's diagonal away from what is held, or less if the body is narrow."""


class Places:
    def __init__(self, shell: Shell, margin: float = MARGIN) -> None:
        self.shell = shell
        far = shell.to_held
        finite = far[np.isfinite(far)]
        needed = min(margin * shell.size, 0.5 * finite.max(initial=0.0)) if len(finite) else 0.0
        self.open: NDArray[np.int64] = np.flatnonzero(~shell.held & (far >= needed))
        """Points of the shell that may be hit."""
        if len(self.open) == 0:
            raise Failure("no place of the body is free enough to be hit; hold less of it (--hold)")
        self._centre = self.open[np.minimum(far[self.open], shell.size).argmax()]

    def drop(self, vertex: int, radius: float) -> None:
        """Gives up a place and what is near it."""
        distance = np.linalg.norm(self.shell.points[self.open] - self.shell.points[vertex], axis=1)
        self.open = self.open[distance > radius]

    def next(self, taken: Sequence[Floats], errors: Sequence[float | None]) -> int | None:
        """The next point of the shell to hit, after these points with these errors. None if no place is left."""
        if len(self.open) == 0:
            return None
        if not taken:
            return int(self._centre if self._centre in self.open else self.open[0])
        distances = np.linalg.norm(self.shell.points[self.open][:, None] - np.array(taken)[None], axis=2)
        worth = distances.min(1)
        known = np.array([np.nan if error is None else min(max(error, 0.05), 2.0) for error in errors])
        if len(taken) >= SPREAD and np.isfinite(known).any():
            known = np.where(np.isfinite(known), known, np.nanmedian(known))
            near = np.argsort(distances, axis=1)[:, :3]
            weights = 1 / (np.take_along_axis(distances, near, 1) + 0.01 * self.shell.size)
            worth = worth * (weights * known[near]).sum(1) / weights.sum(1)
        return int(self.open[worth.argmax()])


def errors(shell: Shell, examples: Sequence[Made]) -> tuple[float | None, list[float | None]]:
    """How well the examples predict each other on the shell: the median, and each one's, as the library measures them."""
    with crumple.Context(threads=1) as context:
        found = context.example_set(shell.points, shell.triangles, [as_example(shell.points, made) for made in examples])
        return found.info.field_error, [one.field_error for one in found.examples]


def as_example(points: Floats, made: Made) -> crumple.Example:
    """An example of the library, on the points that it displaces."""
    example = crumple.Example(points + made.field, name=made.name, contact=made.point, normal=made.normal)
    if made.impulse is not None and made.velocity is not None:
        example.impulse, example.duration = made.impulse, made.duration
        example.striker = crumple.Striker(made.mass, made.radius, made.velocity)
    return example
