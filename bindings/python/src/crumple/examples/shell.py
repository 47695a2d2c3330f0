"""The shell that the solver deforms: the body's surface with triangles of one size, and the way back to the body's points."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from . import Failure
from .body import Body, Floats, Ints, face_normals, point_normals
from .remesh import compact, connected, edges_of, remesh, unfolded

_SMALL_PART = 0.05
"""Parts of the body with less than this share of its surface are carried along and not simulated."""
_LOWEST = 0.05
"""Share of the height that a closed body stands on."""
_MUCH = 0.5
"""A larger share of the points that is held is odd."""
_HOLE, _RIMS, _GROUND = 0.25, 12, 0.15
"""Odd holds: open edges smaller than this share of the diagonal, which are holes, more of them than this, less than this share of the ground plan."""
_MORE, _FEWER = 1.4, 0.8
"""A shell with this many times the wanted points is remeshed more coarsely, unless it then has less than the second."""
NAMED = 3
"""Places or parts that a note names."""
_NEIGHBOURS = 8
"""Triangles near a point among which the nearest is searched."""

HOLDS = ("auto", "edges", "marked", "lowest", "free")


@dataclass
class Shell:
    points: Floats
    triangles: Ints
    held: NDArray[np.bool_]
    """Points that do not move."""
    edge: float
    """Length of an edge, m."""
    notes: list[str]
    """What the user should know of how the body became a shell."""
    solids: list[Floats] = field(default_factory=list)
    """Corners of convex solids, which do not move and which the shell does not enter, m."""
    room: Floats = field(default_factory=lambda: np.zeros(0))
    """The distance of each point to the nearest solid, m; infinite without solids."""
    warnings: list[str] = field(default_factory=list)
    """What is odd about how it is held."""

    def __post_init__(self) -> None:
        self.normals = point_normals(self.points, self.triangles)
        faces = face_normals(self.points, self.triangles)
        own = 0.5 * np.linalg.norm(faces, axis=1)
        self.area = float(own.sum())
        self.areas = np.bincount(self.triangles.reshape(-1), np.repeat(own / 3, 3), len(self.points))
        self.size = float(np.linalg.norm(self.points.max(0) - self.points.min(0)))
        if len(self.room) == 0:
            self.room = np.full(len(self.points), np.inf)
        self.to_held = cKDTree(self.points[self.held]).query(self.points)[0] if self.held.any() else np.full(len(self.points), np.inf)


def make(body: Body, detail: int, hold: str) -> Shell:
    """Remeshes the body's surface to about `detail` points."""
    notes: list[str] = []
    triangles = body.triangles
    parts = connected(triangles, len(body.points))[triangles[:, 0]]
    areas = np.bincount(parts, 0.5 * np.linalg.norm(face_normals(body.points, triangles), axis=1))
    kept = np.flatnonzero(areas >= _SMALL_PART * areas.sum())
    if len(kept) == 0:
        raise Failure(
            f"{body.name} consists of {len(areas)} parts, none with {_SMALL_PART:.0%} of its surface; join them, or export the skin alone"
        )
    if len(kept) < len(areas):
        left = [one for one in areas.argsort()[::-1] if one not in set(kept)]
        names = [body.where(parts == one) for one in left[:NAMED]]
        more = f" and {len(left) - NAMED} more" if len(left) > NAMED else ""
        notes.append(
            f"{len(left)} loose parts of {len(areas)} follow the surface near them and are not simulated: {'; '.join(names)}{more}"
        )
    surface = triangles[np.isin(parts, kept)]
    edges, uses = edges_of(surface)
    if (uses > 2).any():
        at = body.points[edges[uses > 2]].mean(1)
        notes.append(f"{(uses > 2).sum()} edges belong to more than two triangles, {_spots(at, body)}")
    own = float(np.linalg.norm(body.points[edges[:, 0]] - body.points[edges[:, 1]], axis=1).mean())
    if own > 0.06 * body.size:
        notes.append(
            f"the mesh is coarse: its edges are {1000 * own:.0f} mm long on average, so dents will be; subdivide it first for better ones"
        )
    rims = _rims(body, edges[uses == 1])
    edge = float(np.sqrt(areas[kept].sum() / (0.866 * detail)))
    points, corners = remesh(body, surface, edge)
    if len(points) > _MORE * detail:
        # Beads and seams keep short edges beside them, so the others must be longer.
        longer = edge * float(np.sqrt(len(points) / detail))
        coarser = remesh(body, surface, longer)
        # The remesher may jump beyond what was asked.
        if len(coarser[0]) >= _FEWER * detail:
            edge, (points, corners) = longer, coarser
    corners, removed = unfolded(points, corners)
    if removed:
        notes.append(f"{removed} triangles of the shell lay on others and were left out")
        points, corners = compact(points, corners)
    shell_edges, shell_uses = edges_of(corners)
    border = np.unique(shell_edges[shell_uses == 1])
    held = np.zeros(len(points), bool)
    if hold == "auto":
        large = [one for one in rims if _across(body, one) >= _HOLE * body.size]
        hold = "marked" if body.marked.any() else "edges" if large else "lowest"
        if hold != "marked" and len(large) < len(rims):
            notes.append(f"{len(rims) - len(large)} small holes are not held; --hold edges holds them too")
        rims = large
    if hold == "marked":
        if not body.marked.any():
            raise Failure(
                f"nothing of {body.name} is marked as held; paint it red (COLOR_0) or give it an attribute _HELD, or use --hold edges"
            )
        marked = np.zeros(len(body.points), bool)
        marked[body.of_vertex[body.marked]] = True
        held = marked[cKDTree(body.points).query(points)[1]]
    elif hold == "edges":
        if not rims:
            raise Failure(f"{body.name} has no open edges to be held by; use --hold lowest, marked or free")
        held[border] = _near_rim(points[border], body.points[np.concatenate(rims)], 0.75 * edge)
    warnings = _odd_rims(body, rims) if hold == "edges" else []
    # Whatever has no hold of its own stands on its lowest points.
    group = connected(corners, len(points))
    loose = [one for one in range(group.max() + 1) if not held[group == one].any()] if hold != "free" else []
    for one in loose:
        of = group == one
        low, high = points[of, 1].min(), points[of, 1].max()
        held |= of & (points[:, 1] <= low + max(_LOWEST * (high - low), edge))
    if loose:
        notes.append(f"{len(loose)} of {group.max() + 1} parts are held by their lowest points (y is up)")
        warnings += _tiptoes(points[held], points) if hold == "lowest" else []
    if held.mean() > 0.9:
        raise Failure(f"{held.mean():.0%} of {body.name} is held, so nothing can dent; use another --hold")
    if held.mean() > _MUCH:
        warnings.append(f"{held.mean():.0%} of the body is held")
    if hold == "free":
        notes.append("nothing is held: the body is free, and dents are what remains when its motion is taken away")
    return Shell(points, corners, held, edge, notes, warnings=warnings)


def _spots(points: Floats, body: Body) -> str:
    """Where some points are, in the units of the file: the middles of the largest clusters."""
    near = cKDTree(points).query_pairs(0.05 * body.size, output_type="ndarray")
    label = connected(near, len(points))
    counts = np.bincount(label)
    largest = counts.argsort()[::-1][:NAMED]
    spots = ", ".join(f"{body.place(points[label == one].mean(0))} ({counts[one]})" for one in largest)
    return f"near {spots}{' and elsewhere' if len(counts) > NAMED else ''}"


def _rims(body: Body, rim: Ints) -> list[Ints]:
    """The connected pieces of the open edges, largest first."""
    if len(rim) == 0:
        return []
    used, corners = np.unique(rim, return_inverse=True)
    corners = corners.reshape(-1, 2)
    label = connected(corners, len(used))[corners[:, 0]]
    pieces = [rim[label == one] for one in range(label.max() + 1)]
    return sorted(pieces, key=lambda piece: -_across(body, piece))


def _across(body: Body, edges: Ints) -> float:
    """The diagonal of the bounds of some edges, m."""
    return float(np.linalg.norm(np.ptp(body.points[edges.reshape(-1)], axis=0)))


def _odd_rims(body: Body, rims: list[Ints]) -> list[str]:
    """A warning if the open edges are only small holes, which a body hardly hangs by, or very many."""
    across = _across(body, rims[0])
    if across < _HOLE * body.size:
        where = body.place(body.points[rims[0].reshape(-1)].mean(0))
        return [f"it hangs by {len(rims)} open edges, the largest of which, near {where}, is only {1000 * across:.0f} mm across"]
    if len(rims) > _RIMS:
        return [f"it is held by {len(rims)} separate open edges, which may be holes or loose pieces"]
    return []


def _tiptoes(held: Floats, points: Floats) -> list[str]:
    """A warning if a body stands on much less than its own width and length."""
    foot, whole = np.ptp(held, axis=0)[[0, 2]], np.ptp(points, axis=0)[[0, 2]]
    share = float(np.prod(foot / np.maximum(whole, 1e-30)))
    return [f"it stands on {share:.0%} of its ground plan; is y up?"] if share < _GROUND else []


def still(body: Body, shell: Shell, hold: str) -> NDArray[np.bool_]:
    """The points of the body that do not move: those that are marked, or those on open edges beside held points of the shell."""
    out = np.zeros(len(body.points), bool)
    if hold in ("auto", "marked") and body.marked.any():
        out[body.of_vertex[body.marked]] = True
    elif hold in ("auto", "edges"):
        edges, uses = edges_of(body.triangles)
        rim = np.unique(edges[uses == 1])
        if len(rim) and shell.held.any():
            out[rim] = cKDTree(shell.points[shell.held]).query(body.points[rim])[0] < shell.edge
    return out


def _near_rim(points: Floats, segments: Floats, reach: float) -> NDArray[np.bool_]:
    """Which points lie within `reach` of a segment."""
    a, d = segments[:, 0], segments[:, 1] - segments[:, 0]
    steps = max(1, int(np.ceil(np.linalg.norm(d, axis=1).max() / (0.5 * reach))))
    along = np.linspace(0, 1, min(steps, 200) + 1)
    samples = (a[:, None] + along[None, :, None] * d[:, None]).reshape(-1, 3)
    return cKDTree(samples).query(points)[0] <= reach


class Carrier:
    """Carries a field of the shell to the body's points. Equal points move equally, so seams stay closed."""

    def __init__(self, shell: Shell, points: Floats) -> None:
        self.shell = shell
        centres = shell.points[shell.triangles].mean(1)
        near = cKDTree(centres).query(points, k=min(_NEIGHBOURS, len(centres)))[1]
        near = near.reshape(len(points), -1)
        best = np.full(len(points), np.inf)
        self.triangle, self.weights = np.zeros(len(points), np.int64), np.zeros((len(points), 3))
        for column in near.T:
            weights = _barycentric(points, shell.points[shell.triangles[column]])
            at = np.einsum("nk,nkj->nj", weights, shell.points[shell.triangles[column]])
            distance = ((at - points) ** 2).sum(1)
            closer = distance < best
            best[closer], self.triangle[closer], self.weights[closer] = distance[closer], column[closer], weights[closer]
        self.corners = shell.triangles[self.triangle]
        foot = np.einsum("nk,nkj->nj", self.weights, shell.points[self.corners])
        self.inside = foot[:, None] - shell.points[self.corners]
        self.off = points - foot

    def field(self, field: Floats) -> Floats:
        """Of (shell points, 3) to (body points, 3). Exact for quadratic fields along the surface, and turns what lies off it."""
        gradients = self._gradients(field)[self.corners]
        bent = 0.5 * np.einsum("nkij,nkj->nki", gradients, self.inside)
        turned = np.einsum("nkij,nj->nki", gradients, self.off)
        return np.einsum("nk,nki->ni", self.weights, field[self.corners] + bent + turned)

    def _gradients(self, field: Floats) -> Floats:
        """At each shell point the mean, by area, of the gradients of its triangles; along the normal, that of a turning surface."""
        shell = self.shell
        a, b, c = (shell.points[shell.triangles[:, k]] for k in range(3))
        before = np.stack([b - a, c - a], -1)
        normal = np.cross(b - a, c - a)
        area = np.linalg.norm(normal, axis=1, keepdims=True)
        unit = normal / np.maximum(area, 1e-300)
        u, v, w = (field[shell.triangles[:, k]] for k in range(3))
        moved = before + np.stack([v - u, w - u], -1)
        after = np.cross(moved[:, :, 0], moved[:, :, 1])
        after /= np.maximum(np.linalg.norm(after, axis=1, keepdims=True), 1e-300)
        rest = np.concatenate([before, unit[:, :, None]], 2)
        now = np.concatenate([moved, after[:, :, None]], 2)
        gradient = now @ np.linalg.inv(rest) - np.eye(3)
        total, out = np.zeros(len(shell.points)), np.zeros((len(shell.points), 3, 3))
        for corner in range(3):
            np.add.at(total, shell.triangles[:, corner], area[:, 0])
            np.add.at(out, shell.triangles[:, corner], gradient * area[:, :, None])
        return out / np.maximum(total, 1e-300)[:, None, None]


def _barycentric(p: Floats, corners: Floats) -> Floats:
    """Weights of the point of each triangle that is closest to p (Ericson, Real-Time Collision Detection, 5.1.5)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    dot = lambda x, y: (x * y).sum(-1)  # noqa: E731
    ab, ac = b - a, c - a
    d1, d2 = dot(ab, p - a), dot(ac, p - a)
    d3, d4 = dot(ab, p - b), dot(ac, p - b)
    d5, d6 = dot(ab, p - c), dot(ac, p - c)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    total = np.maximum(va + vb + vc, 1e-300)
    out = np.stack([va, vb, vc], 1) / total[:, None]
    tiny = 1e-300

    def put(where: NDArray[np.bool_], first: Floats, second: Floats, third: Floats) -> None:
        out[where] = np.stack([first, second, third], 1)[where]

    zero, one = np.zeros(len(p)), np.ones(len(p))
    t = (d4 - d3) / np.maximum((d4 - d3) + (d5 - d6), tiny)
    put((va <= 0) & (d4 >= d3) & (d5 >= d6), zero, 1 - t, t)
    t = d2 / np.maximum(d2 - d6, tiny)
    put((vb <= 0) & (d2 >= 0) & (d6 <= 0), 1 - t, zero, t)
    t = d1 / np.maximum(d1 - d3, tiny)
    put((vc <= 0) & (d1 >= 0) & (d3 <= 0), 1 - t, t, zero)
    put((d6 >= 0) & (d5 <= d6), zero, zero, one)
    put((d3 >= 0) & (d4 <= d3), zero, one, zero)
    put((d1 <= 0) & (d2 <= 0), one, zero, zero)
    return out
