"""`crumple examples BODY.glb -o BODY_examples.glb`."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import crumple

from . import Failure, units
from .body import Body, Made, face_normals
from .materials import MATERIALS, STRIKERS, radii
from .units import metres

if TYPE_CHECKING:
    from .inner import Solid
    from .judge import Judged
    from .run import Progress, Run
    from .shell import Shell

_NEEDED = "mujoco pygltflib pymeshlab scipy tqdm matplotlib"
DEPTH = (0.0025, 0.06)
"""Of usual dents by the weakest and the strongest blows, as shares of the diagonal."""
HEARTBEAT = 10.0
"""Seconds between two lines while a hit runs, if the output is no terminal."""


@dataclass(frozen=True)
class Quality:
    """How many hits, and how fine the shell is."""

    count: int
    edge: float
    """Length of an edge by the radius of the smallest striker."""
    points: tuple[int, int]
    """Fewest and most of the shell."""


QUALITIES = {"draft": Quality(24, 1.5, (300, 450)), "good": Quality(300, 1.0, (450, 1600)), "best": Quality(1000, 0.7, (800, 3200))}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="crumple examples",
        description="Makes the examples of a bare mesh: dents at well-chosen places, each with its blow, by an elasto-plastic solver (MuJoCo). "
        "The output is the same file with the examples as morph targets.",
    )
    add = parser.add_argument
    add("body", type=Path, metavar="BODY.glb", help="the mesh, as .glb or .gltf")
    add("-o", "--output", type=Path, metavar="OUT.glb", help="default: BODY_examples.glb")
    add("--mesh", metavar="NAME", help="which mesh of the file; default: the one with the most triangles")
    add(
        "--quality",
        choices=tuple(QUALITIES),
        default="good",
        help="draft: 24 hits, about a minute; good (default): up to 300, 10 to 50 minutes on two cores; best: up to 1000 on a finer shell, hours",
    )
    add("--count", type=_between(int, 1, 2000), help="most examples; default: what --quality says")
    add("--until-error", type=_positive, metavar="E", help="stop earlier, when the expected error of a hit is this (0.4)")
    add("--go-on", action="store_true", help="make all examples, also when more of them no longer lower the error")
    add("--material", choices=sorted(MATERIALS), default="steel", help="default steel")
    add(
        "--thickness",
        type=_positive,
        metavar="MM",
        help="of the sheet, mm; default: the material's own (steel 0.8), within 1/5000 and 1/500 of the diagonal",
    )
    add(
        "--hold",
        choices=("auto", "edges", "marked", "lowest", "free"),
        default="auto",
        help="what does not move: the open edges; what is painted red (COLOR_0) or has an attribute _HELD above 0.5; or the lowest points; free: nothing. "
        "auto: the marked, else the open edges, else the lowest",
    )
    add("--strikers", nargs="+", choices=sorted(STRIKERS), default=["ball"], help="default ball")
    add("--mass", nargs=2, type=_positive, metavar=("MIN", "MAX"), help="of the strikers, kg; default: what dents need at 2 to 10 m/s")
    add(
        "--radius",
        nargs=2,
        type=_millimetres,
        metavar=("MIN", "MAX"),
        help="of balls, stones and poles, and half the side of the cubes of corners, mm; default: 3 to 10 %% of the diagonal, stones 1 to 2.5 %%, "
        "corners 10 to 20 %%",
    )
    add(
        "--inner",
        nargs="+",
        default=[],
        metavar="SOLID",
        help="closed solids inside that dents do not enter: FILE.glb, FILE.glb/NODE, or capsule:AX,AY,AZ,BX,BY,BZ,RADIUS, in the body's scene",
    )
    add(
        "--depth",
        nargs=2,
        type=_positive,
        metavar=("MIN", "MAX"),
        help="depths, mm, that the weakest and the strongest blows leave at usual places; default 0.25 %% and 6 %% of the diagonal. What stiff and "
        "soft places make of them is kept as it comes. With --profile: the depths of the dents",
    )
    add("--tilt", type=_between(float, 0, 60), default=30.0, help="largest angle between flight and surface normal, degrees (default 30)")
    add("--unit", type=_positive, metavar="M", help="metres in one unit of the scene (0.01 for centimetres; default 1)")
    add(
        "--detail",
        type=_between(int, 200, 50000),
        metavar="N",
        help="points of the simulated shell, 200 to 50000; default: as the strikers' size and --quality need, 300 to 3200",
    )
    add("--jobs", type=_between(int, 1, 1000), default=os.cpu_count() or 1, help="simulations at a time (default: all cores)")
    add("--seed", type=int, default=1, help="of the random blows (default 1)")
    add("--profile", action="store_true", help="no solver: generic round dents, which do not know their blows")
    add("--replace", action="store_true", help="replace morph targets that the mesh has")
    add("--no-report", action="store_true", help="write no report (OUT_report/index.html)")
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Runs the command and returns its exit status."""
    options = _parser().parse_args(arguments)
    if threading.current_thread() is threading.main_thread():
        # Whoever ends the program, such as Blender, wants what Ctrl-C does.
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        _run(options)
    except Failure as failure:
        print(f"error: {failure}", file=sys.stderr)
        return 1
    except crumple.CrumpleError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except ModuleNotFoundError as error:
        print(f"error: {error.name} is missing; type: {sys.executable} -m pip install {_NEEDED}", file=sys.stderr)
        return 1
    except BrokenPipeError:
        # Whoever read the output has ended.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except KeyboardInterrupt:
        print("interrupted; every finished hit is kept. Repeat the command to go on, or repeat it with --count for fewer", file=sys.stderr)
        return 130
    return 0


def _run(options: argparse.Namespace) -> None:
    out = options.output or options.body.with_name(f"{options.body.stem}_examples.glb")
    if out.suffix.lower() != ".glb":
        raise Failure(f"the output is {out}; its name must end in .glb")
    if out.resolve() == options.body.resolve():
        raise Failure(f"{out} is the input; name another file")
    if not out.parent.is_dir():
        raise Failure(f"there is no folder {out.parent}")
    began = time.monotonic()
    body = Body(options.body, options.mesh, options.unit or 1.0, options.replace)
    units.check(body.name, body.size, options.unit)
    usual = (0.005, 0.03) if options.profile else DEPTH
    depth = tuple(1e-3 * value for value in options.depth) if options.depth else (usual[0] * body.size, usual[1] * body.size)
    if not depth[0] < depth[1] <= 0.3 * body.size:
        raise Failure(
            f"--depth is {1000 * depth[0]:.3g} to {1000 * depth[1]:.3g} mm; it must rise, up to {300 * body.size:.3g} mm, 0.3 of the diagonal"
        )
    if options.mass and options.mass[0] > options.mass[1]:
        raise Failure(f"--mass is {options.mass[0]:g} to {options.mass[1]:g} kg; it must rise")
    if options.radius and not options.radius[0] <= options.radius[1] <= 0.5 * body.size:
        ends = " to ".join(f"{1000 * value:.3g}" for value in options.radius)
        raise Failure(f"--radius is {ends} mm; it must rise, up to {500 * body.size:.3g} mm, half the diagonal")
    words = [f"{body.name}: {len(body.vertices)} vertices, {len(body.triangles)} triangles, {metres(body.size)} across."]
    print(words[0])
    solids: list[Solid] = []
    limits = None
    if options.inner:
        from . import inner

        solids = inner.read(options.inner, body, options.unit or 1.0)
        limits = inner.limits(body, solids)
        words.append(f"{len(solids)} solids inside: no dent enters them. {(limits == 0).sum()} vertices begin in a solid and do not move.")
        print(words[-1])
    made: list[Made]
    done: Run | None = None
    if options.profile:
        made = _profiles(body, options.count or 12, depth, words)
        held = np.zeros((0, 3))
    else:
        made, done, held = _simulated(body, options, depth, out, words, solids)
    judged = done.judged if done else None
    words.append(_verdict(judged, options.profile, len(made)))
    print(words[-1])
    failure = _failure(judged, done, words)
    if failure is None:
        notes = {"made_by": f"crumple examples {crumple.__version__}", "solver": "none" if options.profile else "MuJoCo"}
        if judged is not None:
            notes |= {"expected_error": round(judged.blow, 3), "expected_error_p90": round(judged.worst, 3)}
        body.write(out, made, notes, limits)
        deepest = [float(np.linalg.norm(one.field, axis=1).max()) for one in made]
        print(
            f"{out}: {len(made)} examples, {1000 * min(deepest):.1f} to {1000 * max(deepest):.1f} mm deep, {out.stat().st_size / 1e6:.1f} MB. "
            f"No hit dents deeper than {1000 * max(deepest):.0f} mm."
        )
    if not options.no_report:
        from . import report

        folder = out.with_name(f"{out.stem}_report")
        report.write(folder, body, made, held, done, words)
        print(f"report: {folder / 'index.html'}")
    print(f"{time.monotonic() - began:.1f} s")
    if failure is not None:
        raise failure


def _verdict(judged: Judged | None, profile: bool, count: int) -> str:
    if profile:
        return "Expected error: unknown, since without a solver there is nothing to compare round dents with. The solver's report compares both."
    if judged is None:
        return f"Expected error: unknown with {count} examples; 8 or more dents that can be seen are needed."
    text = judged.words()
    compared = f"Told the displacement of its contact: {judged.displacement:.2f}; a round dent of --profile: {judged.round:.2f}."
    return f"{text[0].upper()}{text[1:]}. {compared}"


def _failure(judged: Judged | None, done: Run | None, words: list[str]) -> Failure | None:
    """Why a set is of no use."""
    from .judge import NOTHING

    if judged is None or done is None or judged.blow < NOTHING:
        return None
    causes = [word for word in words if word.startswith("Warning: ")]
    if judged.displacement < 0.8 * judged.blow:
        causes.append("the shapes are right and the depths are not: more examples (--count), or fewer kinds of --strikers, help most")
    if len(done.made) < 60:
        causes.append(f"{len(done.made)} examples are few: --count 300")
    causes.append("perhaps the body sways or buckles as a whole: hold more of it (--hold marked), or make it thicker (--thickness)")
    return Failure(f"the set predicts nothing (error {judged.blow:.2f}, no dent is 1), so no file is written; {'; '.join(causes)}")


def _profiles(body: Body, count: int, depth: tuple[float, float], words: list[str]) -> list[Made]:
    from . import profile

    words.append("These are generic round dents, made without a solver.")
    words.append("They do not know their blows: give hits a duration and a mass (docs/examples.md, From impulse to depth), or a displacement.")
    print("\n".join(words[1:]))
    return profile.make(body, count, depth)


def _points(body: Body, options: argparse.Namespace) -> int:
    """Points of the shell: its edges follow the smallest striker."""
    quality = QUALITIES[options.quality]
    area = 0.5 * float(np.linalg.norm(face_normals(body.points, body.triangles), axis=1).sum())
    edge = quality.edge * min(radii(name, body.size, options.radius)[0] for name in options.strikers)
    return options.detail or int(np.clip(area / (0.866 * edge**2), *quality.points))


def _simulated(
    body: Body, options: argparse.Namespace, depth: tuple[float, float], out: Path, words: list[str], solids: Sequence[Solid]
) -> tuple[list[Made], Run, np.ndarray]:
    """The examples on the body's points, the run, and the held points of the shell."""
    from . import inner, run, shell, symmetry
    from .plan import Plan

    first = len(words)
    usual = MATERIALS[options.material].thickness
    # A toy is not made of a car's sheet, nor a hall.
    thickness = 1e-3 * options.thickness if options.thickness else float(np.clip(usual, body.size / 5000, body.size / 500))
    if not options.thickness and thickness != usual:
        words.append(f"For a body of this size the sheet is {1000 * thickness:.3g} mm thick; --thickness changes it.")
    detail, count = _points(body, options), options.count or QUALITIES[options.quality].count
    solid = shell.make(body, detail, options.hold)
    words.append(
        f"Shell: {len(solid.points)} points, edges of {1000 * solid.edge:.3g} mm, {solid.held.sum()} held. "
        f"{options.material.capitalize()}, {1000 * thickness:.3g} mm; struck by {', '.join(options.strikers)}."
    )
    if thickness > 2 * solid.edge:
        raise Failure(
            f"the sheet is {1000 * thickness:.3g} mm thick, more than twice an edge of the shell; the unit may be wrong (--unit), or lower --detail"
        )
    if solids:
        solid = run.among(solid, solids, MATERIALS[options.material], thickness)
    mirror, notes = symmetry.find(body, solid.points, solid.held, solid.room)
    words += [note[0].upper() + note[1:] + "." for note in [*solid.notes, *notes]]
    words += [f"Warning: {text}. The report shows what is held; --hold marked or --hold free changes it." for text in solid.warnings]
    print("\n".join(words[first:]))
    settings = run.Settings(
        options.material, thickness, options.hold, tuple(options.strikers), depth, options.tilt, detail, options.seed, inner.digest(solids),
        options.mass and tuple(options.mass), options.radius and tuple(options.radius),
    )
    plan = Plan(
        solid, MATERIALS[options.material], thickness, options.strikers, options.tilt, options.seed, mirror, depth, settings.mass, settings.radius
    )
    store = run.Store(out.with_name(f"{out.stem}_work"), body, solid, settings)
    with _Bar(count) as bar:
        done = run.run(plan, settings, store, count, options.until_error, options.jobs, options.go_on, bar.show)
    cost = sum(result.seconds for result in done.results)
    words.append(f"{len(done.made)} examples of {len(done.results)} hits, {cost / 60:.1f} minutes of a core; {done.why}.")
    failed = [result for result in done.results if result.made is None]
    if failed:
        words.append(f"{len(failed)} hits gave no example: {run.advice(failed)}.")
    print("\n".join(words[-2:] if failed else words[-1:]))
    carried = [made for made in map(carrier(body, solid, options.hold), done.made) if is_example(body, made)]
    if not carried:
        raise Failure("no blow left a dent on the mesh's own vertices; subdivide it, or choose a larger --depth")
    if len(carried) < len(done.made):
        words.append(f"{len(done.made) - len(carried)} dents are too slight for the mesh's own vertices and were left out.")
        print(words[-1])
    return carried, done, solid.points[solid.held]


def carrier(body: Body, solid: Shell, hold: str) -> Callable[[Made], Made]:
    """What carries dents of the shell to the body's points."""
    from . import run, shell

    onto, still = shell.Carrier(solid, body.points), shell.still(body, solid, hold)

    def carry(made: Made) -> Made:
        field = onto.field(made.field)
        field[still] = 0
        return replace(made, field=run.quiet(field, run.least(body.size)))

    return carry


def is_example(body: Body, made: Made) -> bool:
    """Whether a dent moves the point that was hit, also once the file has rounded it: the library wants that of an example."""
    return bool(np.abs(made.field[body.nearest(made.point)]).max() >= body.step)


class _Bar:
    """Shows the progress: a bar on a terminal, lines elsewhere."""

    def __init__(self, count: int) -> None:
        from tqdm import tqdm

        self.count, self.said = count, time.monotonic()
        self.bar = tqdm(total=count, unit="example", disable=None, bar_format="{n_fmt} of {total_fmt} |{bar}| {elapsed} {postfix}")

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *error: object) -> None:
        self.bar.close()

    def show(self, now: Progress) -> None:
        parts = [now.text] if now.text else []
        parts += [f"running: {' '.join(f'{share:.0%}' for share in now.running)}"] if now.running and not now.text else []
        parts += [f"error {now.error:.2f}"] if now.error is not None else []
        parts += [f"{_duration(now.seconds_left)} left"] if now.seconds_left is not None else []
        if not self.bar.disable:
            self.bar.n = now.made
            self.bar.set_postfix_str(", ".join(parts))
        elif now.text or time.monotonic() - self.said > HEARTBEAT:
            self.said = time.monotonic()
            print(f"{now.made} of {self.count}: {', '.join(parts)}", flush=True)


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def _positive(text: str) -> float:
    value = float(text)
    if not (np.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"{text} must be above 0")
    return value


def _millimetres(text: str) -> float:
    """Metres."""
    return 1e-3 * _positive(text)


def _between(number: Callable[[str], float], low: float, high: float) -> Callable[[str], float]:
    def read(text: str) -> float:
        value = number(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text} must be from {low} to {high}")
        return value

    # argparse names it when the text is no number.
    read.__name__ = number.__name__
    return read
