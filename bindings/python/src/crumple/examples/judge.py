"""How well a set predicts hits that it has not seen, by one metric for every way of making dents.

The metric is the relative L2 norm of the displacement over all points of the shell: 0 is perfect, and no dent at all is 1. The examples are
divided into five parts; each part is predicted from the other four.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import crumple

from . import profile
from .body import Floats, Made
from .shell import Shell

PARTS = 5
LEAST = 8
"""With fewer dents nothing is judged."""
MOST = 150
"""Examples that are left out; evenly chosen if there are more."""
SEEN = 0.0015
"""Shallower dents, as a share of the diagonal, are not judged: the relative error of next to nothing says nothing."""
NOTHING, WEAK, USABLE = 0.95, 0.7, 0.45
"""Errors above the first are those of a set that predicts nothing."""


@dataclass(frozen=True)
class Judged:
    count: int
    """Examples that were left out in turn."""
    blow: float
    """Median error, told the blow."""
    worst: float
    """Its 90th percentile."""
    displacement: float
    """Median error, told the displacement of the contact."""
    round: float
    """The same of a round dent of `--profile`."""
    errors: dict[str, float]
    """Told the blow, by the name of the example."""

    def words(self) -> str:
        """The verdict."""
        said = (
            f"expected error of a hit, told its blow: {self.blow:.2f} (0 is perfect, no dent is 1; one hit in ten exceeds {self.worst:.2f})"
        )
        if self.blow >= NOTHING:
            return f"{said}: the set predicts nothing"
        if self.blow >= WEAK:
            return f"{said}: weak; dents look right, but many are too deep, too shallow or of another shape"
        if self.blow >= USABLE:
            return f"{said}: usable; most dents are like the solver's"
        return f"{said}: good"


def judge(shell: Shell, examples: Sequence[Made]) -> Judged | None:
    """Leaves the examples out in turn. None: there are too few dents."""
    deep = [i for i, made in enumerate(examples) if np.linalg.norm(made.field, axis=1).max() >= SEEN * shell.size]
    deep = deep[:: -(-len(deep) // MOST)] if deep else deep
    if len(deep) < LEAST:
        return None
    dents = profile.Profile(shell.points, shell.normals, shell.held, shell.size)
    told, moved, generic = {}, [], []
    for part in range(PARTS):
        asked = [i for k, i in enumerate(deep) if k % PARTS == part]
        if not asked:
            continue
        out = set(asked)
        with crumple.Context(threads=1) as context:
            rest = [as_example(shell.points, made) for i, made in enumerate(examples) if i not in out]
            body = context.example_set(shell.points, shell.triangles, rest).instance()
            for i in asked:
                made = examples[i]
                told[made.name] = error(made, by_blow(body, made))
                vertex = int(np.linalg.norm(shell.points - made.point, axis=1).argmin())
                contact = made.field[vertex]
                moved.append(error(made, by_displacement(body, made, contact)))
                generic.append(error(made, dents.dent(vertex, contact)))
    errors = list(told.values())
    return Judged(
        len(errors), float(np.median(errors)), float(np.quantile(errors, 0.9)), float(np.median(moved)), float(np.median(generic)), told
    )


def error(made: Made, field: Floats) -> float:
    return float(np.linalg.norm(field - made.field) / np.linalg.norm(made.field))


def by_blow(body: crumple.Instance, made: Made) -> Floats:
    """The field that a set predicts for a blow, told what a rigid-body engine knows of it."""
    body.reset()
    body.hit(made.point, striker=striker(made), normal=made.normal)
    return _field(body)


def by_displacement(body: crumple.Instance, made: Made, moved: Floats) -> Floats:
    """The field that a set predicts for a displacement of the contact."""
    body.reset()
    body.hit_displacement(made.point, moved)
    return _field(body)


def _field(body: crumple.Instance) -> Floats:
    return body.deformed().positions.astype(float) - body.set.mesh().positions


def own_errors(shell: Shell, examples: Sequence[Made]) -> list[float]:
    """What the library says of each example: its error when the others predict it."""
    with crumple.Context(threads=1) as context:
        found = context.example_set(shell.points, shell.triangles, [as_example(shell.points, made) for made in examples])
        return [one.field_error for one in found.examples]


def as_example(points: Floats, made: Made) -> crumple.Example:
    """An example of the library, on the points that it displaces."""
    example = crumple.Example(points + made.field, name=made.name, contact=made.point, normal=made.normal)
    if made.impulse is not None and made.velocity is not None:
        example.impulse, example.duration = made.impulse, made.duration
        example.striker = striker(made)
    return example


def striker(made: Made) -> crumple.Striker:
    return crumple.Striker(made.mass, made.radius, made.velocity, crumple.StrikerShape[made.shape.upper() or "UNKNOWN"])
