"""What the comparison between grids rests on. Run: python -m unittest discover -s lab/python/tests"""

import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from grids import Grid, field_error, interpolate, inverted  # noqa: E402

DATA = Path(__file__).resolve().parents[2] / "data"
SIZES = {("shots", "panel"): (53, 41), ("shots", "tube"): (68, 33), ("presses", "panel"): (73, 57), ("presses", "tube"): (104, 49)}


class GridTest(unittest.TestCase):
    def test_reproduces_the_stored_bodies(self) -> None:
        for (truth, body), size in SIZES.items():
            base = np.load(DATA / truth / body / "base.npz")
            grid = Grid(truth, body, *size)
            np.testing.assert_allclose(grid.vertices(), base["vertices"], atol=2e-7)
            if truth == "shots":
                np.testing.assert_array_equal(grid.triangles(), base["triangles"])
                np.testing.assert_array_equal(grid.pinned(), base["pinned"])

    def test_interpolation_is_exact_where_it_must_be(self) -> None:
        for (truth, body), size in SIZES.items():
            grid = Grid(truth, body, *size)
            field = np.random.default_rng(0).normal(size=(grid.nu * grid.nv, 3))
            np.testing.assert_allclose(interpolate(field, grid, grid), field, atol=1e-9)
            coarse = grid.resized(0.5)
            self.assertEqual(interpolate(np.ones((coarse.nu * coarse.nv, 3)), coarse, grid).min(), 1.0)
            _, t = coarse.parameters()
            _, fine = grid.parameters()
            np.testing.assert_allclose(interpolate(t[:, None], coarse, grid)[:, 0], fine, atol=1e-12)

    def test_triangles_of_a_tube_close(self) -> None:
        for factor in (0.25, 0.5, 1.0, 2.0):
            grid = Grid("shots", "tube", 68, 33).resized(factor)
            edges = np.concatenate([grid.triangles()[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
            _, counts = np.unique(np.sort(edges, 1), axis=0, return_counts=True)
            self.assertEqual(int((counts == 1).sum()), 2 * grid.nu)

    def test_inverted_counts_flips_and_not_tilts(self) -> None:
        base = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
        triangle = np.array([[0, 1, 2]])
        tilted, flipped = base.copy(), base.copy()
        tilted[2] = [0, 0.1, 1]
        flipped[2] = [0, -0.1, 1]
        self.assertEqual(inverted(base, tilted, triangle), 0)
        self.assertEqual(inverted(base, flipped, triangle), 1)

    def test_scaling_forgives_depth_and_not_shape(self) -> None:
        truth = np.array([[0, 0, -0.02], [0, 0, -0.01]])
        self.assertAlmostEqual(field_error(truth * 3, truth, 0).scaled_relative_l2, 0.0)
        self.assertAlmostEqual(field_error(truth * 3, truth, 0).relative_l2, 2.0)
        self.assertEqual(field_error(truth * 0, truth, 0).scaled_relative_l2, 1.0)
        self.assertEqual(field_error(None, truth, 0).relative_l2, np.inf)


if __name__ == "__main__":
    unittest.main()
