"""The washed point's way along the skin is bounded, and nothing else is."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from bath_drake.control.skin_speed import SKIN_SPEED, along_skin, within_skin_speed

NUMBER = st.floats(-2.0, 2.0)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER).map(np.array)
TWIST = st.lists(NUMBER, min_size=6, max_size=6).map(np.array)
# Rounding of sums of numbers up to 2.
ROUNDING = 1e-12


def jets():
    """Ways from the nozzle to the skin, none of them of no length."""
    return VECTOR.filter(lambda v: np.linalg.norm(v) > 0.01)


def carried_by(skin, p_ES):
    """The twist of a nozzle that is fixed to the skin."""
    return np.concatenate([skin[:3], skin[3:] - np.cross(skin[:3], p_ES)])


@given(TWIST, jets(), TWIST)
def test_the_washed_point_is_never_faster_than_the_bound(twist, p_ES, skin):
    kept = within_skin_speed(twist, p_ES, skin)
    speed = np.linalg.norm(along_skin(kept, p_ES, skin))
    assert speed <= SKIN_SPEED + ROUNDING


@given(TWIST, jets(), TWIST)
def test_the_distance_changes_as_it_was_asked_to(twist, p_ES, skin):
    kept = within_skin_speed(twist, p_ES, skin)
    asked = (twist[3:] - skin[3:]) @ p_ES
    assert abs((kept[3:] - skin[3:]) @ p_ES - asked) <= 1e3 * ROUNDING


@given(TWIST, jets(), TWIST)
def test_the_way_on_the_skin_keeps_its_direction(twist, p_ES, skin):
    asked = along_skin(twist, p_ES, skin)
    kept = along_skin(within_skin_speed(twist, p_ES, skin), p_ES, skin)
    speed = np.linalg.norm(asked)
    assume(speed > SKIN_SPEED)
    np.testing.assert_allclose(kept, asked * SKIN_SPEED / speed, atol=1e3 * ROUNDING)


@given(jets(), TWIST)
def test_a_nozzle_that_the_skin_carries_is_left_alone(p_ES, skin):
    carried = carried_by(skin, p_ES)
    np.testing.assert_allclose(
        along_skin(carried, p_ES, skin), 0.0, atol=1e2 * ROUNDING
    )
    np.testing.assert_array_equal(within_skin_speed(carried, p_ES, skin), carried)


@given(TWIST, jets(), TWIST, st.floats(0.0, 0.99))
def test_what_is_slow_enough_is_not_touched(twist, p_ES, skin, share):
    speed = np.linalg.norm(along_skin(twist, p_ES, skin))
    slower = share * SKIN_SPEED / max(speed, SKIN_SPEED)
    slow = carried_by(skin, p_ES) + slower * (twist - carried_by(skin, p_ES))
    np.testing.assert_array_equal(within_skin_speed(slow, p_ES, skin), slow)


def test_a_turn_moves_the_point_by_its_distance():
    """One rad/s at 60 mm is 0.06 m/s, and no turn about the jet moves it."""
    p_ES, skin = np.array([0.0, 0.0, 0.06]), np.zeros(6)
    tilt = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    about = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(along_skin(tilt, p_ES, skin), [0.0, -0.06, 0.0])
    np.testing.assert_allclose(along_skin(about, p_ES, skin), np.zeros(3))
