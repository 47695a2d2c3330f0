"""How well `crumple examples` does on a bare door: its examples against hits of another, finer solver's run that they do not contain.

    python bindings/python/tools/door.py [--count 24 60 120 300] [--out FOLDER]

The door is the structure's (lab/data/README.md): a skin with a crease and a free edge over a rigid beam and post. The command gets what an artist has:
the mesh, paint where it is held, the frame as solids inside, the sheet, how large and heavy strikers are, and how deep dents are to be. Its shell has
some 1000 points, and the truth's has 2460.
The hits are those of play.npz, told as blows: the contact's place and normal, and the striker's mass, velocity and radius; told also as the
displacement of the contact. The error is the relative L2 norm of the displacement over all vertices; no dent is 1. Hits that leave less than
2 mm at the contact are left out. First come the hits themselves on the command's shell: no set made on it is nearer to the truth, but by chance.
Minutes are those of one core, by the processes' own clocks. The run can be interrupted and repeated.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import numpy as np

import crumple
from crumple.examples import command, inner, judge, run, shell
from crumple.examples.body import Body, Made
from crumple.examples.flight import Blow
from crumple.examples.materials import MATERIALS, Material
from crumple.examples.solver import Solver

REPOSITORY = Path(__file__).resolve().parents[3]
TRUTH = REPOSITORY / "lab/data/structure/door"
LEAST = 2e-3
"""m"""
STRIKERS = "--mass 1 20 --radius 30 150 --tilt 50 --depth 3 40"
"""What hits the door in play (lab/data/README.md)."""
# Processes that the command starts read this file, too.
MATERIALS["door"] = Material(young=2e10, poisson=0.3, density=7800.0, thickness=0.003, yield_stretch=0.0005, yield_bend=0.001)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, nargs="+", default=[24, 60, 120, 300])
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=REPOSITORY / "out/door")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    door, made = options.out / "door.glb", options.out / "examples.glb"
    base, hits = np.load(TRUTH / "base.npz"), dents(np.load(TRUTH / "play.npz"))
    written(base, door)
    beams = ["capsule:" + ",".join(f"{number:.9g}" for number in one) for one in base["frame"]]
    arguments = [*f"{STRIKERS} --material door --thickness 3 --hold marked --go-on --jobs {options.jobs} --inner".split(), *beams]
    own = shell_errors(Body(door), beams, hits)
    print(f"the shell itself, {len(own)} hits: {np.median(own):.3f} / {np.quantile(own, 0.9):.3f}", flush=True)
    for count in sorted(options.count):
        if command.main([str(door), "-o", str(made), "--count", str(count), *arguments]):
            sys.exit(1)
        blow, moved = errors(made, base["vertices"], hits)
        print(
            f"{count} examples, {len(blow)} hits: told the blow {np.median(blow):.3f} / {np.quantile(blow, 0.9):.3f}, "
            f"told the displacement {np.median(moved):.3f} / {np.quantile(moved, 0.9):.3f}",
            flush=True,
        )


def written(base: np.lib.npyio.NpzFile, path: Path) -> None:
    """The door as a file, red where it is held."""
    sys.path.insert(0, str(REPOSITORY / "bindings/python/tests"))
    import bodies

    colours = np.where(base["pinned"][:, None], [1.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 1.0])
    bodies.write(path, [(base["vertices"], base["triangles"])], name="door", colours=colours)


def dents(play: np.lib.npyio.NpzFile) -> list[tuple[Made, Blow]]:
    """The hits that leave a dent, and how they are thrown."""
    found = []
    for i, field in enumerate(play["fields"] * float(play["step"])):
        if np.linalg.norm(field[play["contact_vertex"][i]]) < LEAST:
            continue
        point, normal, direction, velocity = (
            play[name][i].astype(float) for name in ("contact_point", "contact_normal", "direction", "velocity")
        )
        speed, mass, radius = (float(play[name][i]) for name in ("speed", "mass", "radius"))
        made = Made(f"play {i}", field, point, normal, mass=mass, radius=radius, velocity=velocity)
        found.append((made, Blow(point, normal, direction, speed, mass, radius, "ball", 0.0)))
    return found


def shell_errors(body: Body, beams: list[str], hits: list[tuple[Made, Blow]]) -> list[float]:
    """Of the same hits on the shell that the command makes."""
    material = MATERIALS["door"]
    solid = shell.make(body, command._points(body, command._parser().parse_args([str(body.path), *STRIKERS.split()])), "marked")
    solid = run.among(solid, inner.read(beams, body, 1.0), material, material.thickness)
    solver, carrier, found = Solver(solid, material, material.thickness), shell.Carrier(solid, body.points), []
    for made, blow in hits:
        field = solver.strike(blow).field
        found.append(1.0 if field is None else judge.error(made, carrier.field(field)[body.of_vertex]))
    return found


def errors(examples: Path, rest: np.ndarray, hits: list[tuple[Made, Blow]]) -> tuple[list[float], list[float]]:
    """Told the blow, and told where the contact went."""
    with crumple.Context(threads=1) as context:
        body = context.load(examples).instance()
        blow = [judge.error(made, judge.by_blow(body, made)) for made, _ in hits]
        contacts = [made.field[np.linalg.norm(rest - made.point, axis=1).argmin()] for made, _ in hits]
        moved = [judge.error(made, judge.by_displacement(body, made, to)) for (made, _), to in zip(hits, contacts, strict=True)]
    return blow, moved


if __name__ == "__main__":
    main()
