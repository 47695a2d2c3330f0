"""Minutes and expected error against the number of examples that `crumple examples` makes.

    python bindings/python/tools/accuracy.py [hood] [drum] [framed] [can] [BODY.glb ...] [--count 24 60 120] [--out FOLDER]

The hood and the drum are the demo's; framed, a panel on a frame of ribs, and can are those of tests/bodies.py. The examples are made as the
command does with --quality good, and judged by hits that they do not contain: blows drawn at random with another seed, on the same shell, and
some of them on a shell with more points. The error is the relative L2 norm of the displacement over all vertices of the mesh; no dent is 1.
Told the blow: the contact's place and normal, and the striker's mass, velocity and radius. Told the displacement: where the contact went.
Minutes are those of one core, by the processes' own clocks. The run can be interrupted and repeated. It writes FOLDER/BODY.csv.
"""

from __future__ import annotations

import argparse
import csv
import os
import platform
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

import crumple
from crumple.examples import command, judge, profile, run, shell, symmetry
from crumple.examples.body import Body, Made, point_normals
from crumple.examples.materials import MATERIALS
from crumple.examples.plan import Plan
from crumple.examples.solver import Solver

REPOSITORY = Path(__file__).resolve().parents[3]
COLUMNS = (
    "examples",
    "hits",
    "minutes",
    "told_blow",
    "told_blow_p90",
    "told_displacement",
    "round_dent",
    "fine_told_blow",
    "fine_coarse_shell",
)
FINER = 2.5
"""Points of the finer shell by those of the usual one."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bodies", nargs="*", default=["hood", "drum", "framed"])
    parser.add_argument("--count", type=int, nargs="+", default=[24, 60, 120])
    parser.add_argument("--unseen", type=int, default=24)
    parser.add_argument("--fine", type=int, default=6, help="how many of the unseen hits are also made on a finer shell (default 6)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=REPOSITORY / "out/accuracy")
    options = parser.parse_args()
    for name in options.bodies:
        measure(name, options)


def measure(name: str, options: argparse.Namespace) -> None:
    path = body_file(name, options.out)
    body, folder = Body(path, replace=True), options.out / path.stem
    asked = command._parser().parse_args([str(path)])
    depth = tuple(share * body.size for share in command.DEPTH)
    solid = shell.make(body, command._points(body, asked), "auto")
    mirror, _ = symmetry.find(body, solid.points, solid.held, solid.room)
    material, thickness = MATERIALS["steel"], MATERIALS["steel"].thickness
    settings = run.Settings("steel", thickness, "auto", ("ball",), depth, 30.0, len(solid.points), 1)
    plan = Plan(solid, material, thickness, ("ball",), 30.0, 1, mirror, depth)
    print(f"{name}: {body.size:.2f} m, {len(solid.points)} points, edges of {1000 * solid.edge:.0f} mm", flush=True)
    done = run.run(
        plan, settings, run.Store(folder / "set", body, solid, settings), max(options.count), jobs=options.jobs, go_on=True,
        progress=lambda now: print(f"{now.made}: {now.text}", flush=True) if now.text else None,
    )  # fmt: skip
    state = run._State(plan, settings, done.results)
    # Anywhere on the body, also on the sides that the mirror images are for.
    free = Plan(solid, material, thickness, ("ball",), 30.0, 2, symmetry.Symmetry(), depth)
    blows = free.draw(0, 1 << (2 * options.unseen).bit_length(), state.energies())
    unseen = hits(solid, replace(settings, seed=2), folder / "unseen", body, blows, options.unseen)
    seen = [result for result in unseen if np.linalg.norm(result.made.field, axis=1).max() >= judge.SEEN * solid.size]
    fine = shell.make(body, int(FINER * len(solid.points)), "auto")
    again = {}
    if options.fine:
        finer = hits(fine, replace(settings, seed=3), folder / "fine", body, [result.blow for result in seen], options.fine)
        again = {finer_one.blow.point.tobytes(): finer_one.made for finer_one in finer}
    dents = profile.Profile(body.points, point_normals(body.points, body.triangles), shell.still(body, solid, "auto"), body.size)
    carry = command.carrier(body, solid, "auto")
    rows = [row(count, body, carry, done, dents, seen, again) for count in options.count]
    with (options.out / f"{path.stem}.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(COLUMNS)
        table.writerows(rows)
    print(f"{path.stem}, {len(seen)} unseen hits, {len(again)} of them on {len(fine.points)} points, on {processor()}:")
    print("\n".join(", ".join(f"{name} {value}" for name, value in zip(COLUMNS, one, strict=True)) for one in rows), flush=True)


def row(
    count: int, body: Body, carry: Callable[[Made], Made], done: run.Run, dents: profile.Profile, unseen: list[run.Result],
    again: dict[bytes, Made],
) -> tuple:  # fmt: skip
    """One line of the table: the set of the first examples."""
    taken, dented = [], []
    for result in done.results:
        if len(dented) < count:
            taken.append(result)
            dented += [carry(result.made)] if result.made is not None else []
    examples = [made for made in dented if command.is_example(body, made)]
    blow, moved, generic, fine, coarse = [], [], [], [], []
    with crumple.Context(threads=1) as context:
        instance = context.example_set(body.points, body.triangles, [judge.as_example(body.points, made) for made in examples]).instance()
        for result in unseen:
            made = result.made
            vertex = body.nearest(made.point)
            told = judge.by_blow(instance, made)
            blow.append(judge.error(made, told))
            moved.append(judge.error(made, judge.by_displacement(instance, made, made.field[vertex])))
            generic.append(judge.error(made, dents.dent(vertex, made.field[vertex])))
            truth = again.get(result.blow.point.tobytes())
            if truth is not None:
                fine.append(judge.error(truth, told))
                coarse.append(judge.error(truth, made.field))
    middle = lambda values: f"{np.median(values):.3f}" if values else ""  # noqa: E731
    minutes = sum(result.seconds for result in taken) / 60
    p90 = f"{np.quantile(blow, 0.9):.3f}"
    return len(dented), len(taken), f"{minutes:.1f}", middle(blow), p90, middle(moved), middle(generic), middle(fine), middle(coarse)


def hits(of: shell.Shell, settings: run.Settings, folder: Path, body: Body, blows: list, count: int) -> list[run.Result]:
    """The first `count` hits that leave a dent, with their fields at the body's points."""
    store = run.Store(folder, body, of, settings)
    kept = {result.index: result for result in store.read()}
    solver, carry, found = Solver(of, MATERIALS[settings.material], settings.thickness), command.carrier(body, of, settings.hold), []
    for index, blow in enumerate(blows):
        if len(found) == count:
            break
        result = kept.get(index) or run.strike(solver, index, blow)
        if index not in kept:
            store.write(result)
            print(f"unseen {index} on {len(of.points)} points: {result.words()}", flush=True)
        if result.made is not None:
            found.append(replace(result, made=carry(result.made)))
    return found


def body_file(name: str, folder: Path) -> Path:
    """The demo's mesh, one of the tests' bodies, which is written as a file, or a file."""
    demo = REPOSITORY / f"assets/demo/{name}.glb"
    if demo.is_file() or Path(name).is_file():
        return demo if demo.is_file() else Path(name)
    sys.path.insert(0, str(REPOSITORY / "bindings/python/tests"))
    import bodies

    folder.mkdir(parents=True, exist_ok=True)
    points, triangles, *colours = getattr(bodies, name)()
    return bodies.write(folder / f"{name}.glb", [(points, triangles)], name=name, colours=colours[0] if colours else None)


def processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


if __name__ == "__main__":
    main()
