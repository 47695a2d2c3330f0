"""Converts a truth's archives to those of `lab/data`: `python lab/python/store.py SOURCE`, SOURCE has TRUTH/BODY/*.npz.

Fields become multiples of a step, as 16-bit integers. Every impact gets what is known of its blow, with the impulse on the body.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

DATA = Path(__file__).resolve().parents[1] / "data"
BODIES = {"shots": ("panel", "tube"), "presses": ("panel", "tube"), "structure": ("door", "box"), "steel": ("hood",), "dense": ("door", "box")}
SETS = ("base", "train", "train_free", "heldout", "play", "sequences", "train_sequences", "repeat", "wreck")
# The steps of a stored displacement, m. The many hits of the dense truth are stored more coarsely.
STEP, DENSE_STEP = 1e-5, 5e-5
# Hits of the dense truth that leave less than this at the contact (m), or whose shell still moves faster (m/s), are left out.
LEAST_DEPTH, LARGEST_RESIDUAL = 2e-3, 0.04
# Mass of the shots' ball, kg, and the friction between it and the body.
BALL_KG, FRICTION = 2.5, 0.4
# What no part of the lab reads.
LEFT_OUT = ("wall_seconds", "simulated_seconds", "settling_change", "left", "energy_balance", "frame_displacement", "peak_displacement")

Arrays = dict[str, NDArray]


def quantised(field: NDArray, step: float) -> NDArray:
    """As multiples of the step. The padding of short sequences becomes 0."""
    steps = np.round(np.nan_to_num(field.astype(float)) / step)
    if np.abs(steps).max(initial=0) > np.iinfo(np.int16).max:
        raise ValueError("a displacement is longer than 16 bits can store")
    return steps.astype(np.int16)


def ball_blow(impacts: Arrays, normals: NDArray) -> Arrays:
    """What a rigid-body engine knows of a shot at a fixed body: the normal momentum without restitution, and friction."""
    normal = normals[np.maximum(impacts["contact_vertex"], 0)].astype(float)
    velocity = impacts["direction"].astype(float) * impacts["speed"][..., None]
    along = -(velocity * normal).sum(-1, keepdims=True)
    across = velocity + along * normal
    speed = np.linalg.norm(across, axis=-1, keepdims=True)
    tangential = np.minimum(FRICTION * BALL_KG * along, BALL_KG * speed) * across / np.maximum(speed, 1e-9)
    blow = {"contact_normal": normal, "velocity": velocity, "impulse": tangential - BALL_KG * along * normal}
    return {name: value.astype(np.float32) for name, value in blow.items()} | {"mass": np.full(normal.shape[:-1], BALL_KG, np.float32)}


def stored(truth: str, arrays: Arrays, normals: NDArray) -> Arrays:
    """The arrays of one archive as `lab/data` keeps them."""
    if "contact_vertex" not in arrays:
        return arrays
    step = STEP
    if truth == "dense":
        step = DENSE_STEP
        contact = arrays["fields"][np.arange(len(arrays["fields"])), arrays["contact_vertex"]]
        kept = (np.linalg.norm(contact, axis=-1) >= LEAST_DEPTH) & (arrays["residual_speed"] <= LARGEST_RESIDUAL)
        arrays = {name: value[kept] if value.shape[:1] == kept.shape else value for name, value in arrays.items() if name != "contact_displacement"}
    out: Arrays = {"step": np.float64(step)}
    for name, value in arrays.items():
        if name in LEFT_OUT or name.removesuffix("_single").removesuffix("_after") in LEFT_OUT:
            continue
        if "fields" in name:
            value = quantised(value, step)
        elif name.startswith("impulse"):
            value = -value
        elif value.dtype == np.int64 and name != "offsets":
            value = value.astype(np.int32)
        out[name] = value
    if truth == "shots" and "speed" in arrays:
        out |= ball_blow(arrays, normals)
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", type=Path)
    parser.add_argument("--to", type=Path, default=DATA)
    options = parser.parse_args()
    for truth, bodies in BODIES.items():
        for body in bodies:
            source, to = options.source / truth / body, options.to / truth / body
            normals = np.load(source / "base.npz")["normals"]
            to.mkdir(parents=True, exist_ok=True)
            for name in SETS:
                path = source / f"{name}.npz"
                # The repeats of the other truths only measure their noise.
                if not path.exists() or (name == "repeat" and truth != "shots"):
                    continue
                with np.load(path) as archive:
                    np.savez_compressed(to / f"{name}.npz", **stored(truth, dict(archive), normals))
                print(f"{truth}/{body}/{name}.npz: {(to / f'{name}.npz').stat().st_size} bytes")


if __name__ == "__main__":
    main()
