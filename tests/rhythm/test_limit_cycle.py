"""The cycle is what its series says, and every point is drawn to it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.rhythm.limit_cycle import LimitCycle, decayed, harmonics

numbers = st.floats(-0.3, 0.3)


@st.composite
def cycles(draw):
    count = draw(st.integers(1, 4))
    rows = [[draw(numbers), draw(numbers)] for _ in range(2 * count)]
    rows[0][0] = draw(st.floats(0.01, 0.3))
    return LimitCycle(np.array(rows), draw(st.floats(0.2, 5.0)), 0.1)


def circle(radius=0.1):
    return LimitCycle(np.array([[radius, 0.0], [0.0, radius]]), 1.0, 0.1)


def test_a_circle_is_a_circle():
    phase = np.linspace(0.0, 7.0, 50)
    expected = 0.1 * np.stack([np.cos(phase), np.sin(phase)], axis=-1)
    np.testing.assert_allclose(circle().offset(phase), expected, atol=1e-15)


@given(cycles(), st.floats(-10.0, 10.0))
def test_the_tangent_is_the_derivative(cycle, phase):
    h = 1e-5
    slope = (cycle.offset(phase + h) - cycle.offset(phase - h)) / (2.0 * h)
    # Fourth harmonics of 0.3: h^2 times the third derivative is below 1e-8.
    np.testing.assert_allclose(cycle.tangent(phase), slope, atol=1e-7)


@given(cycles(), st.floats(0.0, 2.0 * np.pi))
def test_no_point_of_the_cycle_is_outside_its_radius(cycle, phase):
    assert np.linalg.norm(cycle.offset(phase)) <= cycle.radius


@given(cycles())
def test_the_radius_is_no_more_than_the_cycle_needs(cycle):
    turn = np.linspace(0.0, 2.0 * np.pi, 2000)
    farthest = np.linalg.norm(cycle.offset(turn), axis=1).max()
    # 7.5e-5 times the bend of four harmonics of 0.6 each, which is below 18.
    assert cycle.radius <= farthest + 1.4e-3


@given(cycles())
def test_the_cycle_goes_round_its_middle(cycle):
    turn = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    np.testing.assert_allclose(cycle.offset(turn).mean(axis=0), 0.0, atol=1e-12)


@given(cycles(), st.floats(0.0, 2.0 * np.pi), st.floats(0.0, 2.0 * np.pi))
def test_pushed_by_a_tenth_it_is_back_within_one_period(cycle, phase, direction):
    pushed = cycle.offset(phase) + 0.1 * np.array(
        [np.cos(direction), np.sin(direction)]
    )
    nearest = cycle.nearest_phase(pushed)
    left = decayed(pushed - cycle.offset(nearest), periods=1.0)
    # A hundredth of the push; exp(-5) is less. It starts no further off than 0.1 and
    # the step between two phases that are looked at.
    assert np.linalg.norm(left) <= 0.001


def test_the_nearest_phase_is_found():
    phase = circle().nearest_phase(np.array([0.0, 3.0]))
    assert phase == pytest.approx(np.pi / 2.0, abs=np.pi / 256)


def test_harmonics_are_cosines_and_sines():
    phase = np.array([0.3, -2.0, 40.0])
    k = np.arange(1, 4)
    pairs = np.stack([np.cos(np.outer(phase, k)), np.sin(np.outer(phase, k))], axis=-1)
    np.testing.assert_allclose(harmonics(phase, 3), pairs.reshape(3, 6), atol=1e-13)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"coefficients": np.zeros((2, 2))}, "the cycle is a point"),
        ({"coefficients": np.ones((3, 2))}, r"shape \(2 K, 2\)"),
        ({"coefficients": np.full((2, 2), np.nan)}, "finite"),
        ({"period": 0.0}, "period"),
        ({"pitch": -0.1}, "pitch"),
        ({"pitch": 0.0}, "pitch"),
        ({"begin": np.inf}, "begin"),
        ({"end": -1.0}, "end"),
    ],
)
def test_what_is_no_cycle_is_refused(change, complaint):
    good = {"coefficients": np.eye(2), "period": 1.0, "pitch": 0.1}
    with pytest.raises(ValueError, match=complaint):
        LimitCycle(**{**good, **change})
