"""The check of the joint command, the retreat and the brake."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from bath_drake.safety._joint_steps import (
    singular_value_ratio,
    stoppable,
    stopping_speeds,
)
from bath_drake.safety.joint_command import (
    Emitted,
    JointRange,
    brake_step,
    check_joint_command,
    condition_number,
    retreat_step,
)
from bath_drake.safety.limits import GuardLimits, retreat_way
from bath_drake.safety.reasons import Reason

LIMITS = GuardLimits()
DT = LIMITS.loop.period
JOINTS = JointRange(np.full(7, -1.0), np.full(7, 1.0))
REST = Emitted.at_rest(np.zeros(7))
GENTLE = np.full(7, 0.02)


# An arm whose tip hardly moves, so that the joints' own limits are what counts.
SHORT = 1e-3 * np.eye(6, 7)


def check(command, last=REST, jacobian=SHORT):
    return check_joint_command(
        command, jacobian, last, joints=JOINTS, dt=DT, limits=LIMITS
    )


def moved(v, last=REST):
    return np.concatenate([last.q + DT * v, v])


def follow(commands, last=REST):
    for command in commands:
        checked = check(command, last)
        assert checked.reason is Reason.NONE
        last = checked.emitted
    return last


def test_a_gentle_command_passes_to_the_last_digits():
    checked = check(moved(GENTLE))
    assert not checked.limited
    # One product and one sum away from what was asked for.
    np.testing.assert_allclose(checked.emitted.vector(), moved(GENTLE), rtol=1e-12)


@pytest.mark.parametrize(
    ("command", "reason"),
    [
        (np.full(14, np.nan), Reason.COMMAND_NOT_FINITE),
        (np.concatenate([np.zeros(13), [np.inf]]), Reason.COMMAND_NOT_FINITE),
        (np.zeros(13), Reason.COMMAND_NOT_FINITE),
        (np.concatenate([np.full(7, 1.01), np.zeros(7)]), Reason.JOINT_LIMIT),
        (np.concatenate([np.full(7, 0.06), np.zeros(7)]), Reason.COMMAND_JUMP),
        (np.concatenate([np.zeros(7), np.full(7, 1e300)]), Reason.COMMAND_JUMP),
    ],
)
def test_what_cannot_be_scaled_is_held_with_its_reason(command, reason):
    checked = check(command)
    assert checked.emitted is None
    assert checked.reason is reason


def test_too_sudden_a_command_is_scaled_and_keeps_its_direction():
    direction = np.array([0.5, -0.2, 0.1, 0.0, 0.3, -0.4, 0.05])
    checked = check(moved(direction))
    assert checked.limited
    v = checked.emitted.v
    assert np.abs(v).max() == pytest.approx(DT * 10.0, rel=1e-12)
    np.testing.assert_allclose(v / np.abs(v).max(), direction / 0.5, atol=1e-12)


def test_too_fast_a_command_is_followed_at_the_joints_speed():
    limits = np.array(LIMITS.joints.velocity)
    last = REST
    for _ in range(60):
        q = last.q + DT * 2.0 * limits
        last = check(np.concatenate([q, 2.0 * limits]), last).emitted
    # The limit itself is reached, and not passed but by rounding.
    assert (np.abs(last.v) / limits).max() == pytest.approx(1.0, abs=1e-9)


def test_the_tip_is_no_faster_than_it_may():
    v = np.full(7, 0.2)
    last = REST
    for _ in range(20):
        last = check(moved(v, last), last, jacobian()).emitted
    tip = np.linalg.norm(jacobian()[3:] @ last.v)
    assert np.linalg.norm(jacobian()[3:] @ v) > LIMITS.nozzle.speed
    # Reached from below, and no further but by rounding.
    assert tip == pytest.approx(LIMITS.nozzle.speed, rel=1e-9)


def test_without_a_jacobian_no_command_passes():
    checked = check(moved(GENTLE), jacobian=np.full((6, 7), np.nan))
    assert checked.reason is Reason.FACT_NOT_FINITE


def test_a_joint_at_its_speed_does_not_keep_another_from_turning_back():
    limits = np.array(LIMITS.joints.velocity)
    last = Emitted(np.zeros(7), np.concatenate([limits[:1], np.full(6, 0.1)]))
    back = np.concatenate([3.0 * limits[:1], np.full(6, -0.3)])
    after = follow([moved(back, last)], last)
    assert (after.v[1:] < 0.1).all()


def test_a_command_beside_is_caught_up_with_and_not_run_over():
    target = np.full(7, 0.04)
    last, largest = REST, 0.0
    for _ in range(100):
        last = check(np.concatenate([target, np.zeros(7)]), last).emitted
        largest = max(largest, float(last.q.max()))
    # The speed from which it stops there: it comes from one side, to rounding.
    assert largest <= 0.04 + 1e-12
    np.testing.assert_allclose(last.q, target, atol=1e-4)


def test_towards_the_end_of_the_range_it_brakes_in_time():
    last = Emitted(np.full(7, 0.93), np.zeros(7))
    for _ in range(200):
        q = np.minimum(last.q + DT * 1.0, 1.0)
        checked = check(np.concatenate([q, np.ones(7)]), last)
        step = checked.emitted or brake_step(last, dt=DT, limits=LIMITS)
        # 1e-12 rad: rounding.
        assert (step.q <= 1.0 + 1e-12).all()
        assert (np.abs(step.v - last.v) <= DT * 10.0 + 1e-12).all()
        last = step


def test_braking_ends_at_rest_within_the_way_it_is_said_to_take():
    last = Emitted(np.zeros(7), np.array([1.0, -1.0, 0.3, 0.0, 0.7, -0.2, 0.04]))
    start = last
    for _ in range(30):
        last = brake_step(last, dt=DT, limits=LIMITS)
    np.testing.assert_array_equal(last.v, np.zeros(7))
    way = start.v**2 / (2.0 * 10.0)
    assert (np.abs(last.q) <= way + 1e-12).all()


def test_from_the_stoppable_speed_a_step_and_the_brake_take_the_whole_way():
    way = np.array([0.0, 1e-6, 0.01, 1.0])
    v = np.array([stoppable(w, 10.0, DT) for w in way])
    # The root of a sum less a part of it: 1e-16 of 0.05 remains.
    np.testing.assert_allclose(DT * v + v**2 / 20.0, way, atol=1e-15)


def jacobian(seed=3):
    return np.random.default_rng(seed).normal(size=(6, 7))


UP = (0.0, 0.0, 1.0)


def retreated(last, ticks):
    """The tip's velocities (ticks + 1, 3) of an arm of one metre all over."""
    J, tips = np.eye(6, 7), []
    tips.append(J[3:] @ last.v)
    for k in range(ticks):
        last = retreat_step(
            J, UP, last, seconds=k * DT, joints=JOINTS, dt=DT, limits=LIMITS
        ).emitted
        tips.append(J[3:] @ last.v)
    return np.array(tips)


def test_a_retreat_begins_at_once_and_smoothly_and_ends_smoothly():
    way = retreat_way(LIMITS)
    ticks = int(np.ceil(way.seconds / DT))
    v = np.vstack([np.zeros((2, 3)), retreated(REST, ticks)])
    assert v[3, 2] > 0.0  # within the first tick
    acceleration = np.diff(v, axis=0) / DT
    jerk = np.diff(acceleration, axis=0) / DT
    # 1e-6: rounding over the step twice. At once it would be 0.05 / DT^2 = 2000.
    assert np.abs(acceleration).max() <= LIMITS.nozzle.retreat_acceleration + 1e-6
    assert np.abs(jerk).max() <= LIMITS.nozzle.retreat_jerk + 1e-6
    # The damped inverse goes a 400th slower.
    assert DT * v[:, 2].sum() == pytest.approx(way.distance, rel=0.003)
    assert v[-1, 2] == pytest.approx(0.0, abs=LIMITS.nozzle.retreat_jerk * DT**2)


def test_what_goes_in_is_braked_as_hard_as_the_joints_allow_when_it_retreats():
    towards = np.zeros(7)
    towards[5] = -0.1
    v = retreated(Emitted(np.zeros(7), towards), 4)[:, 2]
    hardest = -0.1 + DT * 10.0 * np.arange(3)
    # As hard as if it were held: smooth is what follows.
    np.testing.assert_allclose(v[:2], hardest[:2], atol=1e-12)
    assert v[2] >= -1e-12


def test_a_retreat_goes_along_the_normal_without_turning():
    normal = (0.0, 0.6, 0.8)
    last = REST
    for k in range(40):
        last = retreat_step(
            jacobian(),
            normal,
            last,
            seconds=k * DT,
            joints=JOINTS,
            dt=DT,
            limits=LIMITS,
        ).emitted
    twist = jacobian() @ last.v
    # The damping takes a little of the speed, and turns it by as little.
    speed = LIMITS.nozzle.approach_speed
    np.testing.assert_allclose(twist[3:], speed * np.array(normal), atol=0.05 * speed)
    np.testing.assert_allclose(twist[:3], 0.0, atol=0.002)


@pytest.mark.parametrize("bad", [np.full((6, 7), np.nan), np.full((6, 7), 1e300)])
def test_without_a_jacobian_there_is_no_step(bad):
    step = retreat_step(bad, UP, REST, seconds=0.1, joints=JOINTS, dt=DT, limits=LIMITS)
    assert step.emitted is None
    assert step.reason is Reason.FACT_NOT_FINITE


def test_at_a_singularity_a_retreat_stays_slow():
    flat = np.zeros((6, 7))
    flat[3, 0] = 1e-9
    step = retreat_step(
        flat, (1.0, 0.0, 0.0), REST, seconds=0.1, joints=JOINTS, dt=DT, limits=LIMITS
    )
    assert np.abs(step.emitted.v).max() < 1e-6


def test_the_condition_number_leaves_the_turn_about_the_jet_out():
    J = np.eye(6, 7)
    J[2] *= 1e-6
    assert condition_number(J, np.eye(3)) == pytest.approx(1.0)
    J[4] *= 0.1
    assert condition_number(J, np.eye(3)) == pytest.approx(10.0)
    assert np.isnan(condition_number(np.full((6, 7), np.inf), np.eye(3)))
    assert np.isnan(condition_number(J, np.full((3, 3), np.nan)))


def test_a_joint_goes_no_faster_than_what_stops_at_either_end_of_its_range():
    q = np.array([-1.0, -0.99, -0.5, 0.0, 0.9, 1.0, 1.1])
    low, high, speed = JOINTS.low, JOINTS.high, np.full(7, 1.5)
    speeds, inside = stopping_speeds(q, low, high, speed, 10.0, DT)
    assert not inside
    within = np.minimum(q, 1.0)
    assert stopping_speeds(within, low, high, speed, 10.0, DT)[1]
    for row, way in zip(speeds, (q - low, high - q), strict=True):
        slow = row < speed
        # One step at that speed, then the brake: the whole way, up to rounding.
        gone = DT * row + row**2 / 20.0
        np.testing.assert_allclose(gone[slow], np.maximum(way, 0.0)[slow], atol=1e-12)
        assert (gone <= np.maximum(way, 0.0) + 1e-12).all()


@given(turn=hnp.arrays(float, 3, elements=st.floats(-3.0, 3.0)))
def test_the_condition_number_is_the_same_however_the_nozzle_lies_in_the_world(turn):
    J_E = np.random.default_rng(1).normal(size=(6, 7))
    R_WE = Rotation.from_rotvec(turn).as_matrix()
    J_W = np.vstack([R_WE @ J_E[:3], R_WE @ J_E[3:]])
    expected = np.linalg.cond(J_E[[0, 1, 3, 4, 5]])
    # A dozen digits of numbers of order one.
    assert condition_number(J_W, R_WE) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize(
    ("low", "high"),
    [(np.zeros(6), np.ones(6)), (np.ones(7), np.zeros(7)), (np.full(7, np.nan),) * 2],
)
def test_a_range_is_seven_finite_numbers_in_order(low, high):
    with pytest.raises(ValueError, match="low"):
        JointRange(low, high)


@pytest.mark.parametrize("least", [1.0, 0.3, 1e-2, 1e-5])
def test_the_ratio_of_singular_values_is_what_lapack_says(least, rng):
    for _ in range(50):
        u, _ = np.linalg.qr(rng.normal(size=(5, 5)))
        v, _ = np.linalg.qr(rng.normal(size=(7, 7)))
        values = np.sort(rng.uniform(least, 1.0, size=5))
        values[0], values[-1] = least, 1.0
        rows = np.ascontiguousarray((u * values) @ v[:5])
        expected = np.linalg.cond(rows)
        # LAPACK's least value is good to the greatest's rounding.
        assert singular_value_ratio(rows) == pytest.approx(expected, rel=1e-14 / least)


def test_rows_that_say_the_same_are_as_good_as_singular(rng):
    rows = rng.normal(size=(5, 7))
    rows[3] = 2.0 * rows[1] - rows[0]
    assert singular_value_ratio(rows) > 1e14
    rows[3] = 0.0
    assert singular_value_ratio(rows) == np.inf
