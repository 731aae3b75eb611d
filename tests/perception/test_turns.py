"""Turns as vectors."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bath_drake.perception.turns import turn_matrix, turn_vector


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 0.3, 2.0, 3.1, np.pi - 1e-7])
def test_it_is_what_the_rotation_was_made_of(angle, rng):
    for _ in range(50):
        axis = rng.normal(size=3)
        turn = angle * axis / np.linalg.norm(axis)
        found = turn_vector(Rotation.from_rotvec(turn).as_matrix())
        # The matrix holds a turn to rounding, and one near pi as well as any other.
        np.testing.assert_allclose(found, turn, atol=4e-15 if angle < 3.0 else 1e-14)


@pytest.mark.parametrize("axis", np.eye(3))
def test_half_a_turn_is_one_about_its_axis(axis):
    half = turn_vector(2.0 * np.outer(axis, axis) - np.eye(3))
    np.testing.assert_allclose(np.abs(half), np.pi * axis, atol=1e-15)


def test_it_agrees_with_scipy(rng):
    for R in Rotation.random(200, random_state=rng):
        expected = R.as_rotvec()
        np.testing.assert_allclose(turn_vector(R.as_matrix()), expected, atol=1e-13)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 1e-3, 0.3, 3.0, 7.0])
def test_a_turn_makes_scipys_rotation(angle, rng):
    for _ in range(50):
        axis = rng.normal(size=3)
        turn = angle * axis / np.linalg.norm(axis)
        expected = Rotation.from_rotvec(turn).as_matrix()
        # The same formulas; another mathematics library may round once otherwise.
        np.testing.assert_allclose(turn_matrix(turn), expected, atol=1e-15)
