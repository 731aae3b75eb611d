"""Both guards as state machines: whatever comes, what leaves them keeps the limits."""

from dataclasses import replace
from math import hypot, inf, nan

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
)

from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.field.obstacles import ObstacleSet, Workspace, beta
from bath_drake.safety.canonical_command import (
    check_canonical_command,
    guarded_world,
)
from bath_drake.safety.facts import GuardFacts, present_reasons
from bath_drake.safety.guard_ticks import (
    CanonicalTick,
    JointTick,
    canonical_tick,
    joint_tick,
)
from bath_drake.safety.joint_command import (
    Emitted,
    JointRange,
    brake_step,
    can_brake,
    check_joint_command,
    retreat_step,
)
from bath_drake.safety.limits import GuardLimits
from bath_drake.safety.reasons import RESPONSES, Mode, Reason

LIMITS = GuardLimits()
DT = LIMITS.loop.period
JOINTS = JointRange(np.full(7, -0.3), np.full(7, 0.4))
# More examples than for a pure property: a path must be long to be interesting.
MANY = settings(max_examples=100, stateful_step_count=40, deadline=None)
# Sums of some hundred rounded steps, in rad and rad/s.
ROUNDED = 1e-9

anything = st.sampled_from([nan, inf, -inf, 1e300, -1e300, 1e9, 0.0, -1.0, 0.5, 1.0])
wrong_facts = st.fixed_dictionaries(
    {},
    optional={
        "invalid_share": anything,
        "frame_frozen": st.booleans(),
        "frame_stamp_bad": st.booleans(),
        "seen_through": anything,
        "body_found": st.booleans(),
        "body_lost": st.booleans(),
        "map_believed": st.booleans(),
        "body_speed": anything,
        "bodies": st.integers(0, 2),
        "surface_found": st.booleans(),
        "world_sound": st.booleans(),
        "joint_solution": st.booleans(),
        "condition_number": anything,
        "self_distance": st.none() | anything,
        "obstacle_distance": st.none() | anything,
        "nozzle_clearance": st.none() | anything,
        "command_age": anything,
        "wrench": st.tuples(*[anything] * 6),
        "wrench_stamp": anything,
        "loop_seconds": anything,
        "robot_stamp": st.none() | anything,
        "following_error": st.none() | anything,
        "normal_W": st.none() | st.tuples(*[anything] * 3),
        "frame_stamp": anything,
        "now": anything,
    },
)


class _Guarded(RuleBasedStateMachine):
    """What both have in common: facts, a clock, a reset, and the rules of the modes."""

    def __init__(self):
        super().__init__()
        self.now, self.reset = 0.0, False
        self.before = self.tick = None
        self.facts = None

    def well(self, **change):
        self.now += self.dt
        facts = {
            "now": self.now,
            "frame_stamp": self.now - 0.02,
            "normal_W": (0.0, 0.0, 1.0),
            "reset": self.reset,
        }
        return GuardFacts(**{**facts, **change})

    def proceed(self, facts):
        raise NotImplementedError

    def step(self, facts):
        self.before, self.facts = self.tick, facts
        self.proceed(facts)
        self.check_modes()

    def command_reasons(self):
        raise NotImplementedError

    def check_modes(self):
        """The rules of the modes; reasons are found anew, from the facts."""
        was, state = self.before.state, self.tick.state
        reasons = [
            *present_reasons(was.memory, self.facts, LIMITS),
            *self.command_reasons(),
        ]
        reasons = [reason for reason in reasons if reason is not Reason.NONE]
        modes = [RESPONSES[reason].mode for reason in reasons]
        rose = self.facts.reset and not was.reset
        if was.mode is Mode.STOP and state.mode is not Mode.STOP:
            assert rose
            assert state.mode is not Mode.PASS
        if Mode.STOP in modes:
            assert state.mode is Mode.STOP
        assert (state.present is Reason.NONE) == (not reasons)
        assert (state.reason is Reason.NONE) == (state.mode is Mode.PASS)
        if state.mode is Mode.PASS:
            assert not reasons
            assert was.mode in (Mode.PASS, Mode.HOLD)
            assert not state.locked_by
        if was.mode is Mode.RETREAT:
            assert state.mode is not Mode.PASS
        if any(not RESPONSES[reason].resumes for reason in reasons):
            assert state.locked_by
        elif was.locked_by and not rose:
            assert state.locked_by
            assert state.mode is not Mode.PASS

    @rule(change=wrong_facts)
    def something_is_wrong(self, change):
        self.step(self.well(**change))

    @rule(count=st.integers(1, 40))
    def all_is_well(self, count):
        for _ in range(count):
            self.step(self.well())

    @rule()
    def somebody_resets(self):
        self.reset = True
        self.step(self.well())
        self.reset = False


directions = st.lists(st.floats(-1.0, 1.0), min_size=7, max_size=7).map(np.array)
wild_commands = st.lists(anything | st.floats(-2.0, 2.0), min_size=14, max_size=14).map(
    np.array
)
jacobians = st.integers(0, 5).map(
    lambda seed: np.random.default_rng(seed).normal(size=(6, 7))
) | st.sampled_from([np.full((6, 7), nan), np.zeros((6, 7)), 0.1 * np.eye(6, 7)])


class JointGuardMachine(_Guarded):
    dt = DT

    @initialize(at=st.sampled_from([-0.29, 0.0, 0.39]), jacobian=jacobians)
    def begin(self, at, jacobian):
        self.tick = JointTick(emitted=Emitted.at_rest(np.full(7, at)))
        self.jacobian = self.used = jacobian
        self.command = self.tick.emitted.vector()

    def proceed(self, facts):
        self.used, self.used_before = self.jacobian, self.used
        self.tick = joint_tick(
            self.tick,
            self.command,
            self.jacobian,
            facts,
            joints=JOINTS,
            dt=DT,
            limits=LIMITS,
        )

    def checked(self):
        return check_joint_command(
            self.command,
            self.used,
            self.before.emitted,
            joints=JOINTS,
            dt=DT,
            limits=LIMITS,
        )

    def command_reasons(self):
        return [self.checked().reason]

    @rule(
        direction=directions,
        speed=st.sampled_from([0.05, 1.0, 4.0]),
        n=st.integers(1, 40),
    )
    def a_command_moves_on(self, direction, speed, n):
        for _ in range(n):
            v = speed * direction
            q = self.tick.emitted.q + DT * v
            self.command = np.concatenate([q, v])
            self.step(self.well())

    @rule(command=wild_commands)
    def a_command_is_wild(self, command):
        self.command = command
        self.step(self.well())

    @rule(offset=directions, scale=st.sampled_from([0.01, 0.05, 1.0]))
    def a_command_is_beside(self, offset, scale):
        q = self.tick.emitted.q + scale * offset
        self.command = np.concatenate([q, np.zeros(7)])
        self.step(self.well())

    @rule(jacobian=jacobians)
    def the_arm_is_elsewhere(self, jacobian):
        self.jacobian = jacobian

    @precondition(lambda self: self.before is not None)
    @invariant()
    def no_state_emits_an_unchecked_command(self):
        emitted, last = self.tick.emitted, self.before.emitted
        mode = self.tick.state.mode
        if mode is Mode.PASS:
            expected = self.checked().emitted
        elif mode is Mode.RETREAT:
            normal = self.tick.state.normal_W
            expected = retreat_step(
                self.used,
                normal,
                last,
                seconds=self.tick.state.retreated,
                joints=JOINTS,
                dt=DT,
                limits=LIMITS,
            ).emitted
        else:
            expected = None
        expected = expected or brake_step(last, dt=DT, limits=LIMITS)
        np.testing.assert_array_equal(emitted.vector(), expected.vector())

    @precondition(lambda self: self.before is not None)
    @invariant()
    def the_limits_are_kept(self):
        emitted, last = self.tick.emitted, self.before.emitted
        assert np.isfinite(emitted.vector()).all()
        assert (np.abs(emitted.v) <= np.array(LIMITS.joints.velocity) + ROUNDED).all()
        change = DT * np.array(LIMITS.joints.acceleration)
        assert (np.abs(emitted.v - last.v) <= change + ROUNDED).all()
        np.testing.assert_allclose(emitted.q, last.q + DT * emitted.v, atol=ROUNDED)
        assert (emitted.q >= JOINTS.low - ROUNDED).all()
        assert (emitted.q <= JOINTS.high + ROUNDED).all()
        assert can_brake(emitted, JOINTS, LIMITS, ROUNDED)

    @precondition(lambda self: self.before is not None)
    @invariant()
    def a_tip_that_is_slow_stays_slow_while_it_passes(self):
        # Braking takes each joint as fast as it can, whatever the tip does meanwhile.
        if self.tick.state.mode is Mode.PASS and self.used is self.used_before:
            tip, before = (
                np.linalg.norm(self.used[3:] @ tick.emitted.v)
                for tick in (self.tick, self.before)
            )
            assert tip <= max(LIMITS.nozzle.speed, before) + ROUNDED


FIELD = NavigationField(
    workspace=Workspace(np.zeros(2), np.array([1.3, 1.0]), 4),
    goal=np.array([0.9, 0.0]),
    kappa=6.0,
    obstacles=ObstacleSet(
        np.array([[0.0, 0.1, 0.3, 0.1, 0.4], [-0.5, -0.5, 0.15, 0.15, 0.0]])
    ),
)
AREAS = {
    "none": ObstacleSet(),
    "one": ObstacleSet(np.array([[0.4, -0.4, 0.2, 0.1, 1.0]])),
    "under the start": ObstacleSet(np.array([[-0.8, 0.2, 0.2, 0.2, 0.0]])),
}
WORLDS = {
    name: guarded_world(FIELD, areas, LIMITS.canonical.margin)
    for name, areas in AREAS.items()
}
EXTENTS = np.array([0.18, 0.24])
pairs = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)).map(np.array)


class CanonicalGuardMachine(_Guarded):
    dt = 0.01

    @initialize()
    def begin(self):
        self.tick = CanonicalTick()
        self.point, self.velocity = np.array([-0.8, 0.2]), np.array([0.3, 0.0])
        self.areas = "none"

    def proceed(self, facts):
        self.start, self.asked = self.point, self.velocity
        self.world = WORLDS[self.areas]
        self.tick = canonical_tick(
            self.tick,
            self.velocity,
            self.point,
            facts,
            world=self.world,
            half_extents=EXTENTS,
            dt=self.dt,
            limits=LIMITS,
        )
        self.point = self.point + self.dt * self.tick.velocity

    def checked(self):
        return check_canonical_command(
            self.asked,
            self.start,
            self.before.velocity,
            world=self.world,
            half_extents=EXTENTS,
            condition_number=self.facts.condition_number,
            dt=self.dt,
            limits=LIMITS,
        )

    def command_reasons(self):
        return [self.checked().reason]

    @rule(direction=pairs, speed=st.sampled_from([0.1, 0.5, 5.0]), n=st.integers(1, 30))
    def it_is_driven(self, direction, speed, n):
        self.velocity = speed * direction
        for _ in range(n):
            self.step(self.well())

    @rule(velocity=st.tuples(anything, anything).map(np.array))
    def the_field_is_wild(self, velocity):
        self.velocity = velocity
        self.step(self.well())
        self.velocity = np.array([0.3, 0.0])

    @rule(name=st.sampled_from(sorted(AREAS)))
    def the_areas_change(self, name):
        self.areas = name
        self.step(self.well())

    @precondition(lambda self: self.before is not None)
    @invariant()
    def only_a_checked_velocity_passes(self):
        v = self.tick.velocity
        assert np.isfinite(v).all()
        if self.tick.state.mode is not Mode.PASS:
            np.testing.assert_array_equal(v, np.zeros(2))
            return
        np.testing.assert_array_equal(v, self.checked().velocity)
        if not v.any():
            return
        # Of what was asked for, and no more; to rounding of one product.
        along = float(v @ self.asked)
        assert along > 0.0
        assert abs(along - hypot(*v) * hypot(*self.asked)) < 1e-12 * along + 1e-300
        assert hypot(*v) <= hypot(*self.asked) * (1.0 + 1e-12)

    @precondition(lambda self: self.before is not None)
    @invariant()
    def speeds_are_kept_and_only_slowing_down_is_sudden(self):
        v, last = self.tick.velocity, self.before.velocity
        assert hypot(*v) <= LIMITS.canonical.speed * (1.0 + 1e-12)
        assert hypot(*(EXTENTS * v)) <= LIMITS.canonical.skin_speed * (1.0 + 1e-12)
        change = self.dt * LIMITS.canonical.acceleration
        slower = v.any() and hypot(*v) < hypot(*last)
        if v.any() and not slower:
            assert hypot(*(v - last)) <= change + 1e-12

    @precondition(lambda self: self.before is not None)
    @invariant()
    def the_point_enters_no_obstacle_by_itself(self):
        if not self.tick.velocity.any():
            return
        share = np.linspace(0.0, 1.0, 9)[:, None]
        way = self.start + share * (self.point - self.start)
        assert (min_beta(way, FIELD.with_obstacles(AREAS[self.areas])) > 0.0).all()
        # Where it had the margin it keeps it; 1e-12 of N is rounding.
        if _clearance(self.start, self.areas) > LIMITS.canonical.margin * 1.5:
            worst = min(_clearance(point, self.areas) for point in way)
            assert worst >= LIMITS.canonical.margin - 1e-6


def _clearance(point, areas):
    """Distance to the nearest ellipse, from its boundary's points, from above."""
    everything = FIELD.obstacles + AREAS[areas]
    away = np.linalg.norm(everything.boundary(720) - point, axis=-1).min()
    inside = (beta(point, everything) < 0.0).any()
    # From above by less than the square of a quarter of the spacing over the distance.
    return -away if inside else away


TestJointGuard = JointGuardMachine.TestCase
TestJointGuard.settings = MANY
TestJointGuard.pytestmark = [pytest.mark.slow]
TestCanonicalGuard = CanonicalGuardMachine.TestCase
TestCanonicalGuard.settings = MANY
TestCanonicalGuard.pytestmark = [pytest.mark.slow]


def test_a_state_of_the_guard_is_a_value_that_compares():
    tick = JointTick(emitted=Emitted.at_rest(np.zeros(7)))
    assert replace(tick.state) == tick.state
