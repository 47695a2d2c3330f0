"""The inner structure, closed solids that dents may not enter, and the collider."""

import numpy as np

import panels
import shape as s
from shape import smax, smin
from solids import blob, box_distance, loft

CLEAR = 0.022  # metres between the skin and the nearest inner solid, at least


def within(f, p, clear):
    """f cut off `clear` metres behind the skin."""
    return smax(f, s.car(p) + clear, 0.015)


def engine(p):
    f = smin(box_distance(p, (1.28, 0, 0.50), (0.30, 0.32, 0.21), 0.05), box_distance(p, (1.26, 0.02, 0.73), (0.22, 0.16, 0.06), 0.03), 0.05)
    return within(f, p, 0.05)


def beam_front(p):
    x, y, z = p[..., 0], np.abs(p[..., 1]), p[..., 2]
    return within(box_distance(np.stack([x + 0.22 * y**2.2, y, z], -1), (2.03, 0, 0.50), (0.045, 0.66, 0.055), 0.02), p, 0.05)


def beam_rear(p):
    x, y, z = p[..., 0], np.abs(p[..., 1]), p[..., 2]
    return within(box_distance(np.stack([x - 0.16 * y**2.2, y, z], -1), (-2.13, 0, 0.52), (0.045, 0.66, 0.055), 0.02), p, 0.05)


def sill(p):
    return within(box_distance(p, (-0.02, 0.77, 0.265), (0.86, 0.075, 0.06), 0.03), p, 0.03)


def pillar(p):
    """Between the doors, from the sill to the roof."""
    at = -panels.door_split(p)
    f = smax(np.abs(at - 0.0) - 0.055, np.abs(s.car(p) + 0.06) - 0.032, 0.02)
    return smax(smax(f, 0.24 - p[..., 2], 0.02), smax(p[..., 2] - 1.34, 0.4 - p[..., 1], 0.02), 0.02)


def frame(p):
    """The greenhouse's frame on one side: windscreen pillar, roof rail and rear pillar."""
    f = np.abs(s.car(p) + 0.05) - 0.026
    f = smax(f, -panels.side_windows(p) - 0.01, 0.015)
    f = smax(f, -panels.screens(p) - 0.01, 0.015)
    f = smax(f, s.roof(p) * 0 - panels.roof_panel(p) - 0.03, 0.015)
    return smax(smax(f, 0.96 - p[..., 2], 0.02), 0.35 - p[..., 1], 0.01)


def cell(p):
    """Floor and tunnel, firewall and the seats' height: what the people's feet and seats fill."""
    return within(box_distance(p, (-0.12, 0, 0.46), (0.95, 0.60, 0.24), 0.06), p, 0.10)


def dashboard(p):
    return within(box_distance(p, (0.72, 0, 0.78), (0.16, 0.66, 0.10), 0.05), p, 0.06)


def axle(x):
    return lambda p: within(box_distance(p, (x, 0, s.WHEEL_RADIUS), (0.06, 0.60, 0.06), 0.04), p, 0.03)


def solids():
    """Name and mesh of each solid."""
    out = {
        "engine": blob(engine, (0.95, -0.35, 0.27), (1.6, 0.35, 0.82), 0.035),
        "beam_front": blob(beam_front, (1.8, -0.7, 0.43), (2.1, 0.7, 0.57), 0.028),
        "beam_rear": blob(beam_rear, (-2.2, -0.7, 0.45), (-1.9, 0.7, 0.59), 0.028),
        "cell": blob(cell, (-1.1, -0.62, 0.2), (0.85, 0.62, 0.72), 0.05),
        "dashboard": blob(dashboard, (0.54, -0.68, 0.66), (0.9, 0.68, 0.9), 0.035),
        "axle_front": blob(axle(s.AXLES[0]), (1.28, -0.62, 0.26), (1.44, 0.62, 0.42), 0.028),
        "axle_rear": blob(axle(s.AXLES[1]), (-1.42, -0.62, 0.26), (-1.26, 0.62, 0.42), 0.028),
    }
    for name, f, low, high in (
        ("sill", sill, (-0.9, 0.68, 0.19), (0.86, 0.86, 0.34)),
        ("pillar", pillar, (-0.3, 0.45, 0.2), (-0.05, 0.88, 1.4)),
        ("frame", frame, (-1.75, 0.33, 0.93), (0.95, 0.88, 1.45)),
    ):
        mesh = blob(f, low, high, 0.022)
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
