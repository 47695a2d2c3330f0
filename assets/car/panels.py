"""Cuts the car's skin into panels, windows and lamps along curves, and gives the panels folded borders."""

import numpy as np

import shape as s
from mesher import Skin, fold, net, project, relax, unit
from shape import smax, smin

GAP = 0.0052  # between panels, metres
PILLAR = -0.17  # where the doors meet
DOOR_FRONT = 0.80


def xyz(p):
    return p[..., 0], np.abs(p[..., 1]), p[..., 2]


def on_lower(p):
    """Negative where the skin is the lower body's, not the greenhouse's."""
    return s.lower(p) - s.greenhouse(p)


def side_windows(p):
    f = smax(s.windscreen(p) + 0.07, s.roof(p) + 0.058, 0.05)
    f = smax(f, s.backlight(p) + 0.20, 0.06)
    return smax(f, 0.018 - s.lower(p), 0.035)


def screens(p):
    f = smax(s.cabin_side(p) + 0.045, s.roof(p) + 0.04, 0.07)
    return smax(f, 0.022 - s.lower(p), 0.05)


def hood(p):
    x, y, z = xyz(p)
    f = smax(s.side(p) + 0.06, s.nose(p) + 0.045, 0.12)
    return smax(smax(f, 0.026 - s.greenhouse(p), 0.03), 0.4 - x, 0.02)


def cowl(p):
    """Between hood and windscreen."""
    f = smax(s.lower(p) - 0.024, s.side(p) + 0.055, 0.01)
    return smax(smax(f, s.greenhouse(p) - 0.03, 0.01), 0.4 - p[..., 0], 0.01)


def headlamp(p):
    x, y, z = xyz(p)
    t = (y - x + 1.66) / 0.62  # 0 at the inner end, 1 at the outer
    f = smax(0.612 + 0.05 * t - z, z - (0.672 + 0.085 * t), 0.03)
    f = smax(f, 0.62 * (t - 1), 0.04)
    return smax(smax(f, -0.62 * t, 0.03), 1.5 - x, 0.02)


def bumper_front(p):
    x, y, z = xyz(p)
    f = smin(z - (0.60 + 0.30 * (x - 1.60)), 1.2 * (1.93 - x), 0.03)
    return smax(f, 1.3 - x, 0.02)


def grille(p):
    x, y, z = xyz(p)
    f = smax(z - 0.640, 0.492 - z, 0.02)
    f = smax(f, 0.9 * (y - 0.44 + 0.5 * np.abs(z - 0.60)), 0.04)
    return smax(f, 1.5 - x, 0.02)


def intake(p):
    x, y, z = xyz(p)
    f = smax(z - 0.385, 0.262 - z, 0.03)
    f = smax(f, 0.85 * (y - 0.50 - 0.7 * (0.40 - z)), 0.04)
    return smax(f, 1.5 - x, 0.02)


def fog(p):
    """The openings in the bumper's corners."""
    x, y, z = xyz(p)
    t = y - x
    f = smax(z - (0.465 + 0.16 * (t + 1.3)), (0.335 + 0.02 * (t + 1.3)) - z, 0.05)
    f = smax(f, 0.8 * (t + 1.10), 0.05)
    return smax(smax(f, 0.8 * (-1.42 - t + 0.8 * (z - 0.4)), 0.05), 1.5 - x, 0.02)


def doors(p):
    x, y, z = xyz(p)
    rear = np.hypot(x - s.AXLES[1], z - s.WHEEL_RADIUS)
    f = smax(0.245 - z, x - DOOR_FRONT - 0.05 * (z - 0.6), 0.05)
    f = smax(f, 0.447 - rear, 0.04)
    f = smax(f, -1.11 - x + 0.25 * (z - 0.95), 0.12)
    return smax(f, smin(side_windows(p) - 0.026, on_lower(p), 0.02), 0.02)


def door_split(p):
    x, y, z = xyz(p)
    return PILLAR - 0.06 * (z - 0.7) - x


def trunk(p):
    x, y, z = xyz(p)
    width = 0.53 + 0.10 * s.step((z - 0.86) / 0.13)
    f = smax(y - width, 0.632 - z, 0.06)
    return smax(smax(f, 0.06 - s.greenhouse(p), 0.06), x + 1.3, 0.02)


def taillamp(p):
    x, y, z = xyz(p)
    t = (y + x + 1.90) / 0.80
    f = smax(0.775 + 0.055 * (t - 0.3) - z, z - (0.885 + 0.012 * t), 0.04)
    return smax(smax(f, 0.80 * (t - 1), 0.05), x + 1.5, 0.02)


def bumper_rear(p):
    x, y, z = xyz(p)
    f = smin(z - (0.60 + 0.42 * (-1.575 - x)), 1.2 * (x + 2.0), 0.03)
    return smax(smax(f, z - 0.83, 0.02), x + 1.3, 0.02)


def diffuser(p):
    x, y, z = xyz(p)
    return smax(smax(z - 0.375, y - 0.58 + 0.4 * (z - 0.3), 0.05), x + 1.9, 0.02)


def roof_panel(p):
    f = smax(s.cabin_side(p) + 0.038, s.windscreen(p) + 0.03, 0.03)
    return smax(smax(f, s.backlight(p) + 0.035, 0.03), 1.1 - p[..., 2], 0.02)


def fuel_cap(p):
    x, y, z = xyz(p)
    q = (np.abs((x + 1.56) / 0.085) ** 3 + np.abs((z - 0.80) / 0.075) ** 3) ** (1 / 3)
    return smax(0.075 * (q - 1), 0.5 - y, 0.01)


def arch(axle):
    return lambda p: smax(np.hypot(p[..., 0] - axle, p[..., 2] - s.WHEEL_RADIUS) - s.ARCH_RADIUS, 0.5 - np.abs(p[..., 1]), 0.01)


def left_half(h):
    """The skin's left half, cut into labelled faces."""
    v, t = net(s.car, (-2.45, -2.5 * h, 0.1), (2.4, 1.05, 1.6), h)
    v = relax(s.car, project(s.car, v, 4), t, 6)
    skin = Skin(s.car, v, t, h)
    skin.label[:] = "skin"
    skin.cut(lambda p: p[..., 1], ["skin"])
    skin.v[np.abs(skin.v[:, 1]) < 1e-5, 1] = 0
    skin.label[skin.v[skin.t].mean(1)[:, 1] < 0] = "right"
    skin.t, skin.label = skin.t[skin.label == "skin"], skin.label[skin.label == "skin"]
    # Edges along the sharp lines, so that they are straight.
    skin.cut(lambda p: p[..., 2] - s.SHOULDER(p[..., 0]), ["skin"])
    if h < 0.03:
        skin.cut(lambda p: p[..., 2] - s.SHOULDER(p[..., 0]) - 0.011, ["skin"])
        skin.cut(lambda p: p[..., 2] - s.lower_line(p[..., 0]), ["skin"])
    skin.part(lambda p: p[..., 2] - s.BOTTOM(p[..., 0]) - 0.012, "skin", "underbody")
    for axle in s.AXLES:
        skin.part(arch(axle), ["skin", "underbody"], "hole")
    skin.part(side_windows, "skin", "window")
    skin.part(lambda p: side_windows(p) + 0.013, "window", "glass_side")
    skin.part(lambda p: s.lower(p) - 0.032, "window", "belt_trim")
    skin.part(lambda p: np.abs(door_split(p) + 0.01) - 0.042, "glass_side", "pillar_trim")
    skin.part(screens, "skin", "screen")
    skin.part(lambda p: screens(p) + 0.022, "screen", "glass_screen")
    skin.part(hood, "skin", "hood", GAP)
    skin.part(cowl, "skin", "cowl", 0.002)
    skin.part(headlamp, "skin", "headlamp", 0.003)
    skin.part(bumper_front, "skin", "bumper_front", GAP)
    skin.part(lambda p: p[..., 2] - 0.628 - 0.05 * (xyz(p)[1] - xyz(p)[0] + 1.66) / 0.62, "headlamp", "drl")
    skin.part(lambda p: p[..., 2] - 0.243, "bumper_front", "lip")
    skin.part(grille, "bumper_front", "grille_frame")
    skin.part(lambda p: grille(p) + 0.013, "grille_frame", "grille")
    skin.part(intake, "bumper_front", "intake")
    skin.part(fog, "bumper_front", "fog")
    skin.part(trunk, "skin", "trunk", GAP)
    skin.part(taillamp, "skin", "taillamp", 0.003)
    skin.part(lambda p: np.abs(p[..., 2] - 0.842) - 0.012, "taillamp", "tail_glow")
    skin.part(taillamp, "trunk", "tail_bar", 0.002)
    skin.part(lambda p: np.abs(p[..., 2] - 0.842) - 0.012, "tail_bar", "tail_glow")
    # Edges along the bends of the tail, so that reflections in it are straight.
    if h < 0.03:
        for z in (0.800, 0.816, 0.868, 0.884):
            skin.cut(lambda p: p[..., 2] - z, ["taillamp", "tail_bar"])
        skin.part(lambda p: p[..., 0] + 2.0, "trunk", "trunk_rear")
        for z in (0.905, 0.93, 0.955, 0.98, 1.005, 1.03):
            skin.cut(lambda p: p[..., 2] - z, ["trunk_rear"])
        skin.label[skin.label == "trunk_rear"] = "trunk"
    skin.part(bumper_rear, "skin", "bumper_rear", GAP)
    skin.part(diffuser, "bumper_rear", "diffuser")
    skin.part(doors, "skin", "door", GAP)
    skin.part(door_split, "door", "door_front", GAP)
    skin.part(roof_panel, "skin", "roof", GAP)
    skin.part(lambda p: smax(on_lower(p), DOOR_FRONT - p[..., 0], 0.01), "skin", "fender", GAP)
    skin.part(lambda p: p[..., 0] - 0.3, "skin", "body_rear")
    skin.part(fuel_cap, "body_rear", "fuel_cap", 0.003)
    return skin


def normals(v):
    return unit(s.gradient(s.car, v))


def mirrored(v, n, t):
    """The same on the right side."""
    flip = np.array([1, -1, 1])
    return v * flip, n * flip, t[:, ::-1]


def whole(v, n, t):
    """Both sides of a part that the middle plane cuts, as one mesh."""
    flat = v[:, 1] == 0
    to = np.arange(len(v))
    to[~flat] = len(v) + np.arange((~flat).sum())
    w, m, u = mirrored(v, n, t)
    n = n.copy()
    n[flat, 1] = 0
    n = unit(n)
    return np.concatenate([v, w[~flat]]), np.concatenate([n, m[~flat]]), np.concatenate([t, to[u]])


def sheet(skin, *labels, inset=0.0, depth=0.014, folded=True):
    """Vertices, normals and triangles of a part of the skin, moved inwards by `inset`."""
    v, t = skin.extract(*labels)
    n = normals(v)
    v = v - inset * n
    return fold(v, n, t, depth) if folded else (v, n, t)
