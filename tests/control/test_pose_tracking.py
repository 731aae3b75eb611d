import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bath_drake.control.pose_tracking import (
    TrackingConfig,
    across_jet,
    gentler,
    is_pose,
    jet_difference,
    limited,
    next_feed_forward,
    next_twist,
    together,
)

DT = 0.005
CONFIG = TrackingConfig()
NUMBER = st.floats(-4.0, 4.0)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER).map(np.array)
TWIST = st.lists(NUMBER, min_size=6, max_size=6).map(np.array)


class Follower:
    """A pose that does what `next_twist` commands."""

    def __init__(self, config=CONFIG):
        self.config = config
        self.R, self.p = np.eye(3), np.zeros(3)
        self.twist, self.feed_forward = np.zeros(6), np.zeros(6)
        self.acceleration = np.zeros(6)
        self.last = None

    def step(self, R, p):
        last = (R, p) if self.last is None else self.last
        self.feed_forward = next_feed_forward(
            self.feed_forward, jet_difference(*last, R, p), self.config, DT
        )
        self.last = R, p
        error = jet_difference(self.R, self.p, R, p)
        self.twist, self.acceleration = next_twist(
            self.twist, self.acceleration, error, self.feed_forward, self.config, DT
        )
        turn = Rotation.from_rotvec(DT * self.twist[:3]).as_matrix()
        self.R, self.p = turn @ self.R, self.p + DT * self.twist[3:]
        return jet_difference(self.R, self.p, R, p)


def test_only_rotations_with_finite_origins_are_poses():
    R = Rotation.from_rotvec([0.3, -1.0, 2.0]).as_matrix()
    assert is_pose(R, np.ones(3))
    assert not is_pose(R, np.array([0.0, np.nan, 0.0]))
    assert not is_pose(np.full((3, 3), np.nan), np.ones(3))
    assert not is_pose(1.001 * R, np.ones(3))
    assert not is_pose(np.diag([1.0, 1.0, -1.0]), np.ones(3))
    assert not is_pose(np.zeros((3, 3)), np.ones(3))


@given(twist=TWIST, angular=st.floats(0.01, 5.0), linear=st.floats(0.01, 5.0))
def test_limits_bound_each_part_and_keep_its_direction(twist, angular, linear):
    bounded = limited(twist, angular, linear)
    for part, bound in ((slice(0, 3), angular), (slice(3, 6), linear)):
        length = np.linalg.norm(bounded[part])
        assert length <= bound * (1.0 + 1e-12)
        # Parallel, and never turned round. 1e-12: rounding of numbers up to 50.
        assert np.linalg.norm(np.cross(bounded[part], twist[part])) < 1e-12
        assert bounded[part] @ twist[part] >= 0.0
        if np.linalg.norm(twist[part]) <= bound:
            np.testing.assert_array_equal(bounded[part], twist[part])


@given(twist=TWIST, angular=st.floats(0.01, 5.0), linear=st.floats(0.01, 5.0))
def test_together_both_parts_are_slowed_alike(twist, angular, linear):
    slowed = together(twist, angular, linear)
    # Rounding of one division and of a norm.
    assert np.linalg.norm(slowed[:3]) <= angular * (1.0 + 1e-12)
    assert np.linalg.norm(slowed[3:]) <= linear * (1.0 + 1e-12)
    share = np.linalg.norm(slowed) / max(np.linalg.norm(twist), 1e-300)
    np.testing.assert_allclose(slowed, share * twist, atol=1e-12)


def test_a_long_way_and_the_turn_on_it_end_together():
    follower = Follower()
    R = Rotation.from_rotvec([0.9, 0.0, 0.0]).as_matrix()
    p = np.array([0.0, 0.0, 0.3])
    for _ in range(2000):
        error = follower.step(R, p)
        if np.linalg.norm(error[3:]) < 0.15:
            break
    # Half way there it is half turned, but for what the acceleration's bounds cost.
    assert np.linalg.norm(error[:3]) == pytest.approx(0.45, abs=0.05)


PLACE = st.tuples(*3 * [st.floats(-0.3, 0.3)]).map(np.array)
RATE = st.tuples(*3 * [st.floats(-0.1, 0.1)]).map(np.array)


@given(
    targets=st.lists(st.tuples(PLACE, RATE, PLACE), min_size=1, max_size=4),
    ticks=st.integers(5, 60),
)
def test_speed_acceleration_and_jerk_are_bounded_whatever_the_pose_does(targets, ticks):
    """Targets jump, turn, and move off at up to 0.17 m/s."""
    follower = Follower()
    twists, accelerations = [np.zeros(6)], [np.zeros(6)]
    for place, rate, turn in targets:
        R = Rotation.from_rotvec(5.0 * turn).as_matrix()
        for k in range(ticks):
            follower.step(R, place + k * DT * rate)
            twists.append(follower.twist)
            accelerations.append(follower.acceleration)
    twists, accelerations = np.array(twists), np.array(accelerations)
    # 1e-9: what a sum of some hundred products is rounded by, over the step.
    np.testing.assert_allclose(
        np.diff(twists, axis=0) / DT, accelerations[1:], atol=1e-9
    )
    for part, names in (
        (slice(0, 3), ("angular_speed", "angular_acceleration", "angular_jerk")),
        (slice(3, 6), ("speed", "acceleration", "jerk")),
    ):
        jerks = np.diff(accelerations, axis=0) / DT
        for values, name in zip((twists, accelerations, jerks), names, strict=True):
            greatest = np.linalg.norm(values[:, part], axis=1).max()
            assert greatest <= getattr(CONFIG, name) * (1.0 + 1e-9), name


@given(previous=TWIST, acceleration=TWIST, error=TWIST)
def test_from_beyond_the_speed_limits_it_comes_back_within(
    previous, acceleration, error
):
    twist = previous
    for _ in range(2000):
        twist, acceleration = next_twist(
            twist, acceleration, error, np.zeros(6), CONFIG, DT
        )
    assert np.linalg.norm(twist[:3]) <= CONFIG.angular_speed * (1.0 + 1e-9)
    assert np.linalg.norm(twist[3:]) <= CONFIG.speed * (1.0 + 1e-9)


def test_of_what_was_asked_and_what_was_done_the_gentler_goes_on():
    asked = np.array([0.0, 2.0, 0.0, 1.0, 0.0, 0.0])
    done = np.array([0.0, 0.0, 3.0, 0.0, -0.5, 0.0])
    expected = np.array([0.0, 2.0, 0.0, 0.0, -0.5, 0.0])
    np.testing.assert_array_equal(gentler(asked, done), expected)


@pytest.mark.parametrize("gap", [1e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1])
def test_no_gap_is_overshot(gap):
    follower, target = Follower(), np.array([0.0, 0.0, gap])
    for _ in range(800):
        follower.step(np.eye(3), target)
        # A thousandth of it: where the speed comes down from its bound.
        assert follower.p[2] <= gap * 1.001
    assert follower.p[2] == pytest.approx(gap, abs=1e-9)


def test_a_pose_at_rest_is_reached_without_overshoot():
    follower = Follower()
    R = Rotation.from_rotvec([0.2, -0.1, 0.3]).as_matrix()
    p = np.array([0.1, -0.05, 0.02])
    distances = []
    for _ in range(800):
        error = follower.step(R, p)
        distances.append(np.linalg.norm(error[3:]))
        assert is_pose(follower.R, follower.p)
    # 4 s at a gain of 20/s leave exp(-20 * 2.5 s) after the limited part: nothing.
    np.testing.assert_allclose(error, np.zeros(6), atol=1e-6)
    # The acceleration's limit lets it pass by what it brakes over, well below a mm.
    nearest = int(np.argmin(distances))
    assert max(distances[nearest:]) < 1e-3


def test_a_small_error_falls_by_e_within_the_gains_time():
    gain, error = 20.0, np.array([1e-4, 0, 0, 0, 1e-4, 0])
    config = TrackingConfig(gain=gain)
    follower = Follower(config)
    R, p = Rotation.from_rotvec(error[:3]).as_matrix(), error[3:]
    for _ in range(round(1.0 / gain / DT)):
        left = follower.step(R, p)
    # Critically damped, the velocity's own lag of 1 / (4 gain) in it: (1 + 2) exp(-2)
    # is 0.406. 0.05: Euler's ten steps are some 2 % each.
    assert np.linalg.norm(left[3:]) / 1e-4 == pytest.approx(0.406, abs=0.05)
    assert np.linalg.norm(left[:3]) / 1e-4 == pytest.approx(0.406, abs=0.05)


def test_a_pose_that_moves_steadily_is_followed_without_a_lag():
    follower, velocity = Follower(), np.array([0.05, 0.0, 0.03])
    for k in range(1000):
        error = follower.step(np.eye(3), k * DT * velocity)
    # What is left is the one step that the follower is behind, at no more speed
    # than 0.06 m/s: 0.3 mm; without feed-forward it would be 0.06 / 20 = 3 mm.
    assert np.linalg.norm(error) < 0.06 * DT


def test_a_jump_is_no_velocity():
    jump = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    kick = next_feed_forward(np.zeros(6), jump, CONFIG, DT)
    share = DT / (CONFIG.feed_forward_time + DT)
    assert np.linalg.norm(kick) == pytest.approx(share * CONFIG.speed)


def test_the_feed_forward_takes_its_time_constant_to_come_in():
    steady = np.array([0.1, 0, 0, 0.02, 0, 0])
    value = np.zeros(6)
    for _ in range(round(CONFIG.feed_forward_time / DT)):
        value = next_feed_forward(value, DT * steady, CONFIG, DT)
    # Backward Euler with 16 steps a time constant: 1 - (1 + 1/16)^-16 = 0.621.
    np.testing.assert_allclose(value, (1.0 - (17 / 16) ** -16) * steady, atol=1e-12)


@pytest.mark.parametrize("name", vars(CONFIG))
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_gains_and_limits_must_be_positive(name, value):
    with pytest.raises(ValueError, match=f"{name} must be positive"):
        TrackingConfig(**{name: value})


TURN = st.tuples(*3 * [st.floats(-3.0, 3.0)]).map(np.array)


@given(first=TURN, second=TURN)
def test_the_jet_s_difference_takes_one_jet_to_the_other_and_turns_about_neither(
    first, second
):
    R, R_to = (Rotation.from_rotvec(turn).as_matrix() for turn in (first, second))
    difference = jet_difference(R, np.zeros(3), R_to, np.ones(3))
    turned = Rotation.from_rotvec(difference[:3]).as_matrix() @ R[:, 2]
    # A square root of rounding where the two are nearly one.
    np.testing.assert_allclose(turned, R_to[:, 2], atol=1e-7)
    assert abs(difference[:3] @ R[:, 2]) < 1e-9
    np.testing.assert_array_equal(difference[3:], np.ones(3))


def test_a_turn_about_the_jet_is_no_difference_and_a_half_turn_is_one():
    R = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()
    rolled = R @ Rotation.from_rotvec([0.0, 0.0, 2.0]).as_matrix()
    assert np.abs(jet_difference(R, np.zeros(3), rolled, np.zeros(3))).max() < 1e-9
    opposite = R @ np.diag([1.0, -1.0, -1.0])
    turn = jet_difference(R, np.zeros(3), opposite, np.zeros(3))[:3]
    assert np.linalg.norm(turn) == pytest.approx(np.pi)
    assert abs(turn @ R[:, 2]) < 1e-9


@given(turn=TURN)
def test_a_twist_across_the_jet_keeps_the_rest(turn):
    R = Rotation.from_rotvec(turn).as_matrix()
    twist = np.array([0.4, -1.0, 0.7, 0.1, 0.2, -0.3])
    left = across_jet(twist, R)
    assert abs(left[:3] @ R[:, 2]) < 1e-12
    np.testing.assert_allclose(np.cross(left[:3] - twist[:3], R[:, 2]), 0, atol=1e-12)
    np.testing.assert_array_equal(left[3:], twist[3:])
