"""Facts that every test starts from. The tests run against the installed wheel: they import nothing from this folder's source."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import crumple

REPOSITORY = Path(__file__).resolve().parents[3]
HOOD = REPOSITORY / "assets/demo/hood.glb"
SIDE = 41


@pytest.fixture
def context():
    with crumple.Context(threads=1) as context:
        yield context


def sheet():
    """A sheet of 1 m by 1 m: positions, triangles, and the positions with a dent of 5 cm in the middle."""
    x, y = np.meshgrid(*2 * [np.linspace(-0.5, 0.5, SIDE, dtype=np.float32)], indexing="ij")
    flat = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
    near = np.maximum(0, 1 - (x**2 + y**2) / 0.04).reshape(-1)
    a = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)[:-1, :-1].reshape(-1, 1)
    triangles = np.concatenate([a + [0, SIDE, SIDE + 1], a + [0, SIDE + 1, 1]]).astype(np.uint32)
    dented = flat.copy()
    dented[:, 2] = -0.05 * near**2
    return flat, triangles, dented


@pytest.fixture
def sheet_set(context):
    flat, triangles, dented = sheet()
    options = crumple.SetOptions(vertex_mass=0.5)
    return context.example_set(flat, triangles, [crumple.Example(dented, name="middle")], options=options)


def command(*arguments, **options):
    """Runs the `crumple` command that is installed with the tested package."""
    program = Path(sys.executable).with_name("crumple")
    return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, **options)
