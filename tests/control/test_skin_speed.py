"""The washed point's way along the skin is bounded, and nothing else is."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from bath_drake.control.skin_speed import (
    SKIN_SPEED,
    WashedPoint,
    along_skin,
    within_skin_speed,
)

NUMBER = st.floats(-2.0, 2.0)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER).map(np.array)
TWIST = st.lists(NUMBER, min_size=6, max_size=6).map(np.array)
# The way from the nozzle to the skin is never of no length.
WASHED = st.builds(
    WashedPoint, VECTOR.filter(lambda v: np.linalg.norm(v) > 0.01), TWIST
)
# Rounding of a few sums of products of numbers up to 2, over lengths of 0.01.
ROUNDING = 1e-10


def along(twist, washed):
    return along_skin(twist, washed.p_ES_W, washed.skin)


def slowed(twist, washed):
    return within_skin_speed(twist, washed.p_ES_W, washed.skin, SKIN_SPEED)


def carried_by(washed):
    """The twist of a nozzle that is fixed to the skin."""
    turn = washed.skin[:3]
    return np.concatenate([turn, washed.skin[3:] - np.cross(turn, washed.p_ES_W)])


@given(TWIST, WASHED)
def test_the_washed_point_is_never_faster_than_the_bound(twist, washed):
    kept = slowed(twist, washed)
    assert np.linalg.norm(along(kept, washed)) <= SKIN_SPEED + ROUNDING


@given(TWIST, WASHED)
def test_the_distance_changes_as_it_was_asked_to(twist, washed):
    kept = slowed(twist, washed)
    asked = (twist[3:] - washed.skin[3:]) @ washed.p_ES_W
    assert abs((kept[3:] - washed.skin[3:]) @ washed.p_ES_W - asked) <= ROUNDING


@given(TWIST, WASHED)
def test_the_way_on_the_skin_keeps_its_direction(twist, washed):
    asked = along(twist, washed)
    speed = np.linalg.norm(asked)
    assume(speed > SKIN_SPEED)
    kept = along(slowed(twist, washed), washed)
    np.testing.assert_allclose(kept, asked * SKIN_SPEED / speed, atol=ROUNDING)


@given(WASHED)
def test_a_nozzle_that_the_skin_carries_is_left_alone(washed):
    carried = carried_by(washed)
    np.testing.assert_allclose(along(carried, washed), 0.0, atol=ROUNDING)
    np.testing.assert_array_equal(slowed(carried, washed), carried)


@given(TWIST, WASHED, st.floats(0.0, 0.99))
def test_what_is_slow_enough_is_not_touched(twist, washed, share):
    speed = np.linalg.norm(along(twist, washed))
    slower = share * SKIN_SPEED / max(speed, SKIN_SPEED)
    slow = carried_by(washed) + slower * (twist - carried_by(washed))
    np.testing.assert_array_equal(slowed(slow, washed), slow)


def test_a_turn_moves_the_point_by_its_distance():
    """One rad/s at 60 mm is 0.06 m/s, and no turn about the jet moves it."""
    washed = WashedPoint(np.array([0.0, 0.0, 0.06]), np.zeros(6))
    tilt = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    about = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(along(tilt, washed), [0.0, -0.06, 0.0])
    np.testing.assert_allclose(along(about, washed), np.zeros(3))
