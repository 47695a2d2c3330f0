"""Makes examples with the solver: chooses places and blows, checks what the solver leaves, and keeps it, so that a run can go on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from . import Failure, inner
from .body import Body, Floats, Made
from .flight import Blow
from .inner import Solid
from .materials import LEAST_SPEED, MATERIALS, MOST_SPEED, SPEEDS, STRIKERS, TOLD, Material
from .places import Places, errors
from .shell import Shell
from .solver import BESIDE, BLOCKED, ELSEWHERE, HELD, MISSED, Outcome, Solver

TRIES = 5
EXPONENT = 1.2
"""Energy grows with this power of the depth."""
TYPICAL = 45.0
"""Energy of a dent by depth ** EXPONENT and by the material's strength, before any is known."""
NEAR_ENOUGH = 1.8
"""A dent may be this many times deeper or shallower than wanted."""
STOPPED = 0.7
"""Dents deeper than this share of the distance to a solid inside may have been stopped by it, and say nothing of the shell's stiffness."""
FORMAT = 4
"""Another number for every change of what the solver leaves."""


@dataclass(frozen=True)
class Settings:
    """What decides the examples. Lengths in metres."""

    material: str
    thickness: float
    hold: str
    strikers: tuple[str, ...]
    depth: tuple[float, float]
    tilt: float
    """Largest angle between flight and normal, degrees."""
    detail: int
    seed: int
    inner: str = "none"
    """Names the solids of the shell."""


@dataclass
class Task:
    """One example to be made. Plain data, so that another process can do it."""

    index: int
    vertex: int
    wanted: float
    stiffness: float


@dataclass
class Result:
    task: Task
    made: Made | None
    tries: list[str]
    """What each try gave, in words."""
    stiffness: float | None = None
    place_is_bad: bool = False


def among(shell: Shell, solids: Sequence[Solid], material: Material, thickness: float) -> Shell:
    """The shell with solids inside. What touches them from the beginning is held."""
    corners, notes = inner.hulls(solids)
    shell = replace(shell, solids=corners, room=inner.room(shell.points, solids), notes=[*shell.notes, *notes])
    if Solver(shell, material, thickness).hold_what_touches():
        shell = replace(shell)
        shell.notes.append("parts that touch solids inside are held")
    if shell.held.mean() > 0.9:
        raise Failure(f"{shell.held.mean():.0%} of the body is held or touches solids inside, so nothing can dent; use other --inner solids")
    return shell


class Maker:
    """Does tasks, in this process or in another."""

    def __init__(self, shell: Shell, settings: Settings, near_enough: float = NEAR_ENOUGH) -> None:
        self.shell, self.settings, self.near_enough = shell, settings, near_enough
        self.material = MATERIALS[settings.material]
        self.strength = self.material.strength(settings.thickness)
        self.most_mass = max(STRIKERS[name].mass[1] for name in settings.strikers)
        self.solver = Solver(shell, self.material, settings.thickness)

    def do(self, task: Task) -> Result:
        rng = np.random.default_rng([self.settings.seed, task.index])
        blow = self._blow(task, rng)
        room = float(self.shell.room[task.vertex])
        wanted = min(task.wanted, room)
        best: tuple[float, Blow, Outcome] | None = None
        tries: list[str] = []
        stiffness = None
        for _ in range(TRIES):
            outcome = self.solver.strike(blow)
            tries.append(f"{blow.speed:.1f} m/s, {blow.mass:.3g} kg: {outcome.trouble or f'{1000 * outcome.depth:.3g} mm'}")
            if outcome.trouble in (BESIDE, BLOCKED, ELSEWHERE, HELD, MISSED):
                return Result(task, None, tries, place_is_bad=True)
            if outcome.trouble is not None:
                blow = replace(blow, speed=0.8 * blow.speed)
                continue
            depth = max(outcome.depth, 0.02 * wanted)
            along = float(blow.direction @ blow.normal)
            if depth < STOPPED * room:
                stiffness = 0.5 * blow.mass * (blow.speed * along) ** 2 / (self.strength * depth**EXPONENT)
            off = abs(np.log(depth / wanted))
            if best is None or off < best[0]:
                best = off, blow, outcome
            if off <= np.log(self.near_enough):
                break
            # Mass and speed share the change of the energy, so that both stay usual.
            factor = float(np.clip((wanted / depth) ** EXPONENT, 0.2, 8.0))
            speed = float(np.clip(blow.speed * factor**0.25, LEAST_SPEED, MOST_SPEED))
            mass = blow.mass * factor * (blow.speed / speed) ** 2
            if mass > self.most_mass:
                break
            blow = replace(blow, mass=mass, speed=speed)
        if best is None or best[0] > np.log(max(4, self.near_enough)):
            return Result(task, None, tries, stiffness, place_is_bad=True)
        return Result(task, self._made(task, best[1], best[2]), tries, stiffness)

    def _blow(self, task: Task, rng: np.random.Generator) -> Blow:
        shell, settings = self.shell, self.settings
        name = settings.strikers[int(rng.integers(len(settings.strikers)))]
        striker = STRIKERS[name]
        normal = shell.normals[task.vertex]
        angle, around = np.radians(settings.tilt) * rng.random(), 2 * np.pi * rng.random()
        if striker.shape == "pole" and abs(normal[1]) < 0.8:
            # A pole stands upright and moves in the horizontal plane.
            normal = normal * [1, 0, 1] / np.linalg.norm(normal * [1, 0, 1])
            side = np.cross([0.0, 1.0, 0.0], normal) * (1 if around < np.pi else -1)
            shape = "pole"
        else:
            a = np.cross(normal, [0.3, 0.5, 0.8])
            a /= np.linalg.norm(a)
            side = np.cos(around) * a + np.sin(around) * np.cross(normal, a)
            # A pole cannot strike a roof.
            shape = "ball" if striker.shape == "pole" else striker.shape
        direction = -np.cos(angle) * normal + np.sin(angle) * side
        energy = task.stiffness * self.strength * task.wanted**EXPONENT / np.cos(angle) ** 2
        speed = float(np.exp(rng.uniform(*np.log(SPEEDS))))
        mass = float(np.clip(2 * energy / speed**2, *striker.mass))
        radius = float(np.exp(rng.uniform(*np.log(striker.radius)))) * shell.size
        speed = float(np.clip(np.sqrt(2 * energy / mass), LEAST_SPEED, MOST_SPEED))
        spin = 2 * np.pi * rng.random() if shape == "corner" else 0.0
        return Blow(shell.points[task.vertex], normal, direction, speed, mass, radius, shape, spin)

    def _made(self, task: Task, blow: Blow, outcome: Outcome) -> Made:
        assert outcome.field is not None and outcome.point is not None and outcome.normal is not None
        return Made(
            f"{blow.shape} {task.index + 1}", quiet(outcome.field), outcome.point, outcome.normal, outcome.impulse, outcome.duration,
            blow.mass, TOLD.get(blow.shape, 1.0) * blow.radius, blow.direction * blow.speed, blow.shape,
        )  # fmt: skip


def quiet(field: Floats) -> Floats:
    """Without what trembles far from the dent: less than 0.2 % of the largest displacement, faded in up to 0.4 %."""
    length = np.linalg.norm(field, axis=1, keepdims=True)
    return field * np.clip((length / max(length.max(), 1e-30) - 0.002) / 0.002, 0, 1)


class Store:
    """A folder with one file per example, for going on with a run that was interrupted."""

    def __init__(self, folder: Path, body: Body, shell: Shell, settings: Settings) -> None:
        self.folder = folder
        arrays = (body.points, body.triangles, shell.points, shell.triangles, shell.held)
        now = {"format": FORMAT} | json.loads(json.dumps(asdict(settings)))
        now["body"] = hashlib.sha256(b"".join(one.tobytes() for one in arrays)).hexdigest()
        note = folder / "settings.json"
        if note.exists():
            before = json.loads(note.read_text())
            for key in now:
                if before.get(key) != now[key]:
                    changed = "body, or another remesher" if key in ("body", "format") else f"--{key} ({before.get(key)}, now {now[key]})"
                    raise Failure(f"{folder} has examples of an earlier run with another {changed}; delete it, or choose another -o")
        folder.mkdir(parents=True, exist_ok=True)
        note.write_text(json.dumps(now, indent=1))

    def read(self) -> Iterator[Result]:
        """The results in the order in which they were made."""
        for path in sorted(self.folder.glob("*.npz")):
            with np.load(path) as kept:
                told = json.loads(str(kept["told"]))
                made = None
                if "field" in kept:
                    vectors = {key: kept[key] for key in ("field", "point", "normal", "impulse", "velocity")}
                    made = Made(name=told["name"], **vectors, **told["blow"])
                yield Result(Task(**told["task"]), made, told["tries"], told["stiffness"], told["place_is_bad"])

    def write(self, number: int, result: Result) -> None:
        made = result.made
        told = {key: getattr(result, key) for key in ("tries", "stiffness", "place_is_bad")} | {"task": asdict(result.task)}
        arrays = {}
        if made is not None:
            told |= {"name": made.name, "blow": {key: getattr(made, key) for key in ("duration", "mass", "radius", "shape")}}
            arrays = {key: getattr(made, key) for key in ("field", "point", "normal", "impulse", "velocity")}
        path = self.folder / f"{number:04}.npz"
        temporary = path.with_suffix(".part")
        with temporary.open("wb") as file:
            np.savez_compressed(file, told=json.dumps(told), **arrays)
        temporary.replace(path)


@dataclass
class Run:
    made: list[Made]
    results: list[Result]
    error: float | None
    """Median error when the examples predict each other."""
    errors: list[float | None]


def run(
    body: Body,
    shell: Shell,
    settings: Settings,
    store: Store,
    count: int,
    until_error: float | None = None,
    jobs: int = 1,
    progress: Callable[[int, float | None, str], None] = lambda done, error, text: None,
) -> Run:
    """Makes up to `count` examples. `progress` gets how many there are, their error and the last result in words."""
    places = Places(shell)
    places.open = places.open[shell.room[places.open] >= settings.depth[0]]
    if len(places.open) == 0:
        raise Failure("solids of --inner are everywhere nearer than the shallowest dent; choose a smaller --depth")
    results: list[Result] = []
    made: list[Made] = []
    each: list[float | None] = []
    error: float | None = None
    number = 0

    def take(result: Result) -> None:
        nonlocal error, each
        results.append(result)
        if result.place_is_bad:
            places.drop(result.task.vertex, 0.05 * shell.size)
        if result.made is not None:
            made.append(result.made)
            if len(made) > 1:
                error, each = errors(shell, made)
            else:
                each = [None]
        progress(len(made), error, result.tries[-1])

    def enough() -> bool:
        good = until_error is not None and len(made) >= 6 and error is not None and error <= until_error
        return len(made) >= count or good

    for result in store.read():
        if enough():
            break
        take(result)
    number = len(list(store.folder.glob("*.npz")))
    with _workers(shell, settings, jobs) as workers:
        while not enough():
            if sum(result.made is None for result in results) > max(6, 2 * count):
                break
            batch: list[Task] = []
            # The places of a batch keep away from each other; the depths go through their range evenly.
            for _ in range(min(jobs, count - len(made))):
                taken = [one.point for one in made] + [shell.points[task.vertex] for task in batch]
                vertex = places.next(taken, each + [None] * len(batch))
                if vertex is None:
                    break
                index = number + len(batch)
                low, high = settings.depth
                wanted = low * (high / low) ** _even(index)
                batch.append(Task(index, vertex, wanted, stiffness(results, shell, shell.points[vertex])))
            if not batch:
                break
            for future in [workers.submit(_do, task) for task in batch]:
                try:
                    result = future.result()
                except BrokenProcessPool as error:
                    raise Failure(
                        "a simulation's process ended, perhaps for lack of memory; use --jobs 1, or a smaller --detail"
                    ) from error
                store.write(number, result)
                number += 1
                take(result)
    if not made:
        raise Failure(advice(results))
    return Run(made, results, error, each)


def advice(results: Sequence[Result]) -> str:
    """What went wrong and what to change."""
    said = " ".join(text for result in results for text in result.tries)
    hints = {
        "unstable": "the solver became unstable: try a thicker sheet (--thickness), a smaller --depth or another --detail",
        "come to rest": "the shell did not come to rest: hold more of the body (--hold), or make it thicker (--thickness)",
        "did not leave": "strikers were caught by the body: choose a smaller --depth, or --strikers ball",
        "turned over": "the shell folded: choose a smaller --depth or a finer --detail",
        "in the striker's way": "strikers could not reach the body: choose smaller ones (--strikers stone), or turn its normals outward",
        "another place first": "a wall reaches only what stands out: add another striker (--strikers ball wall)",
        "deeper elsewhere": "a corner's flank dented more than its tip: add balls (--strikers ball corner), or hold less (--hold)",
        "is held": "strikers touched parts that are held: hold less (--hold), or choose smaller strikers (--strikers ball)",
        "did not touch": "strikers missed the body: turn its normals outward",
    }
    found = [text for key, text in hints.items() if key in said]
    last = f"; the last tries: {'; '.join(results[-1].tries)}" if results else ""
    return (
        f"{'; '.join(found) or 'no dent of the wanted depth was found: choose another --depth, or another --material or --thickness'}{last}"
    )


def _even(index: int) -> float:
    """The van der Corput sequence: any first part of it is spread over 0 to 1."""
    value, base = 0.0, 0.5
    index += 1
    while index:
        value += base * (index % 2)
        index //= 2
        base /= 2
    return value


def stiffness(results: Sequence[Result], shell: Shell, point: Floats) -> float:
    """What the nearest places needed."""
    known = [result for result in results if result.stiffness is not None]
    if not known:
        return TYPICAL
    distances = np.array([np.linalg.norm(shell.points[result.task.vertex] - point) for result in known])
    near = distances.argsort()[:3]
    weights = 1 / (distances[near] + 0.03 * shell.size)
    logs = np.log([float(known[k].stiffness or TYPICAL) for k in near])
    return float(np.exp((weights * logs).sum() / weights.sum()))


_maker: Maker | None = None


def _start(shell: Shell, settings: Settings) -> None:
    global _maker
    _maker = Maker(shell, settings)


def _do(task: Task) -> Result:
    assert _maker is not None
    return _maker.do(task)


class _Here(Executor):
    """Does tasks in this process."""

    def submit(self, do, /, *arguments):  # type: ignore[no-untyped-def, override]
        future: Future = Future()
        future.set_result(do(*arguments))
        return future


def _workers(shell: Shell, settings: Settings, jobs: int) -> Executor:
    if jobs == 1:
        _start(shell, settings)
        return _Here()
    return ProcessPoolExecutor(jobs, get_context("spawn"), _start, (shell, settings))
