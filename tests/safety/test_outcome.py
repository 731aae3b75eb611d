import pytest

from bath_drake.safety.outcome import LoopBounds, LoopOutcome, judge_loop

BOUNDS = LoopBounds(duration=10.0, goal_tolerance=0.02, min_clearance=0.02)
RUNNING = {
    "time": 5.0,
    "washing": True,
    "goal_distance": 0.5,
    "clearance": 0.06,
    "bounds": BOUNDS,
}


@pytest.mark.parametrize(
    ("change", "outcome"),
    [
        ({}, LoopOutcome.RUNNING),
        ({"goal_distance": 0.019}, LoopOutcome.GOAL_REACHED),
        ({"goal_distance": 0.019, "washing": False}, LoopOutcome.RUNNING),
        ({"time": 10.0}, LoopOutcome.TIMED_OUT),
        ({"clearance": 0.019}, LoopOutcome.TOO_CLOSE),
        # A violated bound is never covered up by arriving.
        ({"clearance": 0.019, "goal_distance": 0.0}, LoopOutcome.TOO_CLOSE),
    ],
)
def test_a_run_ends_for_one_of_three_reasons(change, outcome):
    assert judge_loop(**{**RUNNING, **change}) is outcome


def test_bounds_must_be_positive():
    with pytest.raises(ValueError, match="duration must be"):
        LoopBounds(duration=0.0)
