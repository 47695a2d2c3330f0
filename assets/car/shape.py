"""The car's shape: functions of points that are negative inside, about as steep as a distance.

Metres; x points forward, y to the left, z up. The origin lies on the ground in the middle between the axles. Every function reads
|y|, so the car is symmetric. The lower body and the greenhouse are smooth intersections of a few curved faces, and the car is their
smooth union."""

import numpy as np

LENGTH_FRONT, LENGTH_REAR = 2.185, -2.275  # where nose and tail end, about
AXLES = (1.36, -1.335)
WHEEL_RADIUS, WHEEL_WIDTH, TRACK = 0.338, 0.215, 1.56
ARCH_RADIUS = 0.372


HANDLES = (-0.045, -0.955)  # where the doors' handles are


def HANDLE_HEIGHT(x):
    return 0.792 - 0.02 * x


class Spline:
    """A natural cubic spline through points. It goes on straight outside them."""

    def __init__(self, *points):
        points = sorted(points)
        x, y = np.array(points, float).T
        h, s = np.diff(x), np.diff(y) / np.diff(x)
        a = np.eye(len(x))
        b = np.zeros(len(x))
        for i in range(1, len(x) - 1):
            a[i, i - 1 : i + 2] = h[i - 1], 2 * (h[i - 1] + h[i]), h[i]
            b[i] = 6 * (s[i] - s[i - 1])
        m = np.linalg.solve(a, b)
        self.x, self.y, self.m, self.h = x, y, m, h
        self.low = s[0] - h[0] * m[1] / 6
        self.high = s[-1] + h[-1] * m[-2] / 6

    def __call__(self, at):
        x, y, m = self.x, self.y, self.m
        inside = np.clip(at, x[0], x[-1])
        i = np.clip(np.searchsorted(x, inside) - 1, 0, len(x) - 2)
        h = self.h[i]
        a, b = (x[i + 1] - inside) / h, (inside - x[i]) / h
        value = a * y[i] + b * y[i + 1] + ((a**3 - a) * m[i] + (b**3 - b) * m[i + 1]) * h * h / 6
        return value + np.minimum(at - x[0], 0) * self.low + np.maximum(at - x[-1], 0) * self.high


def smax(a, b, k):
    """A maximum with a continuous curvature; it is rounded where a and b differ by less than k."""
    h = np.maximum(k - np.abs(a - b), 0) / k
    return np.maximum(a, b) + h**3 * k / 6


def smin(a, b, k):
    return -smax(-a, -b, k)


def step(t):
    """0 for t < 0, 1 for t > 1, smooth between."""
    t = np.clip(t, 0, 1)
    return t * t * t * (t * (6 * t - 15) + 10)


def ramp(t, r):
    """max(t, 0), rounded by r."""
    return (np.sqrt(t * t + r * r) + t) / 2


def bell(t):
    return np.exp(-t * t)


# The lower body.
HALF_WIDTH = Spline((2.25, 0.80), (1.9, 0.845), (1.36, 0.873), (0.5, 0.884), (-0.3, 0.889), (-1.335, 0.887), (-1.9, 0.862), (-2.3, 0.81))
BARREL = Spline((0.12, -0.075), (0.22, -0.038), (0.35, -0.012), (0.52, 0.0), (0.68, -0.003), (0.85, -0.014), (1.0, -0.03))
SHOULDER = Spline((2.2, 0.735), (1.8, 0.775), (1.36, 0.808), (0.6, 0.838), (-0.4, 0.862), (-1.335, 0.888), (-2.25, 0.905))
DECK = Spline((2.32, 0.60), (2.16, 0.705), (2.0, 0.778), (1.7, 0.862), (1.36, 0.922), (0.95, 0.972), (0.5, 1.0), (-1.0, 1.035), (-1.6, 1.05), (-2.0, 1.045), (-2.28, 1.04))
CROWN = Spline((2.2, 0.07), (1.36, 0.085), (0.5, 0.085), (-1.2, 0.075), (-2.2, 0.055))
NOSE = Spline((0.12, 2.03), (0.2, 2.115), (0.27, 2.14), (0.36, 2.148), (0.47, 2.172), (0.56, 2.182), (0.64, 2.17), (0.72, 2.125), (0.85, 2.0))
TAIL = Spline((0.15, -2.13), (0.26, -2.2), (0.38, -2.252), (0.5, -2.272), (0.6, -2.27), (0.7, -2.247), (0.82, -2.232), (0.95, -2.238), (1.04, -2.258))
BOTTOM = Spline((2.2, 0.20), (1.36, 0.19), (0.7, 0.175), (-0.7, 0.175), (-1.335, 0.2), (-2.25, 0.27))


def lower_line(x):
    """Height of the line along the doors, above the sill."""
    return 0.335 + 0.045 * (0.8 - x)


def half_width(x, z):
    """Half the width of the lower body's side."""
    t = z - SHOULDER(x)
    along = step((2.25 - x) / 0.9) * step((x + 2.5) / 0.5)
    y = HALF_WIDTH(x) + BARREL(z)
    y = y - 0.42 * ramp(t, 0.007) - 0.013 * bell((t + 0.085) / 0.055) * along + 0.004 * bell(t / 0.03) * along
    doors = step((0.98 - x) / 0.25) * step((x + 0.98) / 0.25)
    u = lower_line(x) - z
    y = y - doors * 0.016 * (1 - np.exp(-ramp(u, 0.010) / 0.045)) + doors * 0.026 * step((0.262 - z) / 0.05)
    for at in HANDLES:
        y = y - 0.017 * bell(((x - at - 0.012) / 0.062) ** 2) * bell(((z - HANDLE_HEIGHT(x)) / 0.030) ** 2)
    for axle in AXLES:
        r = np.hypot(x - axle, z - WHEEL_RADIUS)
        y = y + 0.020 * bell((r - ARCH_RADIUS) / 0.075)
    hips = 0.018 * bell((x - AXLES[1]) / 0.5) * bell((z - 0.80) / 0.15) + 0.008 * bell((x - AXLES[0]) / 0.4) * bell((z - 0.74) / 0.15)
    return y + hips


def deck(x, y):
    """Height of hood and trunk."""
    z = DECK(x) - CROWN(x) * (y / 0.8) ** 2
    line = 0.36 + 0.16 * (1.9 - x)  # the hood's ridge in plan
    front = step((x - 0.9) / 0.6)
    z = z + front * 0.016 * step((line + 0.035 - y) / 0.07) * step((2.3 - x) / 0.5)
    lip = 0.020 * bell((x + 2.24) / 0.10) * step((0.9 - y) / 0.3)
    return z + lip


def side(p):
    x, y, z = p[..., 0], np.abs(p[..., 1]), p[..., 2]
    return 0.97 * (y - half_width(x, z))


def top(p):
    x, y, z = p[..., 0], np.abs(p[..., 1]), p[..., 2]
    return 0.97 * (z - deck(x, y))


def nose(p):
    x, y, z = p[..., 0], np.abs(p[..., 1]), p[..., 2]
    return 0.95 * (x - NOSE(z) + 0.30 * (y / 0.9) ** 2.4)


def tail(p):
    x, y, z = p[..., 0], np.abs(p[..., 1]), p[..., 2]
    return 0.95 * (TAIL(z) + 0.20 * (y / 0.9) ** 2.4 - x)


def bottom(p):
    return BOTTOM(p[..., 0]) - p[..., 2]


def lower(p):
    """The body without the greenhouse."""
    f = smax(smax(side(p), nose(p), 0.26), tail(p), 0.22)
    x = p[..., 0]
    edge = 0.055 + 0.05 * step((x - 1.6) / 0.4) + 0.02 * step((-x - 2.0) / 0.2)
    return smax(smax(f, top(p), edge), bottom(p), 0.05)


# The greenhouse.
ROOF = Spline((0.6, 1.375), (0.3, 1.412), (0.0, 1.433), (-0.35, 1.44), (-0.7, 1.428), (-1.1, 1.388), (-1.5, 1.32))
BELT_WIDTH = Spline((1.3, 0.725), (0.8, 0.765), (0.2, 0.795), (-0.4, 0.797), (-1.0, 0.772), (-1.5, 0.715), (-1.9, 0.65))


def windscreen(p):
    x, y, z = p[..., 0], np.abs(p[..., 1]), p[..., 2]
    return 0.49 * (x - 1.06 + 0.17 * (y / 0.7) ** 2) + 0.872 * (z - 0.955) + 0.022 * (((z - 1.18) / 0.22) ** 2 - 1)


def backlight(p):
    x, y, z = p[..., 0], np.abs(p[..., 1]), p[..., 2]
    return 0.42 * (-x - 1.78 + 0.16 * (y / 0.7) ** 2) + 0.907 * (z - 1.035) + 0.012 * (((z - 1.2) / 0.2) ** 2 - 1)


def roof(p):
    x, y, z = p[..., 0], np.abs(p[..., 1]), p[..., 2]
    return z - ROOF(x) + 0.06 * (y / 0.56) ** 2


def cabin_side(p):
    x, y, z = p[..., 0], np.abs(p[..., 1]), p[..., 2]
    t = z - 0.95
    return 0.9 * (y - BELT_WIDTH(x) + 0.38 * t + 0.22 * t * t)


def greenhouse(p):
    f = smax(smax(windscreen(p), roof(p), 0.16), backlight(p), 0.22)
    f = smax(f, 0.82 - p[..., 2], 0.02)
    return smax(f, cabin_side(p), 0.085)


def car(p):
    x = p[..., 0]
    fillet = 0.02 + 0.11 * step((-x - 1.15) / 0.4)
    return smin(lower(p), greenhouse(p), fillet)


def gradient(f, p, h=2e-4):
    """The gradient of f by central differences."""
    g = np.empty_like(p)
    for k in range(3):
        d = np.zeros(3)
        d[k] = h
        g[..., k] = (f(p + d) - f(p - d)) / (2 * h)
    return g
