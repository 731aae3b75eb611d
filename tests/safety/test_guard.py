"""The guard's decision, reason by reason and rule by rule."""

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.safety.facts import GuardFacts, Memory, remember
from bath_drake.safety.guard import GuardState, gravest, guard_step
from bath_drake.safety.limits import GuardLimits, retreat_way
from bath_drake.safety.reasons import RESPONSES, Mode, Reason

LIMITS = GuardLimits()
NORMAL = (0.0, -1.0, 0.0)
# A third of a camera period: the step of the tests' ticks, s.
DT = 0.01
DWELL = LIMITS.loop.resume_time
# Every fact that is wrong, and the reason it is.
WRONG = [
    ({"frame_stamp": -inf}, Reason.NO_FRAME),
    ({"frame_stamp": nan}, Reason.NO_FRAME),
    ({"invalid_share": 0.31}, Reason.FRAME_INVALID),
    ({"frame_stamp": -0.11}, Reason.FRAME_STALE),
    ({"frame_stamp": -0.51}, Reason.FRAME_LOST),
    ({"frame_stamp": 0.02}, Reason.FRAME_STAMP),
    ({"frame_frozen": True}, Reason.FRAME_FROZEN),
    ({"frame_stamp_bad": True}, Reason.FRAME_STAMP),
    ({"seen_through": 0.016}, Reason.CAMERA_ASTRAY),
    ({"seen_through": nan}, Reason.CAMERA_ASTRAY),
    ({"body_found": False}, Reason.BODY_HIDDEN),
    ({"body_found": False, "body_lost": True}, Reason.BODY_LOST),
    ({"map_believed": False}, Reason.BODY_JUMPED),
    ({"body_speed": 0.13}, Reason.BODY_FAST),
    ({"bodies": 2}, Reason.BODY_AMBIGUOUS),
    ({"surface_found": False}, Reason.SURFACE_UNSEEN),
    ({"world_sound": False}, Reason.WORLD_UNSOUND),
    ({"command_age": 0.11}, Reason.COMMAND_STALE),
    ({"condition_number": 30.1}, Reason.SINGULAR),
    ({"joint_solution": False}, Reason.NO_JOINT_SOLUTION),
    ({"self_distance": 0.029}, Reason.SELF_COLLISION),
    ({"obstacle_distance": 0.019}, Reason.LINK_NEAR),
    ({"nozzle_clearance": 0.039}, Reason.SKIN_NEAR),
    ({"nozzle_clearance": nan}, Reason.SKIN_NEAR),
    ({"wrench": (0.0, 0.0, 0.0, 15.1, 0.0, 0.0)}, Reason.FORCE_HIGH),
    ({"wrench": (0.0, 0.0, 0.0, 18.0, 18.0, 0.0)}, Reason.FORCE_STOP),
    ({"wrench": (0.0, nan, 0.0, 1.0, 0.0, 0.0)}, Reason.FORCE_SENSOR),
    ({"wrench": (0.0,) * 6, "wrench_stamp": -0.06}, Reason.FORCE_SENSOR),
    ({"loop_seconds": 0.011}, Reason.OVERRUN),
    ({"robot_stamp": -0.021}, Reason.LINK_LOST),
    ({"robot_stamp": nan}, Reason.LINK_LOST),
    ({"following_error": 0.021}, Reason.ARM_ASTRAY),
    ({"following_error": nan}, Reason.ARM_ASTRAY),
    ({"now": nan}, Reason.CLOCK),
    ({"body_speed": nan}, Reason.FACT_NOT_FINITE),
    ({"condition_number": nan}, Reason.FACT_NOT_FINITE),
    ({"invalid_share": nan}, Reason.FACT_NOT_FINITE),
    ({"self_distance": nan}, Reason.FACT_NOT_FINITE),
    ({"obstacle_distance": nan}, Reason.FACT_NOT_FINITE),
    ({"loop_seconds": inf}, Reason.FACT_NOT_FINITE),
    ({"command_age": nan}, Reason.FACT_NOT_FINITE),
    ({"reported": (Reason.COMMAND_JUMP,)}, Reason.COMMAND_JUMP),
]
# What a command's own check reports.
REPORTED = {
    Reason.TRAPPED,
    Reason.POINT_NOT_FREE,
    Reason.AREA_ENTERED,
    Reason.CLEARANCE,
    Reason.COMMAND_NOT_FINITE,
    Reason.COMMAND_JUMP,
    Reason.JOINT_LIMIT,
}


class Run:
    """A guard that is told facts tick by tick; stamps in them count from now."""

    def __init__(self):
        self.state, self.now = GuardState(), 0.0
        self.decision = None

    def tick(self, **change):
        self.now += DT
        well = {"now": 0.0, "frame_stamp": 0.0, "wrench_stamp": 0.0}
        facts = {**well, "normal_W": NORMAL, **change}
        for name in ("now", "frame_stamp", "wrench_stamp", "robot_stamp"):
            if facts.get(name) is not None:
                facts[name] += self.now
        self.state, self.decision = guard_step(self.state, GuardFacts(**facts), LIMITS)
        return self.decision.mode

    def ticks(self, seconds, **change):
        return [self.tick(**change) for _ in range(round(seconds / DT))]


@pytest.fixture
def run():
    run = Run()
    run.ticks(DWELL + 2 * DT)
    assert run.decision.mode is Mode.PASS
    return run


def test_every_reason_has_its_response_and_only_holds_resume_by_themselves():
    assert set(RESPONSES) == set(Reason)
    for reason, response in RESPONSES.items():
        if response.mode is Mode.PASS:
            assert reason is Reason.NONE
        elif response.mode is not Mode.HOLD:
            assert not response.resumes


def test_every_reason_is_seen_in_a_fact_or_reported_by_a_check():
    seen = {reason for _, reason in WRONG}
    assert seen | REPORTED | {Reason.NONE} == set(Reason)


def test_before_anything_is_known_it_holds():
    run = Run()
    assert run.tick() is Mode.HOLD
    assert run.decision.reason is Reason.NO_FRAME


@pytest.mark.parametrize(("change", "reason"), WRONG)
def test_each_fault_leads_to_its_mode_with_its_reason(run, change, reason):
    # As if no frame had come yet: one that is older than the last is another reason.
    run.state = replace(run.state, memory=Memory(now=run.now))
    mode = run.tick(**change)
    assert mode is RESPONSES[reason].mode
    assert run.decision.reason is reason
    assert run.state.counts[reason] == 1.0


def test_a_camera_that_falls_silent_is_lost(run):
    assert run.tick(frame_stamp=-inf) is Mode.RETREAT
    assert run.decision.reason is Reason.FRAME_LOST


def test_a_stamp_that_goes_back_holds_until_it_has_caught_up(run):
    assert run.tick(frame_stamp=-5 * DT) is Mode.HOLD
    assert run.decision.reason is Reason.FRAME_STAMP
    # Stamps go on from there, and are still of before the latest.
    run.ticks(3 * DT, frame_stamp=-5 * DT)
    assert run.state.present is Reason.FRAME_STAMP
    run.tick(frame_stamp=-5 * DT)
    assert run.state.present is Reason.NONE


def test_a_stamp_of_the_future_is_not_remembered():
    after = remember(Memory(), GuardFacts(now=1.0, frame_stamp=9.0))
    assert after.frame_stamp == -inf


def test_a_clock_that_goes_back_holds_until_a_reset(run):
    assert run.tick(now=-0.5) is Mode.HOLD
    assert run.decision.reason is Reason.CLOCK
    # The clock of the last tick counts from now on; it is well but locked.
    assert set(run.ticks(2 * DWELL)) == {Mode.HOLD}


def test_the_same_force_for_long_is_a_dead_sensor_but_zero_is_not(run):
    wrench = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    modes = run.ticks(LIMITS.force.frozen_time + 3 * DT, wrench=wrench)
    assert modes[0] is Mode.PASS
    assert modes[-1] is Mode.RETREAT
    assert run.decision.reason is Reason.FORCE_SENSOR
    other = Run()
    assert other.ticks(2 * DWELL + 1.0, wrench=(0.0,) * 6)[-1] is Mode.PASS


@pytest.mark.parametrize("reason", [r for r in Reason if RESPONSES[r].mode == 1])
def test_a_hold_resumes_after_the_dwell_time_only_where_its_reason_says_so(run, reason):
    run.tick(reported=(reason,))
    modes = run.ticks(DWELL - DT)
    assert set(modes) == {Mode.HOLD}
    assert run.decision.reason is reason
    expected = Mode.PASS if RESPONSES[reason].resumes else Mode.HOLD
    assert run.ticks(3 * DT)[-1] is expected
    assert run.tick(reset=True) is not Mode.STOP
    # Well for the dwell time already: after the reset nothing more is waited for.
    assert run.decision.mode is Mode.PASS


def test_one_tick_that_is_not_well_begins_the_dwell_anew(run):
    run.tick(surface_found=False)
    run.ticks(DWELL - 2 * DT)
    run.tick(surface_found=False)
    assert set(run.ticks(DWELL - 2 * DT)) == {Mode.HOLD}


def test_a_reason_that_needs_a_reset_is_not_forgotten_under_one_that_does_not(run):
    run.tick(reported=(Reason.COMMAND_NOT_FINITE,))
    run.tick(surface_found=False)
    assert run.decision.reason is Reason.SURFACE_UNSEEN
    assert set(run.ticks(3 * DWELL)) == {Mode.HOLD}
    # What is shown then is what the reset is for.
    assert run.decision.reason is Reason.COMMAND_NOT_FINITE


def test_a_stop_is_left_by_a_reset_alone_and_leads_to_a_hold(run):
    assert run.tick(robot_stamp=-1.0) is Mode.STOP
    assert set(run.ticks(2.0)) == {Mode.STOP}
    assert run.decision.reason is Reason.LINK_LOST
    assert run.tick(reset=True) is Mode.HOLD
    assert run.ticks(DWELL + DT, reset=True)[-1] is Mode.PASS


def test_a_reset_does_not_end_a_stop_whose_reason_is_still_there(run):
    run.tick(robot_stamp=-1.0)
    assert run.tick(robot_stamp=-1.0, reset=True) is Mode.STOP
    assert set(run.ticks(1.0, reset=True)) == {Mode.STOP}  # a level is no rise


def test_a_reset_held_from_the_start_is_none():
    run = Run()
    run.tick(reset=True, robot_stamp=-1.0)
    assert set(run.ticks(1.0, reset=True)) == {Mode.STOP}


def test_a_retreat_goes_its_whole_way_and_ends_in_a_hold_that_needs_a_reset(run):
    assert run.tick(body_speed=1.0) is Mode.RETREAT
    way = retreat_way(LIMITS).seconds
    modes = run.ticks(way - 2 * DT)
    assert set(modes) == {Mode.RETREAT}  # though all is well again
    assert run.decision.normal_W == NORMAL
    assert run.ticks(1.0 + 4 * DT)[-1] is Mode.HOLD
    assert run.decision.reason is Reason.BODY_FAST
    assert run.tick(reset=True) is Mode.PASS


def test_a_reset_during_a_retreat_does_not_shorten_it_nor_skip_the_hold(run):
    run.tick(body_speed=1.0)
    run.tick(reset=True)
    way = retreat_way(LIMITS).seconds
    modes = run.ticks(way + 0.1)
    first = modes.index(Mode.HOLD)
    assert set(modes[:first]) == {Mode.RETREAT}
    assert modes[first + 1] is Mode.PASS


def test_the_way_of_a_retreat_is_given_once_between_two_passes(run):
    run.ticks(2.0, body_speed=1.0)
    assert run.decision.mode is Mode.HOLD
    run.ticks(0.1)
    assert run.tick(body_speed=1.0) is Mode.HOLD
    run.tick(reset=True)
    run.ticks(DWELL + DT)
    assert run.decision.mode is Mode.PASS
    assert run.tick(body_speed=1.0) is Mode.RETREAT


def test_without_a_normal_there_is_no_way_to_retreat_and_it_holds():
    run = Run()
    run.ticks(DWELL + 2 * DT, normal_W=None)
    assert run.tick(normal_W=None, body_speed=1.0) is Mode.HOLD
    assert run.decision.reason is Reason.BODY_FAST


@pytest.mark.parametrize("bad", [(nan, 0.0, 0.0), (0.0, 0.0, 0.0), (2.0, 0.0, 0.0)])
def test_the_way_to_retreat_is_the_last_normal_that_was_one(run, bad):
    assert run.tick(normal_W=bad, body_speed=1.0) is Mode.RETREAT
    assert run.decision.normal_W == NORMAL


def test_the_gravest_of_several_reasons_decides(run):
    run.tick(surface_found=False, body_speed=1.0, robot_stamp=-1.0)
    assert run.decision.reason is Reason.LINK_LOST
    assert gravest([Reason.SURFACE_UNSEEN, Reason.BODY_FAST]) is Reason.BODY_FAST
    assert gravest([]) is Reason.NONE


def test_the_present_reason_is_gone_as_soon_as_all_is_well(run):
    run.tick(surface_found=False)
    assert run.state.present is Reason.SURFACE_UNSEEN
    run.tick()
    assert run.state.present is Reason.NONE
    assert run.decision.reason is Reason.SURFACE_UNSEEN


def test_a_reason_is_counted_when_it_begins_and_not_at_every_tick(run):
    run.ticks(0.1, surface_found=False)
    run.ticks(2 * DWELL)
    run.ticks(0.1, surface_found=False)
    expected = np.zeros(len(Reason))
    expected[Reason.SURFACE_UNSEEN] = 2.0
    np.testing.assert_array_equal(run.state.counts, expected)


numbers = st.floats(allow_nan=True, allow_infinity=True)


@given(
    facts=st.builds(
        GuardFacts,
        now=numbers,
        frame_stamp=numbers,
        invalid_share=numbers,
        seen_through=numbers,
        body_speed=numbers,
        bodies=st.integers(0, 3),
        condition_number=numbers,
        self_distance=st.none() | numbers,
        obstacle_distance=st.none() | numbers,
        nozzle_clearance=st.none() | numbers,
        command_age=numbers,
        wrench=st.none() | st.tuples(*[numbers] * 6),
        wrench_stamp=numbers,
        loop_seconds=numbers,
        robot_stamp=st.none() | numbers,
        following_error=st.none() | numbers,
    )
)
def test_whatever_is_measured_it_passes_only_what_is_well_in_every_point(facts):
    passing = replace(
        GuardState(), mode=Mode.PASS, reason=Reason.NONE, memory=Memory(now=0.0)
    )
    _, decision = guard_step(passing, facts, LIMITS)
    if decision.mode is not Mode.PASS:
        return
    # 1e-9 s: the rounding of stamps that the decision itself allows.
    assert -1e-9 <= facts.now - facts.frame_stamp <= LIMITS.frames.hold_age + 1e-9
    assert facts.invalid_share <= LIMITS.frames.invalid_share
    assert facts.body_speed <= LIMITS.frames.body_speed
    assert facts.bodies == 1
    assert facts.seen_through <= LIMITS.frames.seen_through
    assert facts.condition_number <= LIMITS.joints.condition_stop
    assert facts.command_age <= LIMITS.frames.hold_age + 1e-9
    if facts.wrench is not None:
        assert np.hypot.reduce(facts.wrench[3:]) <= LIMITS.force.retreat
        assert np.isfinite(facts.wrench).all()
    if facts.robot_stamp is not None:
        assert facts.now - facts.robot_stamp <= LIMITS.loop.link_age + 1e-9
    if facts.following_error is not None:
        assert facts.following_error <= LIMITS.joints.following
