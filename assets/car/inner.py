"""The inner structure, closed solids that dents may not enter, and the collider."""

import numpy as np

import panels
import shape as s
from components import front_x
from shape import smax, smin
from solids import bar, blob, box_distance, joined, loft


def within(f, p, clear):
    """f cut off `clear` metres behind the skin."""
    return smax(f, s.car(p) + clear, 0.015)


def engine(p):
    f = smin(box_distance(p, (1.28, 0, 0.50), (0.30, 0.32, 0.21), 0.05), box_distance(p, (1.26, 0.02, 0.73), (0.22, 0.16, 0.06), 0.03), 0.05)
    return within(f, p, 0.05)


def beam(rear):
    """A beam across the car behind the bumper."""
    y = np.linspace(-0.66, 0.66, 25)
    x = front_x(np.abs(y), 0.5, rear=rear) + (0.11 if rear else -0.11)
    return bar(np.stack([x, y, np.full_like(y, 0.5)], 1), (0, 0, 1), 0.08, 0.11)


def sill(p):
    return within(box_distance(p, (-0.02, 0.77, 0.265), (0.86, 0.075, 0.06), 0.03), p, 0.03)


def in_pieces(points, up, size, ends):
    """A bar of several closed pieces, each about convex: a solver that takes convex hulls fills no window then."""
    return joined(*[bar(points[a : b + 1], up, *size) for a, b in zip(ends, ends[1:])])


def pillar():
    """Between the left doors, from the sill to the roof rail."""
    z = np.linspace(0.26, 1.33, 24)
    x = panels.PILLAR - 0.06 * (z - 0.7)
    low, high = np.zeros_like(z), np.ones_like(z)
    for _ in range(40):
        y = (low + high) / 2
        inside = s.car(np.stack([x, y, z], -1)) < 0
        low, high = np.where(inside, y, low), np.where(inside, high, y)
    return in_pieces(np.stack([x, low - 0.075, z], 1), (1, 0, 0), (0.06, 0.11), (0, 14, 23))


def frame():
    """The left edge of the greenhouse: windscreen pillar, roof rail and rear pillar in one tube."""
    x = np.linspace(0.72, -1.50, 45)

    def points(z):
        t = z - 0.95
        return np.stack([x, s.BELT_WIDTH(x) - 0.38 * t - 0.22 * t * t, z], -1)

    low, high = np.full_like(x, 0.9), np.full_like(x, 1.5)
    for _ in range(40):
        z = (low + high) / 2
        p = points(z)
        inside = np.maximum(np.maximum(s.windscreen(p), s.roof(p)), s.backlight(p)) < 0
        low, high = np.where(inside, z, low), np.where(inside, high, z)
    return in_pieces(points(low) - np.array([0, 0.075, 0.065]), (0, 0, 1), (0.05, 0.05), (0, 11, 20, 29, 44))


def cell(p):
    """Floor and tunnel, firewall and the seats' height: what the people's feet and seats fill."""
    return within(box_distance(p, (-0.12, 0, 0.46), (0.95, 0.60, 0.24), 0.06), p, 0.10)


def dashboard(p):
    return within(box_distance(p, (0.72, 0, 0.78), (0.16, 0.66, 0.10), 0.05), p, 0.06)


def axle(x):
    return lambda p: within(box_distance(p, (x, 0, s.WHEEL_RADIUS), (0.06, 0.60, 0.06), 0.04), p, 0.03)


def solid(f, low, high, h):
    return blob(f, low, high, h, own=False)


def solids():
    """Name and mesh of each solid."""
    out = {
        "engine": solid(engine, (0.95, -0.35, 0.27), (1.6, 0.35, 0.82), 0.035),
        "beam_front": beam(rear=False),
        "beam_rear": beam(rear=True),
        "cell": solid(cell, (-1.1, -0.62, 0.2), (0.85, 0.62, 0.72), 0.05),
        "dashboard": solid(dashboard, (0.54, -0.68, 0.66), (0.9, 0.68, 0.9), 0.035),
        "axle_front": solid(axle(s.AXLES[0]), (1.28, -0.62, 0.26), (1.44, 0.62, 0.42), 0.028),
        "axle_rear": solid(axle(s.AXLES[1]), (-1.42, -0.62, 0.26), (-1.26, 0.62, 0.42), 0.028),
    }
    halves = {
        "sill": solid(sill, (-0.9, 0.68, 0.19), (0.86, 0.86, 0.34), 0.022),
        "pillar": pillar(),
        "frame": frame(),
    }
    for name, mesh in halves.items():
        out[name + "_left"], out[name + "_right"] = mesh, panels.mirrored(*mesh)
    return out


def ring(x, half, low, high, bevel):
    """Eight points around a cross section at x."""
    y, b = half, bevel
    p = [(y, low + b), (y, high - b), (y - b, high), (b - y, high), (-y, high - b), (-y, low + b), (b - y, low), (y - b, low)]
    return [(x, u, w) for u, w in p]


def collider():
    """Two closed, almost convex solids that hold the car: the lower body and the greenhouse. An engine takes the hull of each."""
    lower = [(2.20, 0.50, 0.30, 0.66), (2.05, 0.76, 0.21, 0.76), (1.36, 0.92, 0.18, 0.93), (0.5, 0.92, 0.17, 1.0), (-1.335, 0.92, 0.18, 1.05), (-2.1, 0.82, 0.25, 1.07), (-2.29, 0.62, 0.33, 1.0)]
    upper = [(1.05, 0.60, 0.90, 1.0), (0.62, 0.74, 0.90, 1.24), (0.1, 0.79, 0.90, 1.435), (-0.4, 0.79, 0.90, 1.445), (-0.9, 0.78, 0.90, 1.42), (-1.4, 0.73, 0.92, 1.23), (-1.80, 0.58, 0.95, 1.06)]
    return {
        "collider_lower": loft([ring(x, y, a, b, 0.10) for x, y, a, b in lower]),
        "collider_upper": loft([ring(x, y, a, b, 0.05 + 0.22 * (b - 0.95)) for x, y, a, b in upper]),
    }
