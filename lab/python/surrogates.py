"""Learned surrogates on the same examples and hits as Crumple: POD with kriging, and a small neural field.

    python lab/python/surrogates.py [--quick] [--out DIR]     writes told_surrogates.csv
    python lab/python/surrogates.py --choose                  leave-one-out errors, on training impacts only

Both predict the shape of a displacement field and multiply it by the depth: the depth that they are told, or a power law of the
blow with kriging of what it leaves over.
"""

from __future__ import annotations

import argparse
import csv
import time
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sklearn.exceptions import ConvergenceWarning
from sklearn.neural_network import MLPRegressor

DATA = Path(__file__).resolve().parents[1] / "data"
BODIES = [("shots", "panel"), ("shots", "tube"), ("presses", "panel"), ("presses", "tube"), ("structure", "door"), ("structure", "box"), ("steel", "hood")]
COLUMNS = (
    "truth body train test told method examples rel_l2_median rel_l2_p25 rel_l2_p75 rel_l2_p90 depth_error_median us_per_impact n weak"
    " weak_kept train_s"
).split()
# As in the lab: weak hits are counted, and presses that sprang back are left out, m.
WEAK, LEAST_PRESS = 2e-3, 5e-3
# Share of the examples' energy that the modes keep.
ENERGY = 0.99
FRICTION = 0.4

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Hits:
    """Impacts, one a row: the contact, what is known of the blow, and the truth."""

    point: Floats
    target: Floats
    # Normal impulse (N s), tangential impulse over it, mass and radius of the striker: [n], [n, 3], [n], [n]. None for presses.
    blow: tuple[Floats, Floats, Floats, Floats] | None
    fields: Floats
    normal: Floats
    radius: Floats

    @property
    def depth(self) -> Floats:
        return np.linalg.norm(self.target, axis=1)

    def of(self, rows: NDArray[np.int64] | slice) -> Hits:
        blow = self.blow and tuple(b[rows] for b in self.blow)
        return Hits(self.point[rows], self.target[rows], blow, self.fields[rows], self.normal[rows], self.radius[rows])

    def __len__(self) -> int:
        return len(self.point)


@dataclass(frozen=True)
class Body:
    vertices: Floats
    normals: Floats
    pinned: NDArray[np.bool_]

    @staticmethod
    def load(truth: str, body: str) -> Body:
        base = np.load(DATA / truth / body / "base.npz")
        vertices = base["vertices"].astype(float)
        pinned = base["pinned"] if "pinned" in base else np.zeros(len(vertices), bool)
        return Body(vertices, base["normals"].astype(float), pinned)


def load(truth: str, body: str, name: str) -> Hits:
    archive = np.load(DATA / truth / body / f"{name}.npz")
    fields = archive["fields"] * float(archive["step"])
    target = fields[np.arange(len(fields)), archive["contact_vertex"]]
    blow = None
    if "mass" in archive:
        normal, velocity, mass = (archive[k].astype(float) for k in ("contact_normal", "velocity", "mass"))
        along = -(velocity * normal).sum(1)
        across = velocity + along[:, None] * normal
        share = np.minimum(1, FRICTION * along / np.maximum(np.linalg.norm(across, axis=1), 1e-9))
        blow = (mass * along, across * (share / along)[:, None], mass, archive["radius"].astype(float))
    vertex_normals = np.load(DATA / truth / body / "base.npz")["normals"][archive["contact_vertex"]]
    normal = (archive["contact_normal"] if blow else vertex_normals).astype(float)
    radius = archive["radius" if blow else "punch_radius"].astype(float)
    hits = Hits(archive["contact_point"].astype(float), target, blow, fields, normal, radius)
    return hits.of(hits.depth >= LEAST_PRESS) if truth == "presses" and name == "heldout" else hits


def features(hits: Hits, told: str) -> tuple[Floats, Floats]:
    """Where the hit is, [n, 3], and what else is told of it, [n, m]."""
    if told == "displacement":
        size = np.maximum(hits.depth, 1e-3)
        return hits.point, np.column_stack([np.log(size), hits.target / size[:, None]])
    impulse, across, mass, radius = hits.blow
    told_more = [np.log(mass), np.log(radius)] if told == "blow" else []
    return hits.point, np.column_stack([np.log(impulse), *told_more, across])


class Scaled:
    """Places in units of their spread, and each other feature in units of its own."""

    def __init__(self, place: Floats, other: Floats):
        self.place, self.other = (place.mean(0), place.std() + 1e-9), (other.mean(0), other.std(0) + 1e-2)

    def __call__(self, place: Floats, other: Floats) -> tuple[Floats, Floats]:
        return (place - self.place[0]) / self.place[1], (other - self.other[0]) / self.other[1]


class Kriging:
    """Gaussian process with one length for places, one for all other features, and noise; lengths by the likelihood."""

    def __init__(self, place: Floats, other: Floats, values: Floats):
        self.scaled = Scaled(place, other)
        self.x = self.scaled(place, other)
        self.mean = values.mean(0)
        rest = values - self.mean
        squares = [squared(a, a) for a in self.x]
        scale = (rest**2).sum() / len(rest) + 1e-300
        best = (-np.inf, None)
        for place_length in (0.35, 0.5, 0.7, 1, 1.4, 2, 4):
            for other_length in (1, 2, 4, 8, 16):
                for noise in (1e-4, 1e-2, 1e-1, 0.5):
                    k = np.exp(-0.5 * (squares[0] / place_length**2 + squares[1] / other_length**2)) + noise * np.eye(len(rest))
                    factor = np.linalg.cholesky(k)
                    white = np.linalg.solve(factor, rest)
                    # The variance is common to all columns, and at its likeliest.
                    variance = (white**2).sum() / rest.size + 1e-12 * scale
                    likelihood = -rest.size * np.log(variance) - 2 * rest.shape[1] * np.log(np.diag(factor)).sum()
                    if likelihood > best[0]:
                        best = (likelihood, (place_length, other_length, factor, white))
        self.lengths, factor, white = best[1][:2], *best[1][2:]
        self.weights = np.linalg.solve(factor.T, white)

    def __call__(self, place: Floats, other: Floats) -> Floats:
        at = self.scaled(place, other)
        exponent = sum(squared(a, b) / length**2 for a, b, length in zip(at, self.x, self.lengths))
        return self.mean + np.exp(-0.5 * exponent) @ self.weights


def squared(a: Floats, b: Floats) -> Floats:
    return ((a[:, None] - b[None]) ** 2).sum(-1)


class Field:
    """A neural field: a small network from a vertex and a hit to the vertex's displacement over the depth.

    It sees the vertex relative to the contact, in a frame of the contact normal, and where it is and looks on the body.
    """

    # Vertices of each example that it learns from, at random.
    VERTICES = 1000

    def __init__(self, train: Hits, body: Body, epochs: int):
        random = np.random.default_rng(0)
        some = [random.permutation(len(body.vertices))[: self.VERTICES] for _ in range(len(train))]
        x = np.concatenate([self.inputs(train, i, body, train.depth[i])[rows] for i, rows in enumerate(some)])
        self.centre, self.scale = x.mean(0), x.std(0) + 1e-6
        y = train.fields / np.maximum(train.depth, 4e-3)[:, None, None]
        y = np.concatenate([y[i, rows] @ frame(train.normal[i]) for i, rows in enumerate(some)])
        self.size = y.std()
        self.net = MLPRegressor(hidden_layer_sizes=(64, 64), learning_rate_init=3e-3, batch_size=512, max_iter=epochs, random_state=0)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            self.net.fit(((x - self.centre) / self.scale).astype(np.float32), (y / self.size).astype(np.float32))

    @staticmethod
    def inputs(hits: Hits, i: int, body: Body, depth: float) -> Floats:
        relative = (body.vertices - hits.point[i]) @ frame(hits.normal[i])
        far = np.linalg.norm(relative, axis=1)[:, None]
        hit = [np.log(max(depth, 1e-3)), *hits.point[i], *hits.normal[i], hits.radius[i]]
        near = np.exp(-((far / [0.05, 0.1, 0.2, 0.4]) ** 2))
        return np.hstack([relative, near, body.vertices, body.normals, np.tile(hit, (len(far), 1))])

    def __call__(self, hits: Hits, depths: Floats, body: Body) -> Floats:
        fields = []
        for i, depth in enumerate(depths):
            x = (self.inputs(hits, i, body, depth) - self.centre) / self.scale
            shape = self.net.predict(x.astype(np.float32)) * self.size
            fields.append((shape * depth) @ frame(hits.normal[i]).T)
        fields = np.array(fields)
        fields[:, body.pinned] = 0
        return fields


def frame(normal: Floats) -> Floats:
    """Columns: two tangents, the first level, and the normal."""
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    u = np.cross(axis, normal)
    u /= np.linalg.norm(u)
    return np.column_stack([u, np.cross(normal, u), normal])


class Depth:
    """ln depth from the blow: a power law that is pulled toward the root of the energy (or the impulse), and kriging of the rest."""

    def __init__(self, train: Hits, told: str):
        self.told = told
        y, x = np.log(np.maximum(train.depth, 1e-3)), self.logs(train)
        usual = np.array([1, -0.5, 0][: x.shape[1]]) if told == "blow" else np.array([1.0])
        self.x, self.y = x.mean(0), y.mean()
        x = x - self.x
        self.exponents = usual + np.linalg.solve(x.T @ x + np.eye(x.shape[1]), x.T @ (y - self.y - x @ usual))
        place, other = features(train, told)
        self.rest = Kriging(place, other, (y - self.law(train))[:, None])

    def logs(self, hits: Hits) -> Floats:
        impulse, _, mass, radius = hits.blow
        return np.log(np.column_stack([impulse, mass, radius] if self.told == "blow" else [impulse]))

    def law(self, hits: Hits) -> Floats:
        return self.y + (self.logs(hits) - self.x) @ self.exponents

    def __call__(self, hits: Hits) -> Floats:
        return np.exp(self.law(hits) + self.rest(*features(hits, self.told))[:, 0])


class Surrogate:
    """Shapes times a depth: the depth that is told, or that of the blow."""

    def __init__(self, train: Hits, told: str, body: Body):
        self.told, self.body = told, body
        self.depth = None if told == "displacement" else Depth(train, told)
        self.fit(train)

    def fit(self, train: Hits) -> None:
        raise NotImplementedError

    def shapes(self, hits: Hits, depths: Floats) -> Floats:
        raise NotImplementedError

    def __call__(self, hits: Hits) -> Floats:
        depths = hits.depth if self.depth is None else self.depth(hits)
        return self.shapes(hits, depths)


class Modes(Surrogate):
    """Proper orthogonal decomposition of the examples' shapes, and kriging of the coefficients. lab/src/accuracy/pod.rs has the same."""

    def fit(self, train: Hits) -> None:
        # A shallow dent's shape is mostly noise: it counts less.
        flat = train.fields.reshape(len(train), -1) / np.maximum(train.depth, 4e-3)[:, None]
        self.mean = flat.mean(0)
        _, s, modes = np.linalg.svd(flat - self.mean, full_matrices=False)
        kept = min(len(s), 1 + int(np.searchsorted(np.cumsum(s**2), ENERGY * (s**2).sum())))
        self.modes = modes[:kept]
        self.coefficients = Kriging(*features(train, self.told), (flat - self.mean) @ self.modes.T)

    def shapes(self, hits: Hits, depths: Floats) -> Floats:
        flat = self.mean + self.coefficients(*features(hits, self.told)) @ self.modes
        return (flat * depths[:, None]).reshape(len(hits), -1, 3)


class NeuralField(Surrogate):
    """The network is the same whatever is told, so it is trained once."""

    EPOCHS = 40
    trained: dict[tuple[int, int], tuple[Field, float]] = {}

    def fit(self, train: Hits) -> None:
        key = (id(self.body), len(train))
        if key not in self.trained:
            started = time.process_time()
            self.trained[key] = (Field(train, self.body, self.EPOCHS), 0.0)
            self.trained[key] = (self.trained[key][0], time.process_time() - started)
        self.field, self.train_s = self.trained[key]

    def shapes(self, hits: Hits, depths: Floats) -> Floats:
        return self.field(hits, depths, self.body)


METHODS = {"POD and kriging": Modes, "neural field": NeuralField}


def relative_l2(predicted: Floats, truth: Floats) -> Floats:
    size = lambda f: np.sqrt((f**2).sum((1, 2)))
    return size(predicted - truth) / size(truth)


def row(train: Hits, test: Hits, told: str, method: str, body: Body, repeats: int) -> dict[str, object]:
    started = time.process_time()
    surrogate = METHODS[method](train, told, body)
    train_s = time.process_time() - started
    train_s = max(train_s, getattr(surrogate, "train_s", 0.0))
    fields = surrogate(test)
    times = []
    for i in range(len(test)):
        one = test.of(slice(i, i + 1))
        for _ in range(repeats):
            started = time.thread_time()
            surrogate(one)
            times.append(1e6 * (time.thread_time() - started))
    errors = relative_l2(fields, test.fields)
    # At the contact, which is the vertex whose displacement is the target.
    contact = np.abs(test.fields - test.target[:, None]).sum(2).argmin(1)
    left = np.linalg.norm(fields[np.arange(len(test)), contact], axis=1)
    weak = test.depth < WEAK
    quantile = lambda q: np.quantile(errors[~weak], q)
    return {
        "rel_l2_median": quantile(0.5), "rel_l2_p25": quantile(0.25), "rel_l2_p75": quantile(0.75), "rel_l2_p90": quantile(0.9),
        "depth_error_median": np.median(np.abs(left / test.depth - 1)[~weak]), "us_per_impact": np.median(times),
        "n": (~weak).sum(), "weak": weak.sum(), "weak_kept": (left < WEAK)[weak].sum(), "train_s": train_s,
    }


def cases() -> list[tuple[str, str, str, tuple[str, ...]]]:
    """Truth, body, training set and test sets."""
    found = []
    for truth, body in BODIES:
        tests = ("heldout", "play") if truth == "structure" else ("heldout",)
        found += [(truth, body, train, tests) for train in ("train", "train_free") if train == "train" or truth == "structure"]
    return found


def choose() -> None:
    """Leave-one-out errors, by training impacts only."""
    variants = [("POD and kriging", 0), *(("neural field", epochs) for epochs in (20, 40, 80))]
    for method, NeuralField.EPOCHS in variants:
        medians = []
        # Of the presses, the symmetry copies of one simulation would give it away.
        for truth, name in (b for b in BODIES if b[0] != "presses"):
            train, body = load(truth, name, "train").of(slice(0, 24)), Body.load(truth, name)
            errors = []
            for i in range(0, len(train), 6):
                NeuralField.trained.clear()
                rest, one = np.delete(np.arange(len(train)), i), train.of(slice(i, i + 1))
                errors += [*relative_l2(METHODS[method](train.of(rest), "blow", body)(one), one.fields)]
            medians.append(np.median(errors))
        print(method, NeuralField.EPOCHS, np.round(medians, 3), round(float(np.mean(medians)), 3), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--choose", action="store_true")
    parser.add_argument("--out", type=Path, default=Path("docs/lab"))
    options = parser.parse_args()
    if options.choose:
        choose()
        return
    if options.quick:
        NeuralField.EPOCHS = 2
    options.out.mkdir(parents=True, exist_ok=True)
    with (options.out / "told_surrogates.csv").open("w", newline="") as file:
        file.write("# command: cargo xtask lab --only told\n# us_per_impact: one thread, NumPy; train_s: one thread\n")
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for truth, body, train_name, tests in cases():
            train, mesh = load(truth, body, train_name), Body.load(truth, body)
            NeuralField.trained.clear()
            for count in (4, 24) if options.quick else (4, 8, 16, 24, len(train)):
                for told in ("displacement", "blow", "impulse") if train.blow else ("displacement",):
                    for method in METHODS:
                        for test_name in tests:
                            test = load(truth, body, test_name)
                            test = test.of(slice(0, 4)) if options.quick else test
                            cells = row(train.of(slice(0, count)), test, told, method, mesh, 1 if options.quick else 3)
                            cells = {k: format(v, ".5g") for k, v in cells.items()}
                            head = {"truth": truth, "body": body, "train": train_name, "test": test_name, "told": told, "method": method, "examples": count}
                            writer.writerow(head | cells)
            print(f"surrogates: {truth} {body} {train_name}", flush=True)


if __name__ == "__main__":
    main()
