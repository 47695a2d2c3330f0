"""An elasto-plastic shell in MuJoCo, struck by a rigid ball, pole, wall or corner, which flies freely and does not turn.

The set-up is that of the data in lab/data/structure: J2 plasticity without hardening, integrator `discrete`, and kinetic damping after the
contact. Lengths and times scale with the edges of the shell, so that small and large bodies behave alike, and steps with the material's wave
speed.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

from collections.abc import Callable  # noqa: E402
from dataclasses import dataclass, replace  # noqa: E402
from typing import Any  # noqa: E402

import mujoco  # noqa: E402
import numpy as np  # noqa: E402
from numpy.typing import NDArray  # noqa: E402

from . import Failure  # noqa: E402
from .body import Floats, face_normals  # noqa: E402
from .flight import Blow, Flight  # noqa: E402
from .materials import Material  # noqa: E402
from .shell import Shell  # noqa: E402

EDGE = 0.020
"""m. The durations below are those of a shell with edges so long."""
COURANT = 20.0
"""A step is as long as a wave in the sheet takes for this many edges. Longer steps leave shallower dents."""
STIFF, DAMPED = 6.0, 0.2
"""Steps: the time constants of the contact and of the material's damping. Twice as long ones, with twice the contact's damping, left
a door's dents a quarter smaller."""
SKIN = 0.1
"""Half the thickness of the contact surface, as a share of an edge."""
FRICTION = 0.4
DAMPING = 5.0
"""Mass damping of the shell, 1/s at edges of 20 mm."""
FREE, SLOW, CONTACT, SETTLE = 0.008, 0.060, 0.30, 0.12
"""Seconds at edges of 20 mm: the striker is gone after FREE without touch if it moves away, after SLOW if not; the contact and the
settling last at most this long."""
REST, UNSETTLED = 3e-3, 0.04
"""m/s with edges of 20 mm: the shell rests below the first, and has not settled above the second."""
CONTACT_SHARE = 0.5
"""A flat striker's contact is displaced by at least this share of the largest displacement. Other blows teach nothing of their place."""
SEEN = 0.002
"""Shallower dents, as a share of the diagonal, are not asked where they are deepest."""
ASIDE = 0.1
"""A wall may touch this share of the diagonal beside what it is aimed at."""
_BAD = (mujoco.mjtWarning.mjWARN_BADQACC, mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL)
mujoco.set_mju_user_warning(lambda message: None)


@dataclass(frozen=True)
class Outcome:
    trouble: str | None
    """Why the blow is no example; None if it is one."""
    field: Floats | None = None
    point: Floats | None = None
    normal: Floats | None = None
    impulse: Floats | None = None
    """On the body, N s."""
    duration: float = 0.0
    depth: float = 0.0
    """Displacement of the contact, m."""
    speed_at_rest: float = 0.0
    steps: int = 0


BLOCKED = "the body is in the striker's way"
BESIDE = "the wall touched another place first"
HELD = "the striker touched a part that is held"
MISSED = "the striker did not touch the body"
ELSEWHERE = "the body was dented deeper elsewhere"
UNSTABLE = "the solver became unstable"
STUCK = "the striker did not leave"
RESTLESS = "the shell did not come to rest"
FOLDED = "triangles turned over"
NOTHING = "the blow left nothing"
STILL = 0.5
"""Of a free body this share of the points, those that are moved least, stay in place on the whole."""
REPORT = 5
"""Steps between two reports of the progress."""


class Solver:
    """One shell of one material. Every blow starts from the undamaged shell."""

    def __init__(self, shell: Shell, material: Material, thickness: float) -> None:
        self.shell = shell
        self.time = min(max(shell.edge / EDGE, 0.02), 4.0)
        self.dt = COURANT * EDGE * self.time / material.wave_speed
        self.pace = shell.edge / EDGE / self.time
        self.skin = SKIN * shell.edge
        self.flight = Flight(shell, self.skin)
        touch = f'condim="3" friction="{FRICTION}"'
        contact = f'{touch} solref="{STIFF * self.dt:.9g} 1"'
        # The edges of walls and corners would be thrown back faster than they came.
        box = f'{touch} priority="1" solref="{2 * STIFF * self.dt:.9g} 2"'
        # The shell touches strikers (1) and solids (2), which do not touch each other.
        masks = ' contype="3" conaffinity="3"' if shell.solids else ""
        hard = f'contype="2" conaffinity="2" {touch} solref="{2 * self.dt:.9g} 1"'
        meshes = "".join(f'<mesh name="m{i}" vertex="{_text(one)}"/>' for i, one in enumerate(shell.solids))
        solids = "".join(f'<geom type="mesh" mesh="m{i}" {hard}/>' for i in range(len(shell.solids)))
        slides = "".join(f'<joint name="j{a}" type="slide" axis="{v}"/>' for a, v in zip("xyz", ("1 0 0", "0 1 0", "0 0 1"), strict=True))
        pins = f'<pin id="{_text(np.flatnonzero(shell.held))}"/>' if shell.held.any() else ""
        self.away = shell.points.mean(0) + [0.0, 0.0, 20 * shell.size]
        xml = (
            f'<mujoco><option timestep="{self.dt:.9g}" integrator="discrete" gravity="0 0 0" solver="CG"/><size memory="1G"/><asset>{meshes}</asset><worldbody>{solids}'
            f'<body name="striker">{slides}<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
            f'<geom name="ball" type="sphere" size="{0.1 * shell.size:.9g}" {contact}/>'
            f'<geom name="pole" type="capsule" zaxis="0 1 0" size="{0.1 * shell.size:.9g} {self.flight.half:.9g}" {contact}/>'
            f'<geom name="box" type="box" quat="0.8 0.6 0 0" size="{0.1 * shell.size:.9g} {0.1 * shell.size:.9g} {0.1 * shell.size:.9g}" {box}/></body>'
            f'<flexcomp type="direct" dim="2" radius="{self.skin:.9g}" name="s" mass="{material.density * thickness * shell.area:.9g}"'
            f' point="{_text(shell.points)}" element="{_text(shell.triangles)}">'
            f'<elasticity young="{material.young:.9g}" poisson="{material.poisson}" damping="{DAMPED * self.dt:.9g}"'
            f' thickness="{thickness:.9g}" elastic2d="both" yield="{material.yield_stretch} {material.yield_bend}"/>'
            f'<contact selfcollide="none"{masks} {contact}/>{pins}</flexcomp></worldbody></mujoco>'
        )
        try:
            self.model = mujoco.MjModel.from_xml_string(xml)
        except ValueError as error:
            said = " ".join(str(error).split())
            raise Failure(
                f"MuJoCo refuses the shell: {said}; a body may be too small (--unit), or have vertices to be merged by distance"
            ) from error
        self.data = mujoco.MjData(self.model)
        model = self.model
        self.geoms = {name: model.geom(name).id for name in ("ball", "pole", "box")}
        self.body = model.body("striker").id
        self.q = [model.joint(f"j{a}").qposadr[0] for a in "xyz"]
        self.v = [model.joint(f"j{a}").dofadr[0] for a in "xyz"]
        self.shell_v = np.setdiff1d(np.arange(model.nv), self.v)
        self._inverse_weight, self._dof_inverse = model.body_invweight0[self.body].copy(), model.dof_invweight0[self.v].copy()
        self._reset()
        self._base = self.data.flexvert_xpos.copy()

    def strike(self, blow: Blow, tick: Callable[[int], None] = lambda steps: None) -> Outcome:
        """Runs a blow to rest. `tick` gets the steps that are done."""
        self.steps = 0
        return replace(self._strike(blow, tick), steps=self.steps)

    def _strike(self, blow: Blow, tick: Callable[[int], None]) -> Outcome:
        if self.flight.start(blow) is None:
            return Outcome(BLOCKED)
        touch = self.flight.touch(blow)
        if touch is None:
            return Outcome(MISSED)
        centre, point, normal = touch
        if blow.shape == "wall" and np.linalg.norm(point - blow.point) > ASIDE * self.shell.size:
            return Outcome(BESIDE)
        model, data, time = self.model, self.data, self.time
        self._striker(blow)
        self._reset()
        velocity = blow.direction * blow.speed
        data.qpos[self.q], data.qvel[self.v] = centre - 0.05 * self.shell.edge * blow.direction, velocity
        vertex = int(np.linalg.norm(self.shell.points - point, axis=1).argmin())
        if self.shell.held[vertex]:
            return Outcome(HELD)
        geom, first, last, gone, energy, speed = self._geom(blow), None, None, None, 0.0, 0.0
        free, after, left = 0, velocity, True
        while True:
            mujoco.mj_step(model, data)
            self.steps += 1
            if self.steps % REPORT == 0:
                tick(self.steps)
            if any(data.warning[one].number for one in _BAD):
                return Outcome(UNSTABLE)
            if gone is None:
                touching = bool((data.contact.geom == geom).any())
                if touching:
                    first, last = data.time if first is None else first, data.time
                free = 0 if touching else free + 1
                after = data.qvel[self.v].copy()
                rest = free * self.dt
                leaves = after @ normal >= 0
                left = first is not None and ((rest > FREE * time and leaves) or rest > SLOW * time)
                if left or data.time > CONTACT * time:
                    gone = data.time
                    self._park()
            else:
                now = float((data.qvel[self.shell_v] ** 2).sum())
                if now < energy:
                    speed = float(np.abs(data.qvel[self.shell_v]).max())
                    data.qvel[self.shell_v] = 0
                    now = 0.0
                    if speed < REST * self.pace or data.time - gone > SETTLE * time:
                        break
                energy = now
                if data.time - gone > 2 * SETTLE * time:
                    break
            data.qvel[self.shell_v] *= 1 - DAMPING / time * self.dt
        if first is None or last is None:
            return Outcome(MISSED)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_flex(model, data)
        field = data.flexvert_xpos - self._base
        if not np.isfinite(field).all():
            return Outcome(UNSTABLE)
        if not self.shell.held.any():
            field = without_motion(self._base, field)
        length = np.linalg.norm(field, axis=1)
        if length.max() > self.shell.size:
            return Outcome(UNSTABLE)
        impulse = -blow.mass * (after - velocity)
        found = dict(
            field=field, point=point, normal=normal, impulse=impulse, duration=last - first + self.dt, depth=float(length[vertex]), speed_at_rest=speed
        )  # fmt: skip
        trouble = STUCK if not left else RESTLESS if speed > UNSETTLED * self.pace else FOLDED if self._folded(field) else None
        # Near a part that is held, the tip of a cube stops there and its flank goes on.
        if trouble is None and blow.is_box and length[vertex] < CONTACT_SHARE * length.max() and length.max() > SEEN * self.shell.size:
            trouble = ELSEWHERE
        return Outcome(trouble, **found)

    def hold_what_touches(self) -> int:
        """Holds the points of triangles that touch solids at rest, and returns how many. Use another Solver afterwards."""
        shell, before = self.shell, self.shell.held.sum()
        touching = self.data.contact.elem.max(1)[: self.data.ncon]
        shell.held[np.unique(shell.triangles[touching[touching >= 0]])] = True
        return int(shell.held.sum() - before)

    def _folded(self, field: Floats) -> bool:
        """Whether more triangles than one in 500 turned by more than 90 degrees."""
        before, after = face_normals(self.shell.points, self.shell.triangles), face_normals(self.shell.points + field, self.shell.triangles)
        return bool(((before * after).sum(1) < 0).mean() > 0.002)

    def _geom(self, blow: Blow) -> int:
        return self.geoms["box" if blow.is_box else blow.shape]

    def _striker(self, blow: Blow) -> None:
        model, body, mass, radius = self.model, self.body, blow.mass, blow.radius
        this = self._geom(blow)
        for geom in self.geoms.values():
            model.geom_contype[geom] = model.geom_conaffinity[geom] = int(geom == this)
        size = np.array([radius, radius, radius])
        if blow.is_box:
            size = blow.half_sides
            mujoco.mju_mat2Quat(model.geom_quat[this], blow.axes.ravel())
            model.geom_size[this], reach = size, float(np.linalg.norm(size))
        else:
            half = self.flight.half if blow.shape == "pole" else 0.0
            model.geom_size[this, 0], reach, size[2] = radius, radius + half, radius + half
        # The compiled bounds stay otherwise, and contacts outside of them are not seen.
        model.geom_rbound[this], model.geom_aabb[this] = reach, [0, 0, 0, *size]
        model.body_subtreemass[0] += mass - model.body_mass[body]
        model.body_mass[body] = model.body_subtreemass[body] = mass
        model.dof_M0[self.v] = mass
        model.body_invweight0[body] = self._inverse_weight / [mass, 1]
        model.dof_invweight0[self.v] = self._dof_inverse / mass

    def _park(self) -> None:
        self.data.qpos[self.q], self.data.qvel[self.v] = self.away, 0

    def _reset(self) -> None:
        mujoco.mj_resetData(self.model, self.data)
        self._park()
        mujoco.mj_forward(self.model, self.data)
        self.data.qacc_warmstart[:] = 0


def without_motion(points: Floats, field: Floats) -> Floats:
    """The displacements of a free body, seen by one who moves and turns with the half of its points that is bent least."""
    chosen = np.ones(len(points), bool)
    moved = field
    for _ in range(8):
        a, b = points[chosen], (points + field)[chosen]
        middle, now = a.mean(0), b.mean(0)
        u, _, v = np.linalg.svd((b - now).T @ (a - middle))
        turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))]) @ v
        moved = (points + field - now) @ turn + middle - points
        length = np.linalg.norm(moved, axis=1)
        chosen = length <= np.quantile(length, STILL)
    return moved


def _text(values: NDArray[Any]) -> str:
    return " ".join(f"{value:.9g}" for value in np.asarray(values).ravel())
