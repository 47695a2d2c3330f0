"""What the learned peers and the stored archives rest on. Run: python -m unittest discover -s lab/python/tests"""

import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from store import STEP, quantised  # noqa: E402
from surrogates import BODIES, DATA, Body, Kriging, Modes, frame, load, relative_l2  # noqa: E402


class SurrogateTest(unittest.TestCase):
    def test_stored_fields_are_within_half_a_step(self) -> None:
        field = np.random.default_rng(0).normal(scale=0.05, size=(50, 3)).astype(np.float32)
        self.assertLessEqual(np.abs(quantised(field, STEP) * STEP - field).max(), 0.5001 * STEP)
        self.assertEqual(quantised(np.full((2, 3), np.nan), STEP).max(), 0)
        with self.assertRaises(ValueError):
            quantised(np.array([0.4]), STEP)

    def test_impulses_point_into_the_body(self) -> None:
        for truth, body in BODIES:
            if truth != "presses":
                archive = np.load(DATA / truth / body / "train.npz")
                self.assertLess((archive["impulse"] * archive["contact_normal"]).sum(1).max(), 0)

    def test_kriging_meets_smooth_values(self) -> None:
        random = np.random.default_rng(0)
        place, other = random.uniform(-1, 1, (40, 3)), random.uniform(-1, 1, (40, 2))
        values = (place[:, :1] + 0.5 * other[:, 1:]) @ [[1.0, -2.0]]
        self.assertLess(np.abs(Kriging(place, other, values)(place, other) - values).max(), 0.1)

    def test_modes_know_their_own_examples(self) -> None:
        train, body = load("shots", "panel", "train").of(slice(0, 8)), Body.load("shots", "panel")
        self.assertLess(np.median(relative_l2(Modes(train, "displacement", body)(train), train.fields)), 0.5)

    def test_a_frame_is_a_rotation(self) -> None:
        for normal in np.eye(3):
            np.testing.assert_allclose(frame(normal) @ frame(normal).T, np.eye(3), atol=1e-12)
            np.testing.assert_allclose(frame(normal)[:, 2], normal)


if __name__ == "__main__":
    unittest.main()
