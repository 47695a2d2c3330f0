"""Cross-validation on the training impacts: which rows predict which, and how a rule's width is learned among them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from study.body import SAME_DEPTH, SAME_DIRECTION, Array, Body, Bools, Ints, length
from study.carry import Carry, Moments, Window
from study.rule import LEARNED_FROM, PLACE_WIDTHS, Distances, Rule, choose, errors, hindsight_errors

FOLDS = 4


@dataclass
class Tasks:
    """Each predicts one row from a set of rows: `known` [tasks, rows], `row` [tasks]."""

    known: Bools
    row: Ints


def leave_one_out(body: Body) -> Tasks:
    """Every row from all rows of other simulations."""
    return Tasks(body.source[:, None] != body.source, np.arange(len(body)))


def farthest_points(points: Array, count: int, start: int) -> Ints:
    """Indices of points, each the farthest from those before."""
    taken, distance = [start], length(points - points[start])
    while len(taken) < count:
        taken.append(int(distance.argmax()))
        distance = np.minimum(distance, length(points - points[taken[-1]]))
    return np.array(taken)


def spread_out(body: Body, count: int) -> Tasks:
    """Four sets of `count` rows far from each other, each out of three quarters of the simulations; each predicts all rows
    of simulations it has none of."""
    simulations = np.unique(body.source)
    known, row = [], []
    for fold in range(FOLDS):
        rows = np.flatnonzero(~np.isin(body.source, simulations[fold::FOLDS]))
        points = body.vertices[body.contact[rows]]
        chosen = rows[farthest_points(points, count, fold * len(rows) // FOLDS)]
        predicted = np.flatnonzero(~np.isin(body.source, body.source[chosen]))
        known += [np.isin(np.arange(len(body)), chosen)] * len(predicted)
        row += list(predicted)
    return Tasks(np.array(known), np.array(row))


def images_of(body: Body, rule: Rule, known: Bools) -> Bools:
    """The images that sets of rows give, [tasks, images]."""
    return known.astype(np.float32) @ body.images.given[rule.mirrors].astype(np.float32) > 0


class Bench:
    """One body with everything that predictions need."""

    def __init__(self, body: Body, moments: dict[tuple[Carry, Window | None], Moments]) -> None:
        self.body, self.distances, self.moments = body, Distances(body), moments
        self.learned: dict[tuple, tuple[float, Carry]] = {}

    def predict(self, rule: Rule, place: Array, rows: Ints, allowed: Bools) -> Array:
        """Errors, a few tasks at a time."""
        moments = self.moments[rule.carry, rule.window]
        width = rule.pool if rule.count else allowed.shape[1]
        chunk = max(1, 4_000_000 // (width * width + allowed.shape[1]))
        found = []
        for start in range(0, len(rows), chunk):
            part = slice(start, start + chunk)
            if rule.hindsight in ("single", "all"):
                found.append(hindsight_errors(rule.hindsight, moments, rows[part], allowed[part]))
                continue
            picked, weights = choose(rule, self.distances, place[part], rows[part], allowed[part])
            found.append(errors(rule, moments, rows[part], picked, weights))
        return np.concatenate(found)

    def inner_images(self, rule: Rule, known: Bools, rows: Ints) -> Bools:
        """What may predict each of `rows` out of a set while something is learned, [rows, images]."""
        body = self.body
        if rule.leaves_out == "simulation":
            out = body.source[rows][:, None] == body.source
        elif rule.leaves_out == "lookalike":
            slant, depth = length(body.tangent), np.log(body.depth)
            out = (np.abs(depth[rows][:, None] - depth) < SAME_DEPTH) & (np.abs(slant[rows][:, None] - slant) < SAME_DIRECTION)
        else:
            out = rows[:, None] == np.arange(len(body))
        return images_of(body, rule, known & ~out) & ~body.images.given["all"][rows]

    def learn(self, rule: Rule, known: Bools) -> tuple[float, Carry]:
        """The place width, and the way to carry, with which the rows of a set predict each other best: least mean error,
        leaving one out."""
        rows = np.flatnonzero(known)
        if len(rows) < LEARNED_FROM:
            return PLACE_WIDTHS[-1], rule.carry
        # What is slow or knows the truth learns like the plain rule.
        rule = replace(rule, modes=None, hindsight=None, count=rule.count or 4)
        key = (rule, known.tobytes())
        if key not in self.learned:
            allowed = self.inner_images(rule, known, rows)
            some = allowed.any(1)
            rows, allowed = rows[some], allowed[some]
            means = {}
            for carry in (rule.carry, *rule.or_carry):
                for width in PLACE_WIDTHS:
                    means[width, carry] = self.predict(replace(rule, carry=carry), np.full(len(rows), width), rows, allowed).mean()
            means[PLACE_WIDTHS[-1], rule.carry] *= 1 - rule.margin
            self.learned[key] = min(means, key=means.get)
        return self.learned[key]

    def validate(self, rule: Rule, tasks: Tasks) -> Array:
        """Errors of all tasks."""
        if rule.place is not None or rule.hindsight in ("single", "all"):
            learned = [(rule.place or 1.0, rule.carry)] * len(tasks.row)
        else:
            learned = [self.learn(rule, known) for known in tasks.known]
        allowed = images_of(self.body, rule, tasks.known)
        found = np.zeros(len(tasks.row))
        for carry in dict.fromkeys(c for _, c in learned):
            own = np.array([c == carry for _, c in learned])
            place = np.array([w for w, c in learned if c == carry])
            found[own] = self.predict(replace(rule, carry=carry), place, tasks.row[own], allowed[own])
        return found
