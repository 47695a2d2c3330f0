"""How well a set that `crumple examples` makes predicts a finer simulation of impacts that it has not seen.

    python bindings/python/tools/accuracy.py [BODY.glb | can | framed] [--count 12] [--unseen 8] [--detail 1200] [--out FOLDER]

The body is the demo's hood, or a closed can or a panel on a frame, which tests/bodies.py makes.

The unseen impacts are drawn with another seed, with depths and places of their own, and are simulated on a shell with four times as many
points, and so with half the time step. The error is the relative L2 norm of the displacement over the body's points; no dent at all has error 1.
Told the blow: contact point and normal, the striker's mass, velocity and radius, and the normal momentum as the impulse, as a rigid-body
engine reports it. With one factor: the predicted displacement of the contact is multiplied by the median of true over predicted depths of the
other unseen impacts, as one calibrates a game's impulses. The run can be interrupted and repeated.
"""

from __future__ import annotations

import argparse
import csv
import platform
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import crumple
from crumple.examples import profile, run, shell
from crumple.examples.body import Body, Made
from crumple.examples.materials import MATERIALS
from crumple.examples.places import MARGIN, Places, as_example
from crumple.examples.solver import Solver

REPOSITORY = Path(__file__).resolve().parents[3]
COLUMNS = ("set_told_blow", "set_told_blow_one_factor", "set_told_displacement", "profile_told_displacement", "coarse_solver")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("body", nargs="?", type=Path, default=REPOSITORY / "assets/demo/hood.glb")
    parser.add_argument("--count", type=int, default=12)
    parser.add_argument("--unseen", type=int, default=8)
    parser.add_argument("--detail", type=int, default=1200, help="points of the shell; the truth's has four times as many")
    parser.add_argument("--out", type=Path, default=REPOSITORY / "out/accuracy")
    options = parser.parse_args()
    if str(options.body) in ("can", "framed"):
        options.body = scripted(str(options.body), options.out)
    body = Body(options.body, replace=True)
    depth = (0.005 * body.size, 0.03 * body.size)
    settings = run.Settings("steel", MATERIALS["steel"].thickness, "auto", ("ball",), depth, 30.0, options.detail, 1)
    folder = options.out / options.body.stem
    coarse = shell.make(body, options.detail, "auto")
    done = run.run(
        body,
        coarse,
        settings,
        run.Store(folder / "set", body, coarse, settings),
        options.count,
        progress=lambda n, e, t: print(n, t, e, flush=True),
    )
    unseen = truth(body, replace(settings, seed=2), folder / "unseen", options.unseen, lambda p: run.stiffness(done.results, coarse, p))
    carrier = shell.Carrier(coarse, body.points)
    examples = [replace(made, field=carrier.field(made.field)) for made in done.made]
    solver = Solver(coarse, MATERIALS[settings.material], settings.thickness)
    rows = []
    with crumple.Context(threads=1) as context:
        own = built(context, body, examples)
        generic = built(context, body, profile.make(body, options.count, depth))
        ratios = [depth_ratio(own, body, made) for made, _ in unseen]
        for number, (made, flight) in enumerate(unseen):
            vertex = int(np.linalg.norm(body.points - made.point, axis=1).argmin())
            moved = made.field[vertex]
            factor = float(np.median(ratios[:number] + ratios[number + 1 :]))
            again = solver.strike(flight)
            fields = (
                told(own, made, None), told(own, made, factor * predicted(own, made)), told(own, made, moved), told(generic, made, moved),
                np.zeros_like(body.points) if again.field is None else carrier.field(again.field),
            )  # fmt: skip
            row = [1000 * np.linalg.norm(moved), *(float(np.linalg.norm(f - made.field) / np.linalg.norm(made.field)) for f in fields)]
            rows.append(row)
            print(f"{made.name}: {row[0]:.1f} mm;", ", ".join(f"{name} {value:.2f}" for name, value in zip(COLUMNS, row[1:], strict=True)))
    with (folder / "accuracy.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(("depth_mm", *COLUMNS))
        table.writerows([f"{value:.4g}" for value in row] for row in rows)
    print(f"{options.body.stem}, {len(done.made)} examples, {len(rows)} unseen impacts, on {processor()}; median / 90th percentile:")
    for name, values in zip(COLUMNS, np.array(rows).T[1:], strict=True):
        print(f"  {name:26} {np.median(values):.2f} / {np.quantile(values, 0.9):.2f}")


def scripted(name: str, folder: Path) -> Path:
    """Writes one of the tests' bodies as a file."""
    sys.path.insert(0, str(REPOSITORY / "bindings/python/tests"))
    import bodies

    folder.mkdir(parents=True, exist_ok=True)
    points, triangles, *colours = getattr(bodies, name)()
    return bodies.write(folder / f"{name}.glb", [(points, triangles)], name=name, colours=colours[0] if colours else None)


def truth(body: Body, settings: run.Settings, folder: Path, count: int, stiffness):
    """The unseen impacts with their fields at the body's points, and their blows."""
    settings = replace(settings, detail=4 * settings.detail)
    fine = shell.make(body, settings.detail, "auto")
    carrier = shell.Carrier(fine, body.points)
    store = run.Store(folder, body, fine, settings)
    # Any dent is as good as the wanted one here.
    maker = run.Maker(fine, settings, near_enough=10)
    results = list(store.read())
    rng = np.random.default_rng(settings.seed)
    places = rng.choice(Places(fine, MARGIN).open, 10 * count)
    depths = np.exp(rng.uniform(*np.log(settings.depth), 10 * count))
    while sum(result.made is not None for result in results) < count and len(results) < 3 * count:
        index = len(results)
        vertex = int(places[index])
        result = maker.do(run.Task(index, vertex, float(depths[index]), stiffness(fine.points[vertex])))
        store.write(index, result)
        results.append(result)
        print("unseen", index, result.tries, flush=True)
    unseen = []
    for result in results:
        made = result.made
        if made is not None:
            speed = float(np.linalg.norm(made.velocity))
            blow = run.Blow(made.point, made.normal, made.velocity / speed, speed, made.mass, made.radius, made.shape)
            unseen.append((replace(made, field=carrier.field(made.field)), blow))
    return unseen


def built(context: crumple.Context, body: Body, examples: list[Made]) -> crumple.Instance:
    return context.example_set(body.points, body.triangles, [as_example(body.points, made) for made in examples]).instance()


def told(instance: crumple.Instance, made: Made, displacement) -> np.ndarray:
    """The field that is predicted for the blow, or for a displacement of its contact."""
    instance.reset()
    if displacement is None:
        blow(instance, made)
    else:
        instance.hit_displacement(made.point, displacement)
    return instance.deformed().positions.astype(float) - instance.set.mesh().positions


def blow(instance: crumple.Instance, made: Made, preview: bool = False) -> crumple.HitResult:
    impulse = made.mass * float(made.velocity @ made.normal) * made.normal
    striker = crumple.Striker(made.mass, made.radius, made.velocity)
    return instance.hit(made.point, impulse, made.duration, normal=made.normal, striker=striker, preview=preview)


def predicted(instance: crumple.Instance, made: Made) -> np.ndarray:
    """The displacement of the contact that the set expects of the blow."""
    return blow(instance, made, preview=True).target


def depth_ratio(instance: crumple.Instance, body: Body, made: Made) -> float:
    vertex = int(np.linalg.norm(body.points - made.point, axis=1).argmin())
    return float(np.linalg.norm(made.field[vertex]) / np.linalg.norm(predicted(instance, made)))


def processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


if __name__ == "__main__":
    main()
