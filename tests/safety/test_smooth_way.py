"""A way from rest to rest with bounded speed, acceleration and jerk."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.safety.smooth_way import SmoothWay

DT = 0.005
WAYS = st.builds(
    SmoothWay,
    distance=st.floats(1e-3, 0.3),
    speed=st.floats(0.005, 0.25),
    acceleration=st.floats(0.05, 10.0),
    jerk=st.floats(0.5, 1e3),
)


def places(way):
    ticks = int(np.ceil(way.seconds / DT)) + 4
    return np.array([way.travelled(k * DT) for k in range(-3, ticks)])


@given(way=WAYS)
def test_every_bound_is_kept_and_the_end_is_reached_and_never_passed(way):
    p = places(way)
    assert p[0] == 0.0
    assert p[-1] == way.distance
    assert (np.diff(p) >= -1e-15).all()
    # Means over a tick keep what holds at every moment. 1e-15 m: rounding.
    for order, bound in ((1, way.speed), (2, way.acceleration), (3, way.jerk)):
        derivative = np.abs(np.diff(p, order)) / DT**order
        assert derivative.max() <= bound * (1.0 + 1e-9) + 2**order * 1e-15 / DT**order


@given(way=WAYS)
def test_it_is_the_quickest(way):
    """One of the three bounds is met somewhere, and with time the speed."""
    dt = way.seconds / 4096
    p = np.array([way.travelled(k * dt) for k in range(4097)])
    v = np.diff(p) / dt
    long = way.speed**2 / way.acceleration + way.speed * way.acceleration / way.jerk
    if way.distance > 1.01 * long and way.speed > way.acceleration**2 / way.jerk:
        assert v.max() == pytest.approx(way.speed, rel=1e-6)
    assert v.max() <= way.speed * (1.0 + 1e-9)
    # Symmetric: half of it in half the time.
    assert way.travelled(0.5 * way.seconds) == pytest.approx(0.5 * way.distance)


def test_the_retreat_s_way_is_at_its_speed_in_three_hundredths_of_a_second():
    way = SmoothWay(distance=0.08, speed=0.05, acceleration=2.5, jerk=250.0)
    assert way.mean_speed(0.03, DT) == pytest.approx(0.05, rel=1e-9)
    assert way.mean_speed(0.0, DT) > 0.0
    assert way.seconds == pytest.approx(0.08 / 0.05 + 0.03)


def test_no_way_takes_no_time():
    way = SmoothWay(distance=0.0, speed=0.05, acceleration=2.5, jerk=250.0)
    assert way.seconds == 0.0
    assert way.travelled(1.0) == 0.0


@pytest.mark.parametrize("name", ["distance", "speed", "acceleration", "jerk"])
@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_bounds_are_positive_and_finite(name, value):
    given = {"distance": 0.1, "speed": 0.1, "acceleration": 1.0, "jerk": 1.0}
    with pytest.raises(ValueError, match=f"{name} must be positive"):
        SmoothWay(**{**given, name: value})
