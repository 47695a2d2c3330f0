"""An elasto-plastic shell in MuJoCo, hit by a free ball (shots) or by a driven one (presses).

The shots follow the recipe of the truth itself (lab/data/README.md), so that at the truth's grid and time step they
reproduce it.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import time
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from grids import Floats, Grid, inverted, vertex_normals


@dataclass(frozen=True)
class Material:
    """SI units; yields are strains. `friction` 0 makes the contact frictionless."""

    young: float
    poisson: float
    density: float
    thickness: float
    yield_stretch: float
    yield_bend: float
    friction: float
    radius: float
    """Half the thickness of the contact surface, metres."""

    def stiffened(self, factor: float) -> Material:
        """`factor` times as stiff and as strong as before: the yield stress stays."""
        return replace(
            self,
            young=self.young * factor,
            yield_stretch=self.yield_stretch / factor,
            yield_bend=self.yield_bend / factor,
        )


SHOTS = Material(2e10, 0.3, 7800.0, 0.003, 0.0005, 0.001, 0.4, 0.002)
# Steel of the presses. Its own yield strain (0.0012) springs back from most presses here, where the rim is held but may
# turn: the two yields were chosen on training presses instead (`--calibrate` in mujoco_peer.py).
PRESSES = Material(2.1e11, 0.3, 7850.0, 0.002, 0.00015, 0.00015, 0.0, 0.001)

BALL_KG = 2.5
COMPILED_RADIUS = {"shots": 0.12, "presses": 0.2}
"""Radius that the ball is compiled with, metres. It is resized for each hit, but its bounding volume stays: contacts outside
of it are not seen. The truth of the shots was made so, with 0.12 for balls up to 0.15 m, and is reproduced only so; the
presses get one that is large enough.
"""
DAMPING_IN_CONTACT, DAMPING_AFTER = 5.0, 60.0
"""Mass damping of the sheet, 1/s."""
REST_SPEED = 2e-3
"""The sheet has settled below this, m/s."""
SETTLE_AT_LEAST, SETTLE_AT_MOST, CONTACT_AT_MOST = 0.06, 0.20, 0.30
"""Seconds."""
PRESS_SECONDS = 0.012
# Printed and logged to a file otherwise; the outcome tells what matters.
mujoco.set_mju_user_warning(lambda message: None)
WARNINGS = (mujoco.mjtWarning.mjWARN_BADQACC, mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL)


@dataclass(frozen=True)
class Impact:
    """One hit. `amount` is the ball's speed in m/s (shots) or the travel in metres (presses)."""

    vertex: int
    """The contact, a vertex of the truth's grid."""
    point: Floats
    normal: Floats
    direction: Floats
    amount: float
    radius: float


@dataclass(frozen=True)
class Outcome:
    """What is left of a hit. `field` is None when the solver gave up (NaN or infinite state)."""

    field: Floats | None
    seconds: float
    """CPU time of the one thread."""
    simulated: float
    steps: int
    unconverged: int
    """Steps whose solver stopped at its largest number of iterations."""
    settled: bool


def _numbers(values: NDArray) -> str:
    return " ".join("%.9g" % v for v in np.asarray(values).ravel())


def _model(grid: Grid, material: Material, dt: float, ball_kg: float) -> mujoco.MjModel:
    vertices, triangles = grid.vertices(), grid.triangles()
    corners = vertices[triangles]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    contact = f'condim="{3 if material.friction > 0 else 1}" friction="{material.friction}" solref="0.003 1"'
    plastic = f'yield="{material.yield_stretch:.9g} {material.yield_bend:.9g}"' if material.yield_stretch > 0 else ""
    joints = "".join(f'<joint name="j{a}" type="slide" axis="{v}"/>' for a, v in zip("xyz", ("1 0 0", "0 1 0", "0 0 1")))
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{dt}" integrator="discrete" gravity="0 0 0" solver="CG"/><size memory="1G"/>'
        f'<worldbody><body name="ball">{joints}<geom type="sphere" size="{COMPILED_RADIUS[grid.truth]}" mass="{ball_kg}" {contact}/></body>'
        f'<flexcomp type="direct" dim="2" radius="{material.radius}" name="sheet" point="{_numbers(vertices)}"'
        f' element="{_numbers(triangles)}" mass="{material.density * material.thickness * area}">'
        f'<elasticity young="{material.young}" poisson="{material.poisson}" damping="0.0001" elastic2d="both"'
        f' thickness="{material.thickness}" {plastic}/>'
        f'<contact selfcollide="none" {contact}/><pin id="{_numbers(np.flatnonzero(grid.pinned()))}"/></flexcomp>'
        "</worldbody></mujoco>"
    )


class Shell:
    """One body at one quality."""

    def __init__(self, grid: Grid, material: Material, dt: float) -> None:
        self.grid, self.material, self.dt = grid, material, dt
        self.is_press = grid.truth == "presses"
        self.model = _model(grid, material, dt, 1e4 if self.is_press else BALL_KG)
        self.data = mujoco.MjData(self.model)
        self.triangles = grid.triangles()
        self.ball_q = [self.model.joint(f"j{a}").qposadr[0] for a in "xyz"]
        self.ball_v = [self.model.joint(f"j{a}").dofadr[0] for a in "xyz"]
        self.sheet_v = np.setdiff1d(np.arange(self.model.nv), self.ball_v)
        self._reset(0.1)
        self.base = self.data.flexvert_xpos.copy()

    def bytes(self) -> int:
        """State of one instance: MuJoCo's data and the arena it used; the model can be shared."""
        return int(self.data.nbuffer + self.data.maxuse_arena)

    def inverted(self, field: Floats) -> int:
        return inverted(self.base, self.base + field, self.triangles)

    def hit(self, impact: Impact, worn: bool = False) -> Outcome:
        """Runs the hit and measures it; the sheet rests afterwards, the ball is gone. It starts from the undamaged sheet, or from
        what earlier hits left of it."""
        self._reset(impact.radius, worn)
        started = time.thread_time()
        self._steps = self._unconverged = 0
        self._alive = True
        if self.is_press:
            self._press(impact)
        else:
            self._shoot(impact)
        settled = self._alive and self._settle()
        field = None
        if self._alive:
            mujoco.mj_kinematics(self.model, self.data)
            mujoco.mj_flex(self.model, self.data)
            field = self.data.flexvert_xpos - self.base
        seconds = time.thread_time() - started
        return Outcome(field, seconds, self._steps * self.dt, self._steps, self._unconverged, settled)

    def _reset(self, radius: float, worn: bool = False) -> None:
        left = (self.data.qpos.copy(), self.data.plastic.copy()) if worn else None
        mujoco.mj_resetData(self.model, self.data)
        if left is not None:
            self.data.qpos[:], self.data.plastic[:] = left
        geom = self.model.body("ball").geomadr[0]
        self.model.geom_size[geom, 0] = self.model.geom_rbound[geom] = radius
        self.model.geom_aabb[geom] = [0, 0, 0, radius, radius, radius]
        self._park()
        mujoco.mj_forward(self.model, self.data)

    def _park(self) -> None:
        self.data.qpos[self.ball_q] = [0.0, 0.0, 9.0]
        self.data.qvel[self.ball_v] = 0.0

    def _step(self, damping: float) -> None:
        mujoco.mj_step(self.model, self.data)
        self._steps += 1
        self._unconverged += int(np.max(self.data.solver_niter)) >= self.model.opt.iterations
        self._alive = not any(self.data.warning[w].number for w in WARNINGS)
        # At 1 ms the truth's factor to the last bit, and as much each second at any other step.
        self.data.qvel[self.sheet_v] *= (1 - damping * 1e-3) ** (self.dt / 1e-3)

    def _shoot(self, impact: Impact) -> None:
        """A free ball just off the sheet, until it has left or stands still."""
        data, direction = self.data, impact.direction
        surface = data.flexvert_xpos.copy()
        normal = impact.normal if impact.normal @ direction < 0 else -direction
        centre = impact.point + normal * (impact.radius + 0.003)
        # A tilted ball must not start inside the curved sheet.
        for _ in range(400):
            if np.linalg.norm(surface - centre, axis=1).min() >= impact.radius + 0.0025:
                break
            centre = centre - direction * 0.002
        data.qpos[self.ball_q] = centre
        data.qvel[self.ball_v] = direction * impact.amount
        data.qacc_warmstart[:] = 0
        touched, free = False, 0.0
        while self._alive:
            self._step(DAMPING_IN_CONTACT)
            touched |= data.ncon > 0
            free = 0.0 if data.ncon else free + self.dt
            forward = data.qvel[self.ball_v] @ direction
            left = touched and free > 0.0085 and (forward <= 0.05 * impact.amount or free > 0.0255)
            if left or self._steps * self.dt > CONTACT_AT_MOST:
                return

    def _press(self, impact: Impact) -> None:
        """A ball that goes where it is told: in along the direction and out again, each in 12 ms, smoothly."""
        centre = impact.point + impact.normal * (impact.radius + self.material.radius)
        while self._alive and self._steps * self.dt < 2 * PRESS_SECONDS:
            phase = np.pi * self._steps * self.dt / PRESS_SECONDS
            travel, speed = 0.5 * (1 - np.cos(phase)), 0.5 * np.pi / PRESS_SECONDS * np.sin(phase)
            self.data.qpos[self.ball_q] = centre + impact.direction * impact.amount * travel
            self.data.qvel[self.ball_v] = impact.direction * impact.amount * speed
            self._step(DAMPING_IN_CONTACT)

    def _settle(self) -> bool:
        """Takes the ball away and damps the sheet to rest; says whether it came to rest in time."""
        self._park()
        first = self._steps
        while self._alive:
            self._step(DAMPING_AFTER)
            seconds = (self._steps - first) * self.dt
            speed = np.abs(self.data.qvel[self.sheet_v]).max()
            if seconds > SETTLE_AT_LEAST and speed < REST_SPEED:
                return True
            if seconds > SETTLE_AT_MOST:
                return False
        return False


def truth_grid(truth: str, body: str) -> Grid:
    """The grid on which the truth is stored."""
    size = {"shots": {"panel": (53, 41), "tube": (68, 33)}, "presses": {"panel": (73, 57), "tube": (104, 49)}}
    return Grid(truth, body, *size[truth][body])


def load_impacts(path: str, truth: str, body: str, which: str) -> tuple[list[Impact], Floats]:
    """The hits of `which` ("train" or "heldout") and their true fields, one row a simulation."""
    archive = np.load(f"{path}/{truth}/{body}/{which}.npz")
    grid = truth_grid(truth, body)
    normals = vertex_normals(grid.vertices(), grid.triangles())
    rows = np.arange(len(archive["contact_vertex"]))
    if truth == "presses":
        # Symmetry copies repeat a simulation; presses that sprang back (under 5 mm) leave nothing to compare.
        deep = np.linalg.norm(archive["displacement"], axis=1) > 5e-3
        rows = rows[deep & (archive["copy_op"] == 0).all(1)]
    amount, radius = ("speed", "radius") if truth == "shots" else ("prescribed_depth", "punch_radius")
    impacts = []
    for row in rows:
        vertex = int(archive["contact_vertex"][row])
        direction = archive["direction"][row].astype(float)
        direction /= np.linalg.norm(direction)
        point = grid.vertices()[vertex]
        impacts.append(
            Impact(vertex, point, normals[vertex], direction, float(archive[amount][row]), float(archive[radius][row]))
        )
    return impacts, archive["fields"][rows] * float(archive["step"])
