"""Which selection rule is best, by cross-validation on the training impacts of both truths.

    python lab/python/candidates.py [--quick] --out DIRECTORY

Writes candidates.csv. Every candidate predicts whole displacement fields of impacts from those of other simulations, given
only contact and displacement there: each row from all others, and all others from spread-out sets of 4, 8 and 16 rows. What a
rule learns, it learns without the row predicted. The held-out impacts are not opened.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import csv
import platform
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy

from study.body import Array, Body, Ints
from study.candidates import Candidate, candidates
from study.carry import Volume, moments
from study.validation import Bench, Tasks, leave_one_out, spread_out

DATA = Path(__file__).resolve().parent.parent / "data"
BODIES = [(truth, body) for truth in ("shots", "presses") for body in ("panel", "tube")]
# Every other vertex is judged: a checkerboard of the bodies' grids. Quick: a coarse sample.
THIN, THIN_QUICK = 2, 8
COLUMNS = ["candidate", "description", "truth", "body", "examples", "cv_median", "cv_mean", "cv_p90", "change_percent", "kept", "why"]

# Resamplings of the simulations, for the spread of a mean change.
DRAWS = 400

Cell = tuple[str, str, int | str]


@dataclass
class Found:
    """Errors of all candidates on one body from sets of one size, and the simulations that the rows predicted come from."""

    source: Ints
    errors: dict[str, Array]

    def change(self, name: str, other: str) -> float:
        """Of the mean error, in percent."""
        return 100 * (self.errors[name].mean() / self.errors[other].mean() - 1)

    def resampled(self, name: str, draws: Ints) -> Array:
        """Mean errors over simulations drawn [draws, simulations]; the first draw holds each once."""
        sums, counts = (np.bincount(self.source, w, minlength=draws.shape[1]) for w in (self.errors[name], None))
        return draws @ sums / (draws @ counts)


def protocols(body: Body, quick: bool) -> dict[int | str, Tasks]:
    """The sets of rows that predict, by their size."""
    sets: dict[int | str, Tasks] = {n: spread_out(body, n) for n in ((8,) if quick else (4, 8, 16))}
    return sets | {"all but one": leave_one_out(body)}


def measure(truth: str, name: str, tried: list[Candidate], quick: bool) -> tuple[dict[Cell, Found], str]:
    """Errors of all candidates on one body, and how many there are."""
    body = Body(DATA / truth / name, THIN_QUICK if quick else THIN)
    volume = Volume(body)
    known = {}
    for carry in dict.fromkeys(c.rule.carry for c in tried):
        windows = list(dict.fromkeys(c.rule.window for c in tried if c.rule.carry == carry))
        known |= {(carry, w): m for w, m in moments(body, volume, carry, windows).items()}
    bench, sets = Bench(body, known), protocols(body, quick)
    simulation = np.unique(body.source, return_inverse=True)[1]
    found = {(truth, name, n): Found(simulation[t.row], {c.name: bench.validate(c.rule, t) for c in tried}) for n, t in sets.items()}
    counts = ", ".join(f"{len(t.row)} from {n}" for n, t in sets.items())
    return found, f"{truth} {name}: {len(body)} impacts of {simulation.max() + 1} simulations, {len(body.images)} images; predictions: {counts}"


def spread(found: dict[Cell, Found], name: str, other: str) -> tuple[float, float]:
    """Change of the mean error over all bodies and sets, geometric mean, and its standard error, in percent."""
    random, draws, logs = np.random.default_rng(1), {}, []
    for (truth, body, _), f in found.items():
        if (truth, body) not in draws:
            n = max(g.source.max() for (t, b, _), g in found.items() if (t, b) == (truth, body)) + 1
            draws[truth, body] = np.vstack([np.ones(n, int), random.multinomial(n, np.full(n, 1 / n), DRAWS)])
        # A draw that misses every row predicted from these sets says nothing of them.
        with np.errstate(invalid="ignore"):
            logs.append(np.log(f.resampled(name, draws[truth, body]) / f.resampled(other, draws[truth, body])))
    means = np.exp(np.nanmean(logs, axis=0))
    return 100 * (means[0] - 1), 100 * float(means[1:].std())


def reason(c: Candidate, found: dict[Cell, Found]) -> str:
    """The change over everything, its standard error, and in how many bodies and sets it is for the better."""
    if c.name == c.compared_with:
        return "what the others are compared with"
    mean, error = spread(found, c.name, c.compared_with)
    better = sum(f.change(c.name, c.compared_with) < 0 for f in found.values())
    text = f"{mean:+.1f} % (s.e. {error:.1f}) against the {c.compared_with}; better in {better} of {len(found)}"
    return f"{text}; {c.note}" if c.note else text


def cpu() -> str:
    """The processor's name, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    names = [line.split(":", 1)[1].strip() for line in info.read_text().splitlines() if line.startswith("model name")] if info.exists() else []
    return names[0] if names else platform.processor() or platform.machine()


def write(path: Path, tried: list[Candidate], found: dict[Cell, Found], counts: list[str]) -> None:
    """The table, with what it was made from on top."""
    comments = [
        ("machine", cpu()),
        ("numpy", np.__version__),
        ("scipy", scipy.__version__),
        ("command", "python lab/python/candidates.py"),
        ("protocol", "cross-validation on train.npz of both truths by simulation; impacts that leave under 5 mm are left out"),
        ("why", f"change of cv_mean over all bodies and sets, geometric mean; s.e. from {DRAWS} resamplings of the simulations"),
        ("change_percent", "of cv_mean, against the baseline of the same truth, body and examples"),
        *(("n", text) for text in counts),
    ]
    with path.open("w", newline="") as file:
        file.writelines(f"# {key}: {text}\n" for key, text in comments)
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(COLUMNS)
        for c in tried:
            why = reason(c, found)
            for (truth, body, n), f in found.items():
                e = f.errors[c.name]
                figures = [f"{x:.4f}" for x in (np.median(e), e.mean(), np.quantile(e, 0.9))]
                rows.writerow([c.name, c.description, truth, body, n, *figures, f"{f.change(c.name, 'baseline'):.1f}", "yes" if c.kept else "no", why])


def main() -> None:
    """Measures all candidates on all bodies and writes the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="the steps only, coarsely, in seconds")
    parser.add_argument("--out", type=Path, required=True, help="directory for candidates.csv")
    options = parser.parse_args()
    start = time.perf_counter()
    tried = candidates(options.quick)
    found: dict[Cell, Found] = {}
    counts = []
    for truth, name in BODIES:
        own, count = measure(truth, name, tried, options.quick)
        found |= own
        counts.append(count)
        print(f"{count} ({time.perf_counter() - start:.0f} s)", flush=True)
    options.out.mkdir(parents=True, exist_ok=True)
    write(options.out / "candidates.csv", tried, found, counts)
    print(f"candidates: {len(tried)} in {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
