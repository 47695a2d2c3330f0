"""Makes hits with the solver on all cores, and keeps each as soon as it is made, so that a run can go on."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass, field, replace
from multiprocessing import connection, get_context, parent_process
from pathlib import Path
from typing import Any

import numpy as np

from . import Failure, inner
from .body import Body, Floats, Made
from .flight import Blow
from .inner import Solid
from .judge import LEAST, Judged, judge, own_errors
from .materials import MATERIALS, TOLD, Material
from .plan import CALIBRATION, EXPONENT, TYPICAL, Plan, Tried, energy
from .shell import Shell
from .solver import FOLDED, NOTHING, RESTLESS, STUCK, UNSTABLE, Outcome, Solver

FORMAT = 7
"""Another number for every change of what the solver leaves."""
BATCH, GROWTH = 8, 0.15
"""Hits that are planned at a time: so many, or this share of those that are made. Then the set's errors are asked again."""
HARD = (UNSTABLE, FOLDED, STUCK, RESTLESS)
"""Troubles of blows that are too hard."""
ENOUGH, BETTER = 96, 0.97
"""From so many hits on, twice as many must lower the error by this factor."""
HOPELESS = 12
"""After so many hits at least a quarter must have become examples."""
POLL = 0.5
"""Seconds between two looks at running hits."""


@dataclass(frozen=True)
class Settings:
    """What decides the hits. Lengths in metres."""

    material: str
    thickness: float
    hold: str
    strikers: tuple[str, ...]
    depth: tuple[float, float]
    """Of usual dents by the weakest and the strongest blows."""
    tilt: float
    """Largest angle between flight and normal, degrees."""
    detail: int
    seed: int
    inner: str = "none"
    """Names the solids of the shell."""
    mass: tuple[float, float] | None = None
    """Of the strikers, kg. None: what their energy needs at usual speeds."""
    radius: tuple[float, float] | None = None
    """Of the strikers other than walls, m. None: as usual for each."""


@dataclass
class Result:
    """What a blow left."""

    index: int
    blow: Blow
    made: Made | None
    trouble: str | None
    """Why it is no example."""
    depth: float
    """Displacement of the contact, m."""
    seconds: float
    """Of a core."""
    steps: int = 0

    def words(self) -> str:
        said = f"{self.blow.shape}, {self.blow.mass:.3g} kg, {self.blow.speed:.1f} m/s"
        return f"{said}: {self.trouble or f'{1000 * self.depth:.3g} mm'}"


def among(shell: Shell, solids: Sequence[Solid], material: Material, thickness: float) -> Shell:
    """The shell with solids inside. What touches them from the beginning is held."""
    corners, notes = inner.hulls(solids)
    shell = replace(shell, solids=corners, room=inner.room(shell.points, solids), notes=[*shell.notes, *notes])
    if Solver(shell, material, thickness).hold_what_touches():
        shell = replace(shell)
        shell.notes.append("parts that touch solids inside are held")
    if shell.held.mean() > 0.9:
        raise Failure(
            f"{shell.held.mean():.0%} of the body is held or touches solids inside, so nothing can dent; use other --inner solids"
        )
    return shell


def quiet(field: Floats, least: float) -> Floats:
    """Without what trembles far from the dent: less than 0.2 % of the largest displacement or than `least`, faded in up to twice that."""
    length = np.linalg.norm(field, axis=1, keepdims=True)
    floor = max(0.002 * float(length.max()), least, 1e-30)
    return field * np.clip((length - floor) / floor, 0, 1)


def least(size: float) -> float:
    """Displacements below this are not kept, m: they cannot be seen."""
    return 2e-5 * size


class Store:
    """A folder with one file for each hit, for going on with a run that was interrupted."""

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
        """The results by index."""
        for path in sorted(self.folder.glob("[0-9]*.npz")):
            with np.load(path) as kept:
                told = json.loads(str(kept["told"]))
                blow = Blow(*(kept[key] for key in ("aim", "aim_normal", "direction")), **told["blow"])
                made = None
                if "field" in kept:
                    vectors = {key: kept[key] for key in ("field", "point", "normal", "impulse", "velocity")}
                    made = Made(**vectors, **told["made"])
                yield Result(told["index"], blow, made, told["trouble"], told["depth"], told["seconds"], told["steps"])

    def write(self, result: Result) -> None:
        made, blow = result.made, result.blow
        told: dict[str, Any] = {key: getattr(result, key) for key in ("index", "trouble", "depth", "seconds", "steps")}
        told["blow"] = {key: getattr(blow, key) for key in ("speed", "mass", "radius", "shape", "spin")}
        arrays = {"aim": blow.point, "aim_normal": blow.normal, "direction": blow.direction}
        if made is not None:
            told["made"] = {key: getattr(made, key) for key in ("name", "duration", "mass", "radius", "shape")}
            arrays |= {key: getattr(made, key) for key in ("field", "point", "normal", "impulse", "velocity")}
        path = self.folder / f"{result.index:05}.npz"
        temporary = path.with_suffix(".part")
        with temporary.open("wb") as file:
            np.savez_compressed(file, told=json.dumps(told), **arrays)
        temporary.replace(path)


@dataclass
class Progress:
    """What a run says while it works."""

    made: int
    tried: int
    running: list[float]
    """Shares of the running hits that are done, estimated."""
    seconds_left: float | None
    error: float | None
    text: str | None
    """The last hit in words; None while hits are running."""


@dataclass
class Run:
    made: list[Made]
    results: list[Result]
    judged: Judged | None
    curve: list[tuple[int, float, float]] = field(default_factory=list)
    """Examples, and the median and 90th percentile of their errors, told the blow."""
    why: str = ""
    """Why it ended."""


def run(
    plan: Plan,
    settings: Settings,
    store: Store,
    count: int,
    until_error: float | None = None,
    jobs: int = 1,
    go_on: bool = False,
    progress: Callable[[Progress], None] = lambda now: None,
) -> Run:
    """Makes up to `count` examples."""
    state = _State(plan, settings, list(store.read())[: 2 * count + HOPELESS])
    state.judge(count)
    if state.done(count, until_error, go_on) is None:
        # What the solver refuses is said here, and not by a process that cannot begin.
        Solver(plan.shell, MATERIALS[settings.material], settings.thickness)
        with _Workers(plan.shell, settings, jobs) as workers:
            while (why := state.done(count, until_error, go_on)) is None:
                state.work(workers, store, count, jobs, progress)
                state.judge(count)
    why = state.done(count, until_error, go_on) or ""
    made = state.made(count)
    if not made:
        raise Failure(advice(state.results))
    return Run(made, state.results, state.judged, state.curve, why)


class _State:
    """The results so far, and what they say of the next."""

    def __init__(self, plan: Plan, settings: Settings, results: list[Result]) -> None:
        self.plan, self.settings, self.results = plan, settings, results
        self.errors: dict[int, float] = {}
        """The library's error of each example, by the index of its hit."""
        self.judged: Judged | None = None
        self.curve: list[tuple[int, float, float]] = []

    def made(self, count: int) -> list[Made]:
        return [result.made for result in self.results if result.made is not None][:count]

    def done(self, count: int, until_error: float | None, go_on: bool) -> str | None:
        """Why the run ends, or None."""
        n, tried, error = len(self.made(count)), len(self.results), self.judged.blow if self.judged else None
        if n >= count:
            return "all examples are made"
        if until_error is not None and error is not None and error <= until_error:
            return f"the error is {error:.2f}, as low as --until-error asks"
        if tried >= HOPELESS and n < 0.25 * tried:
            return f"only {n} of {tried} hits became examples"
        half = [e for at, e, _ in self.curve if at <= 0.55 * n]
        if not go_on and n >= ENOUGH and half and error is not None and error > BETTER * half[-1]:
            return f"more hits no longer help: the error was {half[-1]:.2f} with half as many; --go-on makes them all the same"
        return None

    def judge(self, count: int) -> None:
        """Asks the set how well it knows each example, and how well it predicts hits."""
        made = self.made(count)
        if len(made) < LEAST or (self.curve and len(made) == self.curve[-1][0]):
            return
        self.judged = judge(self.plan.shell, made)
        if self.judged is not None:
            self.curve.append((len(made), self.judged.blow, self.judged.worst))
        kept = [result.index for result in self.results if result.made is not None][:count]
        self.errors = dict(zip(kept, own_errors(self.plan.shell, made), strict=True))

    def stiffness(self) -> float:
        """Energy of a dent by depth ** EXPONENT and by the strength: the median of the first hits."""
        found = []
        for result in self.results:
            if result.index < len(CALIBRATION) and result.made is not None:
                along = float(result.blow.direction @ result.blow.normal)
                own = 0.5 * result.blow.mass * (result.blow.speed * along) ** 2
                found.append(own / (self.plan.strength * max(result.depth, 0.002 * self.plan.shell.size) ** EXPONENT))
        lower = sum(result.index < len(CALIBRATION) and result.trouble in HARD for result in self.results)
        return float(np.exp(np.median(np.log(found)))) if found else TYPICAL * 0.3**lower

    def energies(self) -> tuple[float, float]:
        """From blows that dent barely to the deepest ones that the shell stands, J."""
        stiffness = self.stiffness()
        low, high = (energy(depth, stiffness, self.plan.strength) for depth in self.settings.depth)
        hits = [result for result in self.results if result.index >= len(CALIBRATION)]
        own = np.array([0.5 * r.blow.mass * float(r.blow.speed * (r.blow.direction @ r.blow.normal)) ** 2 for r in hits])
        bad = np.array([r.trouble in HARD for r in hits])
        while high > 3 * low and len(hits):
            hard = (own > 0.5 * high) & (own <= high * 1.001)
            if hard.sum() < 4 or bad[hard].mean() <= 1 / 3:
                break
            high *= 0.7
        return low, high

    def next(self, number: int, count: int) -> list[tuple[int, Blow]]:
        """The next hits."""
        start = max((result.index for result in self.results), default=-1) + 1
        if start < len(CALIBRATION):
            taken = [int(np.linalg.norm(self.plan.shell.points - r.blow.point, axis=1).argmin()) for r in self.results]
            return [(start, self.plan.calibration(start, self.stiffness(), self.settings.depth, taken))]
        energies = self.energies()
        usual = float(np.median(list(self.errors.values()))) if self.errors else 1.0
        known = []
        for result in self.results:
            worth = self.errors.get(result.index, usual) / max(usual, 0.05) if result.trouble is None else 0.5
            known.append(Tried(self.plan.features(result.blow, energies), float(np.clip(worth, 0.5, 2.0))))
        planned = []
        for index in range(start, start + min(number, count - len(self.made(count)))):
            blow = self.plan.next(index, energies, known)
            known.append(Tried(self.plan.features(blow, energies), 1.0))
            planned.append((index, blow))
        return planned

    def work(self, workers: _Workers, store: Store, count: int, jobs: int, progress: Callable[[Progress], None]) -> None:
        """Plans and makes a batch of hits. What is running when the user interrupts it is still kept."""
        batch = self.next(max(BATCH, jobs, int(GROWTH * len(self.results))), count)
        waiting = {workers.submit(index, blow): index for index, blow in batch}
        try:
            while waiting:
                ready, _ = wait(waiting, POLL, FIRST_COMPLETED)
                for future in ready:
                    del waiting[future]
                    self.keep(future, store)
                    progress(self.progress(workers, count, jobs, self.results[-1].words()))
                if not ready:
                    progress(self.progress(workers, count, jobs, None))
        except KeyboardInterrupt:
            for future in waiting:
                future.cancel()
            for future in wait([one for one in waiting if not one.cancelled()], 30).done:
                self.keep(future, store)
            raise
        self.results.sort(key=lambda result: result.index)

    def keep(self, future: Future[Result], store: Store) -> None:
        try:
            result = future.result()
        except BrokenProcessPool as error:
            raise Failure("a simulation's process ended, perhaps for lack of memory; use fewer --jobs, or a smaller --detail") from error
        store.write(result)
        self.results.append(result)

    def progress(self, workers: _Workers, count: int, jobs: int, text: str | None) -> Progress:
        made, tried = len(self.made(count)), len(self.results)
        usual = float(np.mean([result.steps for result in self.results[-30:]])) if tried else 0.0
        running = [min(steps / usual, 0.95) if usual else 0.0 for steps in workers.running()]
        left = None
        if made:
            left = (count - made) * tried / made * workers.pace(tried) if workers.pace(tried) else None
        return Progress(made, tried, running, left, self.judged.blow if self.judged else None, text)


class _Workers:
    """Processes that each strike their own shell, and say how far they are."""

    def __init__(self, shell: Shell, settings: Settings, jobs: int) -> None:
        context = get_context("spawn")
        self._slot, self._steps = context.Value("i", 0), context.Array("i", jobs)
        self._pool = ProcessPoolExecutor(jobs, context, _start, (shell, settings, self._slot, self._steps))
        self._began, self._first = time.monotonic(), 0

    def __enter__(self) -> _Workers:
        return self

    def __exit__(self, *error: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def submit(self, index: int, blow: Blow) -> Future[Result]:
        # Processes that begin here inherit the mask: a Ctrl-C is for this one alone, also while they begin.
        blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if hasattr(signal, "pthread_sigmask") else None
        try:
            return self._pool.submit(_do, index, blow)
        finally:
            if blocked is not None:
                signal.pthread_sigmask(signal.SIG_SETMASK, blocked)

    def running(self) -> list[int]:
        """Steps that the running hits have done."""
        return [steps for steps in self._steps if steps > 0]

    def pace(self, tried: int) -> float | None:
        """Seconds a hit, since the first one of this run was finished."""
        if not self._first:
            self._began, self._first = time.monotonic(), tried
        return (time.monotonic() - self._began) / (tried - self._first) if tried > self._first else None


_solver: Solver | None = None
_settings: Settings | None = None
_steps: Any = None
_slot = 0


def _start(shell: Shell, settings: Settings, slots: Any, steps: Any) -> None:
    """Begins a process. Ctrl-C is the parent's: what is running is finished."""
    global _solver, _settings, _steps, _slot
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with slots.get_lock():
        _slot, slots.value = slots.value, slots.value + 1
    _solver, _settings, _steps = Solver(shell, MATERIALS[settings.material], settings.thickness), settings, steps


def _end_with_parent() -> None:
    """Nobody waits for the hits of a parent that was killed."""
    parent = parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)


def _do(index: int, blow: Blow) -> Result:
    assert _solver is not None and _settings is not None

    def tick(steps: int) -> None:
        _steps[_slot % len(_steps)] = steps

    try:
        return strike(_solver, index, blow, tick)
    finally:
        tick(0)


def strike(solver: Solver, index: int, blow: Blow, tick: Callable[[int], None] = lambda steps: None) -> Result:
    """Makes one hit."""
    began = time.process_time()
    outcome = solver.strike(blow, tick)
    made, trouble = None, outcome.trouble
    if trouble is None:
        made = _made(solver.shell, index, blow, outcome)
        # The library wants an example to move its own contact.
        if not made.field[np.linalg.norm(solver.shell.points - made.point, axis=1).argmin()].any():
            made, trouble = None, NOTHING
    return Result(index, blow, made, trouble, outcome.depth, time.process_time() - began, outcome.steps)


def _made(shell: Shell, index: int, blow: Blow, outcome: Outcome) -> Made:
    assert outcome.field is not None and outcome.point is not None and outcome.normal is not None
    return Made(
        f"{blow.shape} {index + 1}", quiet(outcome.field, least(shell.size)), outcome.point, outcome.normal, outcome.impulse, outcome.duration,
        blow.mass, TOLD.get(blow.shape, 1.0) * blow.radius, blow.direction * blow.speed, blow.shape,
    )  # fmt: skip


def advice(results: Sequence[Result]) -> str:
    """What went wrong most often and what to change."""
    troubles = [result.trouble for result in results if result.trouble is not None]
    hints = {
        "unstable": "the solver became unstable: try a thicker sheet (--thickness), a smaller --depth or another --detail",
        "come to rest": "the shell did not come to rest: hold more of the body (--hold), or make it thicker (--thickness)",
        "did not leave": "strikers were caught by the body: choose a smaller --depth, or --strikers ball",
        "turned over": "the shell folded: choose a smaller --depth or a finer --detail",
        "in the striker's way": "strikers could not reach the body: choose smaller ones (--strikers stone), or turn its normals outward",
        "another place first": "a wall reaches only what stands out: add another striker (--strikers ball wall)",
        "deeper elsewhere": "a corner's flank dented more than its tip: add balls (--strikers ball corner), or hold less (--hold)",
        "is held": "strikers touched parts that are held: hold less (--hold), or choose smaller strikers (--strikers ball)",
        "left nothing": "blows were too weak to leave a dent: choose a larger --depth",
        "did not touch": "strikers missed the body: turn its normals outward",
    }
    counts = {text: sum(key in trouble for trouble in troubles) for key, text in hints.items()}
    found = [f"{text} ({n} of {len(results)} hits)" for text, n in sorted(counts.items(), key=lambda one: -one[1]) if n]
    return "; ".join(found) or "no blow left a dent: choose another --depth, --material or --thickness"
