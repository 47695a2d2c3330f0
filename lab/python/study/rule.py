"""Selection rules: which images a hit takes, and with what weights."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from study.body import Array, Body, Bools, Ints
from study.carry import Carry, Moments, Window

# Of the squared distance D. All are 1 at 0.
KERNELS: dict[str, Callable[[Array], Array]] = {
    "gaussian": lambda d: np.exp(-d / 2),
    "rational quadratic": lambda d: 1 / (1 + d / 2),
    "matern 3/2": lambda d: (1 + np.sqrt(3 * d)) * np.exp(-np.sqrt(3 * d)),
    "exponential": lambda d: np.exp(-np.sqrt(d)),
}
PLACE_WIDTHS = (0.2, 0.5, 1.3)
# With fewer examples the width is not learned but the widest.
LEARNED_FROM = 8
CARRIED, STILL_RIM = Carry(), Window(0.03)


@dataclass(frozen=True)
class Rule:
    """One candidate. The defaults are the new rule."""

    place: float | None = None  # width over the distance of contacts, in diagonals; None: learned
    size: float = 2.4  # width over ln of the ratio of depths
    tangent: float | None = 0.05  # width over the tangential parts of unit displacements
    kernel: str = "rational quadratic"
    kriging: bool = True  # else Gaussian kernel values made to sum to 1
    nugget: float = 0.03
    count: int | None = 4  # None: all
    pool: int = 12  # the nearest, of which the greedy choice is made
    greedy: bool = True  # else the nearest
    mirrors: str = "all"  # none, planes (one mirroring at a time), all (their compositions)
    carry: Carry = CARRIED
    window: Window | None = STILL_RIM
    distance: str = "straight"
    hidden: bool = False  # tilt and radius known
    modes: int | None = None  # projected onto so many principal modes of the carried images
    rescaled: bool = False  # the sum is scaled once more for the contact, at most twice
    hindsight: str | None = None  # bounds: the best single image, the best weights of those chosen, or of all
    leaves_out: str = "simulation"  # learning does; or only the example, or it and its lookalikes
    margin: float = 0.0  # by which share anything but the widest width must win to be learned
    or_carry: tuple[Carry, ...] = ()  # other ways to carry, one of which may be learned with the width


class Distances:
    """Parts of the squared distance between images and rows, and between images."""

    def __init__(self, body: Body) -> None:
        ln = np.log(body.images.depth)
        depth = np.abs(ln[:, None] - ln)
        self.parts = {
            "straight": body.straight(),
            "geodesic": body.geodesic(),
            "size": (depth[:, : len(body)], depth),
            "tangent": body.tangential(),
            "hidden": body.hidden(),
        }

    def squared(self, rule: Rule, place: Array | float, which: int, *index: Ints) -> Array:
        """D of `rule` at an index into images and rows (`which` 0) or images and images (1)."""

        def part(name: str) -> Array:
            return self.parts[name][which][index]

        d = (part(rule.distance) / place) ** 2 + (part("size") / rule.size) ** 2
        if rule.tangent is not None:
            d += (part("tangent") / rule.tangent) ** 2
        return d + part("hidden") if rule.hidden else d


def greedy_choice(kernel: Array, target: Array, valid: Bools, count: int) -> Ints:
    """Indices [tasks, count] that bring the variance of ordinary kriging down most, one after the other.

    Adding j to a chosen set changes k'K^-1 k, 1'K^-1 k and 1'K^-1 1 by r_j^2/c_j, o_j r_j/c_j and o_j^2/c_j, where c, r
    and o are what is left of the kernel's diagonal, of the target's kernel values and of ones after elimination.
    """
    tasks = len(target)
    left, r, o = kernel.copy(), target.copy(), np.ones_like(target)
    kk, ok, oo = np.zeros((3, tasks, 1))
    free, every = valid.copy(), np.arange(tasks)
    chosen = np.full((tasks, count), -1)
    for step in range(count):
        c = np.maximum(np.einsum("tjj->tj", left), 1e-12)
        gain = np.maximum(oo + o * o / c, 1e-12)
        variance = (1 - ok - o * r / c) ** 2 / gain - kk - r * r / c
        variance[~free] = np.inf
        # Equal but for rounding (a hit on a mirror plane): the nearer.
        best = (variance <= variance.min(1, keepdims=True) + 1e-12).argmax(1)
        some = free[every, best]
        chosen[some, step] = best[some]
        cj, rj, oj = c[every, best], r[every, best], o[every, best]
        kk[some, 0] += (rj * rj / cj)[some]
        ok[some, 0] += (oj * rj / cj)[some]
        oo[some, 0] += (oj * oj / cj)[some]
        column = left[every, :, best] / cj[:, None]
        r -= column * rj[:, None]
        o -= column * oj[:, None]
        left -= column[:, :, None] * left[every, best][:, None, :]
        free[every, best] = False
    return chosen


def kriging_weights(kernel: Array, target: Array, valid: Bools) -> Array:
    """Ordinary kriging: the least variance among weights that sum to 1."""
    on = valid.astype(float)
    both = on[:, :, None] * on[:, None, :]
    system = kernel * both + np.eye(kernel.shape[1]) * (1 - on)[:, None, :]
    solved = np.linalg.solve(system, np.stack([target * on, on], -1))
    a, b = solved[..., 0], solved[..., 1]
    return a + b * ((1 - (a * on).sum(1)) / (b * on).sum(1))[:, None]


def normalised_weights(squared: Array, valid: Bools) -> Array:
    """Gaussian kernel values made to sum to 1, the nearest first; shifted, so that a far set has weights too."""
    values = np.where(valid, KERNELS["gaussian"](squared - squared[:, :1]), 0)
    return values / values.sum(1, keepdims=True)


def choose(rule: Rule, distances: Distances, place: Array, rows: Ints, allowed: Bools) -> tuple[Ints, Array]:
    """Images [tasks, k] and weights for hits like `rows`, out of the images allowed [tasks, images]."""
    squared = np.where(allowed, distances.squared(rule, place, 0, slice(None), rows).T, np.inf)
    most = int(allowed.sum(1).max())
    count = min(rule.count or most, most)
    taken = min(rule.pool, most) if rule.greedy and rule.count else count
    picked = np.argsort(squared, axis=1, kind="stable")[:, :taken]
    near = np.take_along_axis(squared, picked, 1)
    valid = np.isfinite(near)
    if not rule.kriging:
        return picked, normalised_weights(near, valid)
    kernel = KERNELS[rule.kernel]
    near = np.where(valid, near, 0)
    target = kernel(near)
    pairs = kernel(distances.squared(rule, place[:, None, None], 1, picked[:, :, None], picked[:, None, :]))
    pairs += rule.nugget * np.eye(taken)
    if taken > count:
        chosen = greedy_choice(pairs, target, valid, count)
        valid, chosen = chosen >= 0, np.maximum(chosen, 0)
        picked, target = (np.take_along_axis(a, chosen, 1) for a in (picked, target))
        every = np.arange(len(rows))[:, None, None]
        pairs = pairs[every, chosen[:, :, None], chosen[:, None, :]]
    return picked, kriging_weights(pairs, target, valid)


def onto_modes(weights: Array, gram: Array, modes: int) -> Array:
    """Weights of the same sum projected onto the first principal modes of the carried images."""
    values, vectors = np.linalg.eigh(gram)
    values, vectors = values[:, -modes:], vectors[..., -modes:]
    along = np.einsum("tim,tij,tj->tm", vectors, gram, weights)
    return np.einsum("tim,tm->ti", vectors, along / np.maximum(values, 1e-9 * values[:, -1:]))


def errors(rule: Rule, moments: Moments, rows: Ints, picked: Ints, weights: Array) -> Array:
    """Relative L2 errors of the predictions."""
    gram = moments.gram[rows[:, None, None], picked[:, :, None], picked[:, None, :]].astype(float)
    cross = np.take_along_axis(moments.cross[rows], picked, 1)
    truth = moments.truth[rows]
    if rule.hindsight == "chosen":
        weights = best_weights(gram, cross)
    if rule.modes:
        weights = onto_modes(weights, gram, min(rule.modes, picked.shape[1]))
    if rule.rescaled:
        contact = np.einsum("tk,tkc->tc", weights, moments.contact[rows[:, None], picked])
        factor = (contact * moments.unit[rows]).sum(1) / np.maximum((contact**2).sum(1), 1e-9)
        weights = weights * np.clip(factor, 0, 2)[:, None]
    squared = np.einsum("ti,tij,tj->t", weights, gram, weights) - 2 * (weights * cross).sum(1) + truth
    return np.sqrt(np.maximum(squared, 0) / truth)


def best_weights(gram: Array, cross: Array) -> Array:
    """Least squares against the truth itself, with the slightest ridge."""
    ridge = 1e-6 * np.trace(gram, axis1=-2, axis2=-1)[..., None, None] / gram.shape[-1]
    return np.linalg.solve(gram + ridge * np.eye(gram.shape[-1]), cross[..., None])[..., 0]


def hindsight_errors(how: str, moments: Moments, rows: Ints, allowed: Bools) -> Array:
    """What no rule over these images can beat: the best single one, or the best weights of all."""
    found = np.zeros(len(rows))
    for t, row in enumerate(rows):
        on = np.flatnonzero(allowed[t])
        gram, cross, truth = moments.gram[row][np.ix_(on, on)].astype(float), moments.cross[row][on], moments.truth[row]
        if how == "single":
            squared = (np.diag(gram) - 2 * cross + truth).min()
        else:
            w = best_weights(gram, cross)
            squared = w @ gram @ w - 2 * w @ cross + truth
        found[t] = np.sqrt(max(squared, 0) / truth)
    return found
