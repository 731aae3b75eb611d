"""The free disc round a point is free, and nearly as large as it can be."""

import numpy as np
import pytest

from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.rhythm.clearance import clearance

WIDE = Workspace(np.zeros(2), np.array([50.0, 50.0]))
NONE = ObstacleSet()


def nearest_of(theta, q):
    """The true distance to an ellipse, from points of its boundary."""
    return np.linalg.norm(ObstacleSet(theta).boundary(20001)[0] - q, axis=1).min()


def test_the_distance_to_an_ellipse_is_found_from_below(rng):
    for _ in range(300):
        axes = np.exp(rng.uniform(np.log(0.01), np.log(1.0), 2))
        theta = np.array([[*rng.uniform(-0.5, 0.5, 2), *axes, rng.uniform(0, 7)]])
        q = rng.uniform(-1.5, 1.5, 2)
        free = clearance(q, ObstacleSet(theta), WIDE, np.inf)
        true = nearest_of(theta, q)
        # Points of the boundary are 3e-4 apart: the nearest is that much off where
        # the ellipse is touched, its square elsewhere.
        inside = free == 0.0
        assert inside or true - 2e-4 <= free <= true + 1e-12


def test_in_an_area_there_is_no_room():
    areas = ObstacleSet(np.array([[0.2, 0.1, 0.3, 0.2, 0.4]]))
    for q in ([0.2, 0.1], [0.3, 0.2]):
        assert clearance(np.array(q), areas, WIDE, np.inf) == 0.0


@pytest.mark.parametrize("power", [2, 4, 8])
def test_a_disc_within_the_rim_stays_within(power, rng):
    workspace = Workspace(np.array([0.1, -0.2]), np.array([1.2, 0.7]), power)
    turn = np.linspace(0.0, 2.0 * np.pi, 90)
    round_ = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    for q in rng.uniform(-1.5, 1.5, (200, 2)):
        free = clearance(q, NONE, workspace, np.inf)
        if workspace.beta(q) <= 0.0:
            assert free == 0.0
        else:
            # Rounding of powers.
            assert workspace.beta(q + free * round_).min() >= -1e-9


def test_round_a_circular_rim_the_distance_is_exact():
    workspace = Workspace(np.zeros(2), np.array([1.5, 1.5]))
    free = clearance(np.array([0.3, 0.4]), NONE, workspace, np.inf)
    assert free == pytest.approx(1.0, abs=1e-9)


def test_the_box_of_the_body_is_kept():
    assert clearance(np.array([0.7, -0.2]), NONE, WIDE, 1.0) == pytest.approx(0.3)
    assert clearance(np.array([0.7, -1.2]), NONE, WIDE, 1.0) == 0.0


@pytest.mark.parametrize("q", [[np.nan, 0.0], [0.0, np.nan], [np.inf, 0.0]])
def test_a_point_that_is_no_number_has_no_room(q):
    areas = ObstacleSet(np.array([[0.2, 0.1, 0.3, 0.2, 0.4]]))
    for obstacles in (areas, NONE):
        assert clearance(np.array(q), obstacles, WIDE, np.inf) == 0.0


def test_the_nearest_of_several_areas_counts():
    areas = ObstacleSet(
        np.array([[2.0, 0.0, 0.5, 0.5, 0.0], [0.0, 1.0, 0.25, 0.25, 0.0]])
    )
    free = clearance(np.zeros(2), areas, WIDE, np.inf)
    assert free == pytest.approx(0.75, abs=1e-9)
