"""Wheels, lamps, mirrors, handles, grille, seats: what is put onto the skin and into it."""

import numpy as np

import panels
import shape as s
from mesher import project, unit
from panels import mirrored
from shape import smax, smin
from solids import bar, blob, box_distance, creased, joined, lathe, loft, moved, rounded_box

HANDLES = s.HANDLES


def wheel(fine):
    """A wheel around the y axis, with its outer side towards +y: (material, mesh) each."""
    segments = 72 if fine else 24
    half, radius = s.WHEEL_WIDTH / 2, s.WHEEL_RADIUS
    tyre = [(0.214, -0.088), (0.226, -0.098), (0.255, -0.107), (0.285, -half - 0.003), (0.312, -0.103), (0.327, -0.094), (radius - 0.003, -0.082)]
    for y in (-0.05, 0.0, 0.05):
        tyre += [(radius, y - 0.008), (radius - 0.008, y - 0.006), (radius - 0.008, y + 0.006), (radius, y + 0.008)]
    tyre += [(r, -y) for r, y in tyre[6::-1]]
    if not fine:
        tyre = tyre[:7] + tyre[-7:]
    rim = [(0.222, -0.088), (0.216, -0.086), (0.198, -0.07), (0.192, 0.0), (0.196, 0.045), (0.204, 0.068), (0.209, 0.078), (0.215, 0.086), (0.221, 0.090), (0.2235, 0.087), (0.2225, 0.080)]
    barrel, lip = rim[:6], rim[5:]
    parts = [("tyre", lathe(tyre, segments, 30)), ("alloy", lathe(lip[::-1], segments, 40)), ("trim_gloss", lathe(barrel[::-1], segments, 40))]
    r = np.linspace(0.04, 0.2065, 9 if fine else 4)
    face = 0.056 + 0.6 * (r - 0.045) ** 2 + 0.002 + 0.022 * ((r - 0.04) / 0.17) ** 2
    spokes = []
    for k in range(5):
        for lean in (-1, 1):
            bend = 2 * np.pi * k / 5 + lean * (0.13 + 0.17 * (r / 0.2) ** 1.2)
            width = 0.017 - 0.004 * (r - 0.04) / 0.17
            sections = []
            for ri, a, w, y in zip(r, bend, width, face):
                out, across = np.array([np.sin(a), 0, np.cos(a)]), np.array([np.cos(a), 0, -np.sin(a)])
                outline = [(-w, -0.034), (-w, -0.007), (-0.55 * w, 0), (0.55 * w, 0), (w, -0.007), (w, -0.034)]
                sections.append([ri * out + u * across + np.array([0, y + d, 0]) for u, d in outline])
            spokes.append(loft(sections, 32))
    parts.append(("alloy", joined(*spokes)))
    hub = [(0.0, 0.066), (0.024, 0.0655), (0.028, 0.062), (0.034, 0.062), (0.050, 0.058), (0.060, 0.050), (0.062, 0.02)]
    parts.append(("alloy", lathe(hub[::-1], segments // 2, 30)))
    disc = [(0.07, 0.035), (0.075, 0.012), (0.158, 0.012), (0.160, 0.008), (0.160, -0.012)]
    parts.append(("steel", lathe(disc[::-1], segments // 2, 30)))
    caliper = np.array([[(rr * np.sin(a), y, rr * np.cos(a)) for rr, y in ((0.115, 0.0), (0.115, 0.028), (0.172, 0.028), (0.172, 0.0))] for a in np.linspace(1.2, 1.95, 6)])
    parts.append(("trim_gloss", loft(caliper, 30)))
    return parts


def wheels(fine):
    """Name and (material, mesh) list of each wheel."""
    out = {}
    parts = wheel(fine)
    for end, x in zip(("front", "rear"), s.AXLES):
        at = np.array([x, s.TRACK / 2, s.WHEEL_RADIUS])
        out[f"wheel_{end}_left"] = [(m, moved(mesh, at)) for m, mesh in parts]
        out[f"wheel_{end}_right"] = [(m, mirrored(*moved(mesh, at))) for m, mesh in parts]
    return out


def front_x(y, z, x=2.6, rear=False):
    """Where the skin's front (or rear) is at (y, z)."""
    y, z = np.broadcast_arrays(np.asarray(y, float), np.asarray(z, float))
    sign = -1 if rear else 1
    inside, outside = np.full(y.shape, 1.2 * sign), np.full(y.shape, x * sign)
    for _ in range(40):
        middle = (inside + outside) / 2
        out = s.car(np.stack([middle, y, z], -1)) > 0
        outside, inside = np.where(out, middle, outside), np.where(out, inside, middle)
    return inside


def side_y(x, z):
    return s.half_width(np.asarray(x, float), np.asarray(z, float))


def grille_bars(opening, heights, inset, size, fine):
    """Horizontal bars across an opening in the front."""
    bars = []
    for z in heights:
        y = np.linspace(0, 0.8, 400)
        p = np.stack([front_x(y, z), y, np.full_like(y, z)], 1)
        end = y[opening(p) < 0].max() + 0.008
        y = np.linspace(-end, end, 33 if fine else 9)
        points = np.stack([front_x(np.abs(y), z) - inset, y, np.full_like(y, z)], 1)
        bars.append(bar(points, (0, 0, 1), size[0], size[1]))
    return joined(*bars)


def projector(y, z, radius, depth, fine):
    """A lamp behind the lens: ring, bowl and a ball of glass. It looks forwards and a little outwards."""
    n = 28 if fine else 10
    ring = [(radius * 1.0, -0.03), (radius * 1.06, -0.004), (radius * 1.03, 0.0), (radius * 0.96, 0.0), (radius * 0.90, -0.008), (radius * 0.74, -0.022)]
    ball = [(radius * 0.76, -0.024), (radius * 0.66, -0.012), (radius * 0.48, -0.003), (radius * 0.25, 0.002), (0.0, 0.003)]
    a = 0.28
    # The lathe's axis y becomes forwards, turned outwards by a.
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]]) @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    at = (float(front_x(y, z)) - depth, y, z)
    return [("chrome", moved(lathe(ring, n, 50), at, turn)), ("lamp_white", moved(lathe(ball, n, 60), at, turn))]


def mirror(fine):
    """The left mirror: housing and glass."""
    at = np.array([0.585, 0.925, 1.0])

    def housing(p):
        q = (p - at) / np.array([0.085, 0.108, 0.064])
        f = 0.075 * ((np.abs(q) ** 2.6).sum(-1) ** (1 / 2.6) - 1)
        f = smax(f, at[0] - 0.036 - p[..., 0] + 0.10 * (p[..., 1] - at[1]), 0.016)
        arm = box_distance(p, (0.60, 0.845, 0.952), (0.042, 0.075, 0.014), 0.012)
        return smin(f, arm, 0.03)

    v, n, t = blob(housing, (0.5, 0.78, 0.90), (0.70, 1.06, 1.09), 0.011 if fine else 0.03)
    rear = (n[t].mean(1)[:, 0] < -0.97) & (v[t].mean(1)[:, 2] > 0.955)
    parts = []
    for material, chosen in (("paint_second", ~rear), ("chrome", rear)):
        used, index = np.unique(t[chosen], return_inverse=True)
        parts.append((material, (v[used], n[used], index.reshape(-1, 3))))
    return parts


def handle(x, fine):
    """A door's handle with its two feet."""
    z = s.HANDLE_HEIGHT(x)
    y = float(side_y(x + 0.2, z + 0.0))

    def f(p):
        bow = p - np.array([x, y + 0.020, z]) + np.stack([0 * p[..., 0], 1.2 * (p[..., 0] - x) ** 2, 0 * p[..., 0]], -1)
        g = box_distance(bow, (0, 0, 0), (0.098, 0.010, 0.0135), 0.0095)
        for dx in (-0.08, 0.08):
            g = smin(g, box_distance(p, (x + dx, y, z), (0.013, 0.024, 0.010), 0.008), 0.01)
        return g

    return blob(f, (x - 0.11, y - 0.03, z - 0.016), (x + 0.11, y + 0.035, z + 0.016), 0.0065 if fine else 0.014, 2)


def plate(rear):
    z = 0.702 if rear else 0.437
    x = float(front_x(0.0, z, rear=rear))
    lean = float(front_x(0.0, z + 0.03, rear=rear) - front_x(0.0, z - 0.03, rear=rear)) / 0.06
    a = -np.arctan(lean)
    mesh = bar([(0, -0.255, 0), (0, 0, 0), (0, 0.255, 0)], (0, 0, 1), 0.014, 0.11)
    turn = np.array([[np.cos(a), 0, -np.sin(a)], [0, 1, 0], [np.sin(a), 0, np.cos(a)]])
    return moved(mesh, (x + (-0.004 if rear else 0.004), 0, z), turn)


def seat(x, y, wide, fine):
    def f(p):
        q = p - np.array([x, y, 0])
        g = box_distance(q, (0.05, 0, 0.46), (0.25, wide, 0.09), 0.07)
        lean = q.copy()
        lean[..., 0] += 0.32 * (q[..., 2] - 0.5)
        g = smin(g, box_distance(lean, (-0.17, 0, 0.78), (0.075, wide - 0.02, 0.30), 0.07), 0.08)
        heads = np.stack([lean[..., 0], np.abs(lean[..., 1]) - (0 if wide < 0.4 else 0.33), lean[..., 2]], -1)
        return smin(g, box_distance(heads, (-0.16, 0, 1.165), (0.05, 0.12, 0.075), 0.045), 0.03)

    return blob(f, (x - 0.55, y - wide, 0.36), (x + 0.31, y + wide, 1.26), 0.045 if fine else 0.08)


def steering_wheel(fine):
    a = 2 * np.pi * np.arange(32) / 32
    b = 2 * np.pi * np.arange(8) / 8
    ring = np.stack([0.178 * np.cos(a), 0.178 * np.sin(a), 0 * a], 1)
    out = np.stack([np.cos(a), np.sin(a), 0 * a], 1)
    v = ring[:, None] + 0.015 * (np.cos(b)[None, :, None] * out[:, None] + np.sin(b)[None, :, None] * np.array([0, 0, 1]))
    v = np.concatenate([v, v[:1]]).reshape(-1, 3)
    t = []
    for i in range(32):
        for j in range(8):
            p, q = i * 8 + j, (i + 1) % 32 * 8 + j
            p2, q2 = i * 8 + (j + 1) % 8, (i + 1) % 32 * 8 + (j + 1) % 8
            t += [[p, q, q2], [p, q2, p2]]
    torus = creased(v[:256], np.array(t), 60)
    spoke = rounded_box((0, 0, -0.01), (0.165, 0.022, 0.012), 0.01, 0.016)
    hub = rounded_box((0, 0, -0.012), (0.055, 0.055, 0.022), 0.02, 0.016)
    c, d = np.cos(-1.15), np.sin(-1.15)
    lean = np.array([[c, 0, d], [0, 1, 0], [-d, 0, c]]) @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    return moved(joined(torus, spoke, hub), (0.36, 0.36, 0.93), lean)


def interior(fine):
    """Seats, dashboard and steering wheel."""
    dash = blob(lambda p: smax(box_distance(p, (0.70, 0, 0.80), (0.26, 0.68, 0.15), 0.08), s.car(p) + 0.03, 0.02), (0.4, -0.75, 0.6), (1.0, 0.75, 1.0), 0.04 if fine else 0.08)
    return joined(seat(-0.02, 0.36, 0.25, fine), seat(-0.02, -0.36, 0.25, fine), seat(-0.80, 0, 0.62, fine), dash, steering_wheel(fine))


def chassis(p):
    """What one sees through gaps and wheel arches: a dark body 40 mm behind the skin, with wheel wells and room for the seats."""
    x, y, z = p[..., 0], np.abs(p[..., 1]), p[..., 2]
    f = smax(s.lower(p) + 0.042, z - 0.94 - 0.03 * s.step((-x - 1.0) / 0.3), 0.02)
    for axle in s.AXLES:
        r = np.hypot(x - axle, z - s.WHEEL_RADIUS)
        f = smax(f, -smax(r - 0.40, 0.56 - y, 0.03), 0.02)
    return smax(f, -box_distance(p, (-0.12, 0, 0.82), (1.06, 0.73, 0.52), 0.1), 0.03)


def wiper(y0, y1):
    """A blade on the windscreen's foot."""
    y = np.linspace(y0, y1, 14)
    z = 0.985 + 0.035 * np.linspace(0, 1, 14)
    p = project(s.greenhouse, np.stack([1.0 - 0.24 * y**2 * 0.8, y, z], 1), 8)
    n = unit(s.gradient(s.greenhouse, p))
    return bar(p + 0.008 * n, n[7], 0.013, 0.010)


def antenna(fine):
    """A fin on the roof's rear."""
    x0, z0 = -0.93, float(s.ROOF(-0.93))

    def f(p):
        q = p - np.array([x0, 0, z0 - 0.005])
        height = 0.034 * s.step((0.075 - q[..., 0]) / 0.13) * s.step((q[..., 0] + 0.075) / 0.03)
        wide = 0.020 * np.sqrt(np.clip(1 - np.clip(q[..., 2] / 0.040, 0, 1), 0, 1)) * s.step((0.085 - q[..., 0]) / 0.1) + 0.004
        return smax(smax(np.abs(q[..., 1]) - wide, q[..., 2] - height, 0.01), np.abs(q[..., 0]) - 0.08, 0.01) * 0.6

    return blob(f, (x0 - 0.09, -0.03, z0 - 0.03), (x0 + 0.09, 0.03, z0 + 0.06), 0.008 if fine else 0.02)


def exhaust(fine):
    """The left tail pipe."""
    ring = [(0.030, -0.09), (0.030, 0.0), (0.034, 0.003), (0.037, 0.0), (0.037, -0.12)]
    mesh = lathe(ring[::-1], 24 if fine else 10, 50)
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    return moved(mesh, (float(front_x(0.47, 0.31, rear=True)) - 0.035, 0.47, 0.30), turn)
