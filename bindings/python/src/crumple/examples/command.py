"""`crumple examples BODY.glb -o BODY_examples.glb`."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import crumple

from . import Failure
from .body import Body, Made
from .materials import MATERIALS, STRIKERS

if TYPE_CHECKING:
    from .inner import Solid

_NEEDED = "mujoco, pygltflib, pymeshlab, scipy, tqdm, matplotlib"


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
    add("--count", type=_between(int, 1, 1000), default=12, help="number of examples (default 12)")
    add(
        "--until-error", type=_positive, metavar="E", help="stop earlier, when the examples predict each other with this median error (0.2)"
    )
    add("--material", choices=sorted(MATERIALS), default="steel", help="default steel")
    add(
        "--thickness",
        type=_positive,
        metavar="MM",
        help="of the sheet, mm; default: the material's own (steel 0.8), within 1/5000 and 1/500 of the diagonal",
    )
    add(
        "--hold",
        choices=("auto", "edges", "marked", "lowest"),
        default="auto",
        help="what does not move: the open edges; what is painted red (COLOR_0) or has an attribute _HELD above 0.5; or the lowest points. "
        "auto: the marked, else the open edges, else the lowest",
    )
    add("--strikers", nargs="+", choices=sorted(STRIKERS), default=["ball"], help="default ball")
    add(
        "--inner",
        nargs="+",
        default=[],
        metavar="SOLID",
        help="closed solids inside that dents do not enter: FILE.glb, FILE.glb/NODE, or capsule:AX,AY,AZ,BX,BY,BZ,RADIUS, in the body's scene",
    )
    add("--depth", nargs=2, type=_positive, metavar=("MIN", "MAX"), help="depths of the dents, mm; default 0.5 %% and 3 %% of the diagonal")
    add("--tilt", type=_between(float, 0, 60), default=30.0, help="largest angle between flight and surface normal, degrees (default 30)")
    add("--unit", type=_positive, default=1.0, metavar="M", help="metres in one unit of the scene (0.01 for centimetres; default 1)")
    add("--detail", type=_between(int, 200, 50000), default=2500, metavar="N", help="points of the simulated shell, 200 to 50000 (default 2500)")
    add("--jobs", type=_between(int, 1, 1000), default=1, help="simulations at a time (default 1)")
    add("--seed", type=int, default=1, help="of the random blows (default 1)")
    add("--profile", action="store_true", help="no solver: generic round dents, which do not know their blows")
    add("--replace", action="store_true", help="replace morph targets that the mesh has")
    add("--no-report", action="store_true", help="write no report (OUT_report/index.html)")
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Runs the command and returns its exit status."""
    options = _parser().parse_args(arguments)
    try:
        _run(options)
    except Failure as failure:
        print(f"error: {failure}", file=sys.stderr)
        return 1
    except crumple.CrumpleError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except ModuleNotFoundError as error:
        print(f"error: {error.name} is missing; type: pip install 'crumple[examples]', which brings {_NEEDED}", file=sys.stderr)
        return 1
    except BrokenPipeError:
        # Whoever read the output has ended.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except KeyboardInterrupt:
        print("interrupted; repeat the command to go on with the examples that are made, or add --count for fewer", file=sys.stderr)
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
    body = Body(options.body, options.mesh, options.unit, options.replace)
    depth = tuple(1e-3 * value for value in options.depth) if options.depth else (0.005 * body.size, 0.03 * body.size)
    if not depth[0] < depth[1] <= 0.3 * body.size:
        raise Failure(
            f"--depth is {1000 * depth[0]:.3g} to {1000 * depth[1]:.3g} mm; it must rise, up to {300 * body.size:.3g} mm, 0.3 of the diagonal"
        )
    print(f"{body.name}: {len(body.vertices)} vertices, {len(body.triangles)} triangles, {_metres(body.size)} across")
    if not 0.05 <= body.size <= 50:
        print(f"warning: {_metres(body.size)} is small or large for a body; say its unit with --unit if that is wrong")
    words = [f"{body.path.name}: {len(body.vertices)} vertices, {_metres(body.size)} across."]
    solids: list[Solid] = []
    limits = None
    if options.inner:
        from . import inner

        solids = inner.read(options.inner, body, options.unit)
        limits = inner.limits(body, solids)
        words.append(
            f"{len(solids)} solids inside: no dent enters them. {(limits == 0).sum()} vertices begin in a solid and do not move."
        )
    if options.profile:
        made = _profiles(body, options.count, depth, words)
    else:
        made = _simulated(body, options, depth, out, words, solids)
    notes = {"made_by": f"crumple examples {crumple.__version__}", "solver": "none" if options.profile else "MuJoCo"}
    body.write(out, made, notes, limits)
    with crumple.Context() as context:
        loaded = context.load(out, body.mesh.name)
        info, each = loaded.info, loaded.examples
    print(
        f"{out}: {info.example_count} examples, {1000 * min(one.depth for one in each):.1f} to {1000 * max(one.depth for one in each):.1f} mm deep"
    )
    print(
        f"expected error of a dent, told its depth: {_known(info.field_error)} (1 is no dent); of the depth, told the blow: {_known(info.depth_error)}"
    )
    print(f"{time.monotonic() - began:.1f} s")
    if not options.no_report:
        from . import report

        folder = out.with_name(f"{out.stem}_report")
        report.write(folder, body, made, info, each, words)
        print(f"report: {folder / 'index.html'}")


def _profiles(body: Body, count: int, depth: tuple[float, float], words: list[str]) -> list[Made]:
    from . import profile

    words.append(
        "These are generic round dents, made without a solver. In Crumple's lab one round profile, fitted to a body's own dents and told the "
        "depth, has a median error of 0.23 on a smooth panel and 0.66 on a drum; examples of a solver have 0.10 and 0.14 there."
    )
    words.append("They do not know their blows: give hits a duration and a mass (README, From impulse to depth), or a displacement.")
    print("\n".join(words[1:-1]))
    return profile.make(body, count, depth)


def _simulated(
    body: Body, options: argparse.Namespace, depth: tuple[float, float], out: Path, words: list[str], solids: Sequence[Solid]
) -> list[Made]:
    from tqdm import tqdm

    from . import inner, run, shell

    usual = MATERIALS[options.material].thickness
    # A toy is not made of a car's sheet, nor a hall.
    thickness = 1e-3 * options.thickness if options.thickness else float(np.clip(usual, body.size / 5000, body.size / 500))
    if not options.thickness and thickness != usual:
        words.append(f"For a body of this size the sheet is {1000 * thickness:.3g} mm thick; --thickness changes it.")
    solid = shell.make(body, options.detail, options.hold)
    words.append(
        f"Shell: {len(solid.points)} points, edges of {1000 * solid.edge:.3g} mm, {solid.held.sum()} held. "
        f"{options.material.capitalize()}, {1000 * thickness:.3g} mm; struck by {', '.join(options.strikers)}."
    )
    if solids:
        solid = run.among(solid, solids, MATERIALS[options.material], thickness)
    words += [note[0].upper() + note[1:] + "." for note in solid.notes]
    print("\n".join(words[1:]))
    if thickness > 2 * solid.edge:
        raise Failure(
            f"the sheet is {1000 * thickness:.3g} mm thick, more than twice an edge of the shell; the unit may be wrong (--unit), or lower --detail"
        )
    settings = run.Settings(
        options.material, thickness, options.hold, tuple(options.strikers), depth, options.tilt, options.detail, options.seed, inner.digest(solids)
    )
    store = run.Store(out.with_name(f"{out.stem}_work"), body, solid, settings)
    with tqdm(total=options.count, unit="example", disable=None) as bar:

        def progress(done: int, error: float | None, text: str) -> None:
            bar.n = done
            bar.set_postfix_str(f"{text}{'' if error is None else f', error {error:.2f}'}")
            if bar.disable:
                print(f"{done} of {options.count}: {text}{'' if error is None else f', error {error:.2f}'}", flush=True)

        done = run.run(body, solid, settings, store, options.count, options.until_error, options.jobs, progress)
    failed = [result for result in done.results if result.made is None]
    if failed:
        words.append(f"{len(failed)} places gave no example: {run.advice(failed)}.")
        print(words[-1])
    if len(done.made) < options.count and options.until_error is None:
        print(f"warning: {len(done.made)} examples instead of {options.count}")
    carrier = shell.Carrier(solid, body.points)
    still = shell.still(body, solid, options.hold)
    carried = []
    for made in done.made:
        field = carrier.field(made.field)
        field[still] = 0
        carried.append(Made(**{**made.__dict__, "field": run.quiet(field)}))
    return carried


def _known(error: float | None) -> str:
    return "unknown" if error is None else f"{error:.2f}"


def _metres(length: float) -> str:
    return f"{length:.3g} m" if length >= 1 else f"{1000 * length:.3g} mm"


def _positive(text: str) -> float:
    value = float(text)
    if not (np.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"{text} must be above 0")
    return value


def _between(number: Callable[[str], float], low: float, high: float) -> Callable[[str], float]:
    def read(text: str) -> float:
        value = number(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text} must be from {low} to {high}")
        return value

    # argparse names it when the text is no number.
    read.__name__ = number.__name__
    return read
