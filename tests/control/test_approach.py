import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.control.approach import ApproachLimits, Phase, next_approach

LIMITS = ApproachLimits()


@given(errors=st.lists(st.floats(0.0, LIMITS.astray), max_size=300))
def test_near_its_place_the_standoff_only_falls_never_below_the_washing_one(errors):
    phase, standoff = Phase.REACH, LIMITS.far_standoff
    for error in errors:
        next_phase, lower = next_approach(phase, standoff, error, 0.01, LIMITS)
        assert next_phase >= phase
        assert LIMITS.standoff <= lower <= standoff
        # 1e-12 m: one subtraction of numbers near 0.1.
        assert standoff - lower <= LIMITS.speed * 0.01 + 1e-12
        phase, standoff = next_phase, lower


def test_it_does_not_descend_before_it_has_lined_up():
    assert next_approach(Phase.REACH, 0.14, 0.016, 0.01, LIMITS) == (Phase.REACH, 0.14)


def test_it_washes_only_when_it_is_down_and_there():
    down = LIMITS.standoff
    assert next_approach(Phase.DESCEND, down, 0.006, 0.01, LIMITS)[0] is Phase.DESCEND
    assert next_approach(Phase.DESCEND, down, 0.004, 0.01, LIMITS)[0] is Phase.WASH
    assert next_approach(Phase.DESCEND, 0.1, 0.0, 0.01, LIMITS)[0] is Phase.DESCEND


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), float("inf")])
def test_limits_must_be_positive(speed):
    with pytest.raises(ValueError, match="speed must be"):
        ApproachLimits(speed=speed)


def test_far_is_not_nearer_than_near():
    with pytest.raises(ValueError, match="far_standoff"):
        ApproachLimits(far_standoff=0.05, standoff=0.06)


@pytest.mark.parametrize("phase", [Phase.DESCEND, Phase.WASH])
def test_a_nozzle_that_is_far_off_lines_up_anew_far_from_the_skin(phase):
    limits = ApproachLimits()
    here = next_approach(phase, 0.06, limits.astray - 1e-6, 0.01, limits)
    assert here[0] is phase
    away = next_approach(phase, 0.06, limits.astray + 1e-6, 0.01, limits)
    assert away == (Phase.REACH, limits.far_standoff)
