"""How far a point is from seen skin, against all distances, sorted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.perception.skin_distance import LEAST_AREA, REACH, STEP, skin_distance

PIXEL = 1e-5  # m^2, of a Kinect v2's at 1.2 m


def sheet(height=0.0):
    x, y = np.mgrid[-0.1:0.1:0.003, -0.1:0.1:0.003]
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)])


def areas(points):
    return np.full(len(points), PIXEL)


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(0, 400))
def test_it_is_the_distance_within_which_there_is_enough_skin(seed, count):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.15, 0.15, (count, 3))
    weights = rng.uniform(0.0, 3e-5, count)
    p_WQ = rng.uniform(-0.1, 0.1, 3)
    distances = np.linalg.norm(points - p_WQ, axis=1)
    order = np.argsort(distances)
    enough = np.flatnonzero(np.cumsum(weights[order]) >= LEAST_AREA)
    expected = distances[order][enough[0]] if len(enough) else np.inf
    found = skin_distance(points, weights, p_WQ)
    if expected > REACH:
        assert found == np.inf
    else:
        # A square root's rounding at a step's end.
        assert expected - STEP - 1e-12 <= found <= expected + 1e-12


@pytest.mark.parametrize("direction", [[0, 0, 1], [0, 1, 0], [0.6, 0, 0.8]])
def test_it_looks_in_every_direction(direction):
    points = sheet()
    far = points.max(axis=0) + 0.05 * np.array(direction)
    near = np.linalg.norm(points - far, axis=1).min()
    # The least area is a quarter disc of 16 mm at the sheet's corner.
    assert near - STEP <= skin_distance(points, areas(points), far) < near + 0.017


def test_a_few_pixels_in_the_air_are_no_skin():
    flying = np.array([0.0, 0.0, 0.05]) + 1e-3 * np.eye(3)
    points = np.vstack([sheet(), flying])
    found = skin_distance(points, areas(points), np.array([0.0, 0.0, 0.06]))
    assert found == pytest.approx(0.06, abs=1e-3)


def test_where_no_skin_is_seen_or_near_there_is_no_distance():
    nothing = np.zeros((0, 3))
    assert skin_distance(nothing, np.zeros(0), np.zeros(3)) == np.inf
    points = sheet()
    assert skin_distance(points, areas(points), np.array([0.0, 0.0, 0.2])) == np.inf
