"""MuJoCo's elasto-plastic flex on the lab's held-out hits, and where it fails.

    python lab/python/mujoco_peer.py [--quick] [--out DIR]     writes peers_mujoco.csv and stability_peers_mujoco.csv
    python lab/python/mujoco_peer.py --calibrate               the search behind the yields of the presses (training only)

MuJoCo is given the ball, its mass and its speed (shots) or its path (presses); it computes contact and depth itself.
"""

from __future__ import annotations

import argparse
import csv
import os
import platform
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from grids import Floats, field_error, interpolate
from mujoco_shell import PRESSES, SHOTS, Impact, Material, Outcome, Shell, load_impacts, truth_grid

VERSION = mujoco.__version__
DATA = str(Path(__file__).resolve().parents[1] / "data")
BODIES = ("panel", "tube")
MATERIALS = {"shots": SHOTS, "presses": PRESSES}

ACCURACY_COLUMNS = (
    "peer version body truth setting quality rel_l2_median rel_l2_p90 scaled_rel_l2_median scaled_rel_l2_p90"
    " max_error_mm_median us_per_impact bytes failures n"
).split()
STABILITY_COLUMNS = (
    "peer version body sweep value unit outcome max_displacement_m inverted_triangles depth_mm cpu_s_per_simulated_s"
).split()


@dataclass(frozen=True)
class Quality:
    """Cells per side against the truth's grid, time step, and how many held-out hits to run (first ones)."""

    cells: float
    step_ms: float
    hits: int

    @property
    def label(self) -> str:
        return f"{self.cells:g}x cells, {self.step_ms:g} ms"


FULL = {
    "shots": [Quality(0.25, step, 16) for step in (4, 2, 1)]
    + [Quality(0.5, step, 16) for step in (4, 2, 1, 0.5)]
    + [Quality(1, 4, 6), Quality(1, 2, 6), Quality(1, 1, 5), Quality(1, 0.5, 2), Quality(2, 1, 1)],
    "presses": [Quality(0.25, 2, 6), Quality(0.25, 1, 6), Quality(0.5, 2, 6), Quality(0.5, 1, 6), Quality(1, 1, 2)],
}
QUICK = {
    "shots": [Quality(0.25, 2, 4), Quality(0.5, 2, 2), Quality(0.5, 1, 2)],
    "presses": [Quality(0.25, 1, 1)],
}
SWEEPS = {
    "time step": ("ms", (0.25, 0.5, 1, 2, 4, 8, 16, 33)),
    "stiffness": ("times", (0.01, 0.1, 1, 10, 100, 1000)),
    "impact speed": ("m/s", (1, 3, 10, 30, 100, 300, 1000)),
}
QUICK_SWEEPS = {
    "time step": ("ms", (1, 4, 33)),
    "stiffness": ("times", (0.01, 1, 1000)),
    "impact speed": ("m/s", (10, 1000)),
}
SWEEP_CELLS, SWEEP_STEP_MS = 0.5, 1.0


def processor() -> str:
    """The processor's name, where the system tells it."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def write_csv(path: Path, columns: list[str], comments: dict[str, str], rows: list[dict[str, object]]) -> None:
    """A CSV whose first lines are `# key: value`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    machine = {"machine": processor(), "cores": str(os.cpu_count()), "mujoco": VERSION, "numpy": np.__version__}
    with path.open("w", newline="") as file:
        for key, value in {**machine, "python": platform.python_version(), **comments}.items():
            file.write(f"# {key}: {value}\n")
        table = csv.DictWriter(file, columns, lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def percentile(values: list[float], share: float) -> float:
    """Like numpy's, but an infinite neighbour makes the result infinite instead of undefined."""
    ordered = np.sort(np.asarray(values))
    place = share * (len(ordered) - 1)
    low, high = ordered[int(np.floor(place))], ordered[int(np.ceil(place))]
    return float(high if np.isinf(high) else low + (high - low) * (place - np.floor(place)))


def on_truth_grid(shell: Shell, outcome: Outcome) -> Floats | None:
    """The field at the truth's vertices."""
    if outcome.field is None:
        return None
    return interpolate(outcome.field, shell.grid, truth_grid(shell.grid.truth, shell.grid.body))


def has_failed(shell: Shell, outcome: Outcome, truth: Floats) -> bool:
    """NaN, a vertex further away than the body is large, or more inverted triangles than the truth has."""
    if outcome.field is None or not np.isfinite(outcome.field).all():
        return True
    diagonal = np.linalg.norm(np.ptp(shell.base, axis=0))
    in_truth = interpolate(truth, truth_grid(shell.grid.truth, shell.grid.body), shell.grid)
    too_far = np.linalg.norm(outcome.field, axis=1).max() > diagonal
    return bool(too_far or shell.inverted(outcome.field) > shell.inverted(in_truth))


def measure(truth: str, body: str, quality: Quality, material: Material, which: str = "heldout") -> dict[str, object]:
    """One row of the accuracy table."""
    impacts, fields = load_impacts(DATA, truth, body, which)
    impacts, fields = impacts[: quality.hits], fields[: quality.hits]
    shell = Shell(truth_grid(truth, body).resized(quality.cells), material, quality.step_ms * 1e-3)
    outcomes = [shell.hit(impact) for impact in impacts]
    errors = [field_error(on_truth_grid(shell, o), f, i.vertex) for o, f, i in zip(outcomes, fields, impacts)]
    own = truth == "shots" and quality.cells == 1 and quality.step_ms == 1 and material == SHOTS
    unconverged = sum(o.unconverged for o in outcomes) / max(1, sum(o.steps for o in outcomes))
    notes = [f"grid {shell.grid.nu} x {shell.grid.nv}", f"{unconverged:.0%} of the steps stopped at 100 CG iterations"]
    notes += ["the truth's own solver and setting: its noise floor"] if own else []
    notes += ["no plasticity: elastic control"] if material.yield_stretch == 0 else []
    return {
        "peer": "MuJoCo flex" if material.yield_stretch > 0 else "MuJoCo flex, elastic",
        "version": VERSION,
        "body": body,
        "truth": truth,
        "setting": "; ".join(notes),
        "quality": quality.label + (" (noise floor)" if own else ""),
        "rel_l2_median": f"{percentile([e.relative_l2 for e in errors], 0.5):.4f}",
        "rel_l2_p90": f"{percentile([e.relative_l2 for e in errors], 0.9):.4f}",
        "scaled_rel_l2_median": f"{percentile([e.scaled_relative_l2 for e in errors], 0.5):.4f}",
        "scaled_rel_l2_p90": f"{percentile([e.scaled_relative_l2 for e in errors], 0.9):.4f}",
        "max_error_mm_median": f"{percentile([e.largest_mm for e in errors], 0.5):.3f}",
        "us_per_impact": f"{1e6 * float(np.median([o.seconds for o in outcomes])):.0f}",
        "bytes": shell.bytes(),
        "failures": sum(has_failed(shell, o, f) for o, f in zip(outcomes, fields)),
        "n": len(impacts),
    }


def accuracy(quick: bool) -> Iterator[dict[str, object]]:
    """All rows of peers_mujoco.csv; the elastic control last."""
    for truth, qualities in (QUICK if quick else FULL).items():
        for body in BODIES:
            for quality in qualities:
                yield measure(truth, body, quality, MATERIALS[truth])
    for body in BODIES:
        yield measure("shots", body, Quality(0.5, 1, 1 if quick else 8), replace(SHOTS, yield_stretch=0.0, yield_bend=0.0))


def sweep_impact(body: str) -> tuple[Impact, Floats]:
    """The training shot of median depth: the reference of the sweeps."""
    impacts, fields = load_impacts(DATA, "shots", body, "train")
    depths = [np.linalg.norm(f[i.vertex]) for i, f in zip(impacts, fields)]
    median = int(np.argsort(depths)[len(depths) // 2])
    return impacts[median], fields[median]


def true_depth_mm(body: str) -> float:
    """What the truth's own setting left at the contact of the sweeps' shot."""
    impact, field = sweep_impact(body)
    return 1e3 * float(np.linalg.norm(field[impact.vertex]))


def sweep_case(body: str, impact: Impact, sweep: str, value: float) -> tuple[Shell, Outcome]:
    """The reference with one thing changed."""
    step = value if sweep == "time step" else SWEEP_STEP_MS
    material = SHOTS.stiffened(value) if sweep == "stiffness" else SHOTS
    shell = Shell(truth_grid("shots", body).resized(SWEEP_CELLS), material, step * 1e-3)
    return shell, shell.hit(replace(impact, amount=float(value)) if sweep == "impact speed" else impact)


def stability_row(
    body: str, impact: Impact, reference: tuple[float, int], sweep: str, unit: str, value: float
) -> dict[str, object]:
    """One row of the stability table; `reference` is the depth and the inverted triangles of the unchanged case."""
    shell, outcome = sweep_case(body, impact, sweep, value)
    field = on_truth_grid(shell, outcome)
    usual_depth, usual_inverted = reference
    row: dict[str, object] = {"peer": "MuJoCo flex", "version": VERSION, "body": body, "sweep": sweep, "value": value}
    row |= {"unit": unit, "cpu_s_per_simulated_s": f"{outcome.seconds / outcome.simulated:.3f}"}
    if field is None or not np.isfinite(field).all():
        return row | {"outcome": "nan", "max_displacement_m": "", "inverted_triangles": "", "depth_mm": ""}
    largest = float(np.linalg.norm(field, axis=1).max())
    flips = max(0, shell.inverted(outcome.field) - usual_inverted)
    depth = float(np.linalg.norm(field[impact.vertex]))
    # A ball slower than the reference may spring back and leave nothing: that is no fault.
    may_vanish = sweep == "impact speed" and value < impact.amount
    if largest > np.linalg.norm(np.ptp(shell.base, axis=0)):
        verdict = "exploded"
    elif flips:
        verdict = "inverted"
    else:
        verdict = "lost" if depth < 0.1 * usual_depth and not may_vanish else "ok"
    return row | {
        "outcome": verdict,
        "max_displacement_m": f"{largest:.6g}",
        "inverted_triangles": flips,
        "depth_mm": f"{1e3 * depth:.3f}",
    }


def stability(quick: bool) -> Iterator[dict[str, object]]:
    """All rows of stability_peers_mujoco.csv."""
    for body in BODIES[:1] if quick else BODIES:
        impact, _ = sweep_impact(body)
        shell, outcome = sweep_case(body, impact, "time step", SWEEP_STEP_MS)
        field = on_truth_grid(shell, outcome)
        reference = float(np.linalg.norm(field[impact.vertex])), shell.inverted(outcome.field)
        for sweep, (unit, values) in (QUICK_SWEEPS if quick else SWEEPS).items():
            for value in values:
                yield stability_row(body, impact, reference, sweep, unit, value)


def calibrate() -> None:
    """Yield strains for the presses, on two training simulations a body at half the grid's cells and 1 ms."""
    for stretch in (0.00015, 0.0003, 0.0006, 0.0012):
        for bend in (0.00015, 0.0003, 0.0006, 0.0012):
            material = replace(PRESSES, yield_stretch=stretch, yield_bend=bend)
            rows = [measure("presses", body, Quality(0.5, 1, 2), material, "train") for body in BODIES]
            print(stretch, bend, *(f"{r['body']} {r['rel_l2_median']} {r['scaled_rel_l2_median']}" for r in rows), flush=True)


def collect(rows: Iterator[dict[str, object]]) -> list[dict[str, object]]:
    """Prints rows as they come."""
    kept = []
    for row in rows:
        print(*row.values(), sep=" | ", flush=True)
        kept.append(row)
    return kept


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a few hits and settings, under half a minute")
    parser.add_argument("--out", type=Path, default=Path("docs/lab"), help="where the CSVs go")
    parser.add_argument("--calibrate", action="store_true", help="print the search for the presses' yields and stop")
    options = parser.parse_args()
    if options.calibrate:
        return calibrate()
    started = time.monotonic()
    shared = {
        "command": "python lab/python/mujoco_peer.py" + (" --quick" if options.quick else ""),
        "settings": "flex dim 2, elastic2d both, integrator discrete, CG, defaults otherwise; one thread (CPU time of it)",
    }
    write_csv(
        options.out / "peers_mujoco.csv",
        ACCURACY_COLUMNS,
        shared
        | {
            "errors": "relative L2 at the truth's vertices; scaled: after one factor gave the contact the true displacement",
            "bytes": "state of one instance, without the model, which instances can share",
            "failures": "NaN, exploded or inverted beyond the truth",
        },
        collect(accuracy(options.quick)),
    )
    write_csv(
        options.out / "stability_peers_mujoco.csv",
        STABILITY_COLUMNS,
        shared
        | {
            "reference": f"the training shot of median depth, {SWEEP_CELLS:g}x cells, {SWEEP_STEP_MS:g} ms",
            "stiffness": "elastic modulus times this, yield stress kept (yield strain divided)",
            **{f"true depth {b}": f"{true_depth_mm(b):.2f} mm" for b in BODIES},
            "lost": "depth under a tenth of the reference's (not for balls slower than it)",
        },
        collect(stability(options.quick)),
    )
    print(f"{time.monotonic() - started:.0f} s")


if __name__ == "__main__":
    main()
