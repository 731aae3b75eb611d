import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.control.approach import (
    Approach,
    ApproachLimits,
    Phase,
    held,
    next_approach,
)

LIMITS = ApproachLimits()
DT = 0.01
FAR = Approach.far(LIMITS)
# m: sums and differences of numbers near 0.1.
ROUNDING = 1e-12
ERROR = st.floats(0.0, LIMITS.astray)


def at(phase, standoff):
    return Approach(phase=phase, standoff=standoff, begun=standoff)


@given(errors=st.lists(ERROR, max_size=300))
def test_near_its_place_the_standoff_only_falls_never_below_the_washing_one(errors):
    now = FAR
    for error in errors:
        after = next_approach(now, error, DT, LIMITS)
        assert after.phase >= now.phase
        assert LIMITS.standoff <= after.standoff <= now.standoff
        assert now.standoff - after.standoff <= LIMITS.speed * DT + ROUNDING
        now = after


@given(
    errors=st.lists(ERROR, min_size=350, max_size=350),
    speed=st.floats(0.005, 0.05),
    acceleration=st.floats(0.05, 1.0),
    jerk=st.floats(0.5, 20.0),
)
def test_on_the_way_down_speed_acceleration_and_jerk_are_bounded(
    errors, speed, acceleration, jerk
):
    limits = ApproachLimits(speed=speed, acceleration=acceleration, jerk=jerk)
    now, standoffs = FAR, [FAR.standoff] * 3
    for error in errors:
        now = next_approach(now, error, DT, limits)
        standoffs.append(now.standoff)
    # 1e-12 m of rounding, once and again divided by the step and up to eight times.
    for order, bound in ((1, speed), (2, acceleration), (3, jerk)):
        derivative = np.diff(standoffs, order) / DT**order
        rounding = 2**order * 1e-15 / DT**order
        assert np.abs(derivative).max() <= bound * (1.0 + 1e-9) + rounding


def test_it_comes_down_to_the_very_standoff_and_washes():
    now = next_approach(FAR, 0.0, DT, LIMITS)
    for _ in range(200):
        now = next_approach(now, 0.0, DT, LIMITS)
    assert now.standoff == LIMITS.standoff
    assert now.phase is Phase.WASH


def test_after_a_hold_it_goes_on_from_rest_where_it_was():
    now = FAR
    for _ in range(80):
        now = next_approach(now, 0.0, DT, LIMITS)
    assert LIMITS.standoff < now.standoff < LIMITS.far_standoff
    stood = held(now)
    assert (stood.phase, stood.standoff) == (now.phase, now.standoff)
    after = next_approach(stood, 0.0, DT, LIMITS)
    # One step's way of the jerk alone; at its speed it would be 0.5 mm.
    assert 0.0 < stood.standoff - after.standoff <= LIMITS.jerk * DT**3


def test_it_does_not_descend_before_it_has_lined_up():
    assert next_approach(FAR, 0.016, DT, LIMITS) == FAR


def test_it_washes_only_when_it_is_down_and_there():
    down = at(Phase.DESCEND, LIMITS.standoff)
    assert next_approach(down, 0.006, DT, LIMITS).phase is Phase.DESCEND
    assert next_approach(down, 0.004, DT, LIMITS).phase is Phase.WASH
    above = at(Phase.DESCEND, 0.1)
    assert next_approach(above, 0.0, DT, LIMITS).phase is Phase.DESCEND


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), float("inf")])
def test_limits_must_be_positive(speed):
    with pytest.raises(ValueError, match="speed must be"):
        ApproachLimits(speed=speed)


def test_far_is_not_nearer_than_near():
    with pytest.raises(ValueError, match="far_standoff"):
        ApproachLimits(far_standoff=0.05, standoff=0.06)


@pytest.mark.parametrize("phase", [Phase.DESCEND, Phase.WASH])
def test_a_nozzle_that_is_far_off_lines_up_anew_far_from_the_skin(phase):
    near = at(phase, LIMITS.standoff)
    here = next_approach(near, LIMITS.astray - 1e-6, DT, LIMITS)
    assert here.phase is phase
    assert next_approach(near, LIMITS.astray + 1e-6, DT, LIMITS) == FAR
