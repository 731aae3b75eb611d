"""Differential inverse kinematics of the arm as a Drake system."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from bath_drake.control.approach import Phase
from bath_drake.control.avoidance import AvoidanceConfig
from bath_drake.control.pose_tracking import (
    TrackingConfig,
    gentler,
    is_pose,
    jet_difference,
    next_feed_forward,
    next_twist,
)
from bath_drake.control.skin_speed import WashedPoint
from bath_drake.notation import FloatArray
from bath_drake.safety.arm_chain import ArmChain
from bath_drake.safety.obstacle_distance import link_gaps
from bath_drake.safety.obstacles import Boxes
from bath_drake.safety.self_gaps import self_gaps
from bath_drake.systems._joint_solver import JointSolver
from bath_drake.systems._ports import drake_vector, eval_value, eval_vector, set_vector

STATUS_OK, STATUS_STUCK = 0.0, 1.0
# An enumeration's members take long to look up, and this is asked at every step.
_DESCEND = int(Phase.DESCEND)

# Layout of the discrete state: the command, then the tracking's memory.
_Q, _V = slice(0, 7), slice(7, 14)
_TWIST, _FEED_FORWARD = slice(14, 20), slice(20, 26)
_DESIRED = slice(26, 38)  # the last desired pose, rows of [R | p]; NaN-free
_SEEN, _STATUS, _FAILURES = 38, 39, 40
_ACCELERATION = slice(41, 47)  # of the twist
_SIZE = 47


class DifferentialIk(LeafSystem):
    """Turns a desired nozzle pose into joint commands, step by step.

    .. pydrake_system::

        name: DifferentialIk
        input_ports:
        - desired_nozzle_pose
        - hold
        - emitted_command (optional)
        - phase (optional)
        - standoff (optional)
        - surface_velocity (optional)
        - obstacles (optional)
        output_ports:
        - joint_command
        - ik_status

    `desired_nozzle_pose` is X_WE (RigidTransform); `hold` (1) above 0.5 keeps the
    last command, or takes over the positions of `emitted_command` (14), which is what
    the robot was told meanwhile. `joint_command` (14) is q, v for the plant's desired-
    state port; `ik_status` (1) is 0 ok, 1 stuck, no solution or no usable pose. While
    held, or without a usable pose or a solution, q stays and v is zero: nothing that is
    not finite ever leaves. Discrete state, updated with the period `time_step`.

    With `phase`, a `bath_drake.control.approach.Phase`, `standoff` (1), m, and the
    skin's own `surface_velocity` (6), rad/s and m/s in W, the washed point goes along
    the skin no faster than the tracking's `skin_speed`, from where it comes down on.

    The turn about the jet is not followed: a round jet has no roll, and free it keeps
    the wrist off its limits. Drake's DoDifferentialInverseKinematics keeps the
    direction of the wanted velocity and stays within joint limits (where none binds its
    solution is found without it); the pose error is turned into that velocity with a
    bounded gain, speed, acceleration and jerk. With `obstacles`
    (`bath_drake.safety.obstacles.Boxes` in the arm's base frame) the null space keeps
    the links off them, and no link nears one but slowly; see
    `bath_drake.control.avoidance`.
    """

    def __init__(
        self,
        *,
        plant: MultibodyPlant,
        home: FloatArray,
        posture: FloatArray | None = None,
        tracking: TrackingConfig | None = None,
        time_step: float = 0.005,
        joint_margin: float = 0.08,
        speed_fraction: float = 0.5,
        joint_acceleration: float = 20.0,
        centering_gain: float = 1.0,
        arm: ArmChain | None = None,
        avoidance: AvoidanceConfig | None = None,
    ) -> None:
        """Declares ports, state and the periodic update.

        Args:
            plant: The arm alone, finalised, seven positions.
            home: (7,) initial command, rad.
            posture: (7,) what the null space is drawn to, rad; None for `home`.
            tracking: Gains and limits of the pose tracking; None for the defaults.
            time_step: Period of the update, s.
            joint_margin: Kept from both ends of each joint's range, rad.
            speed_fraction: Of each joint's speed limit, in (0, 1].
            joint_acceleration: Bound on each joint's command, rad/s^2.
            centering_gain: Pull to the nominal posture in the null space, 1/s.
            arm: Its links, to keep them off `obstacles`; None minds none.
            avoidance: When and how hard; None for the defaults.

        Raises:
            ValueError: If a number is out of range or home outside the limits.
        """
        super().__init__()
        _check(
            time_step=time_step,
            speed_fraction=speed_fraction,
            joint_acceleration=joint_acceleration,
            centering_gain=centering_gain,
        )
        if plant.num_positions() != 7:
            raise ValueError(
                f"plant must have 7 positions, got {plant.num_positions()}"
            )
        if not speed_fraction <= 1.0:
            raise ValueError(f"speed_fraction must be at most 1, got {speed_fraction}")
        low = np.array(plant.GetPositionLowerLimits()) + joint_margin
        high = np.array(plant.GetPositionUpperLimits()) - joint_margin
        home = np.array(home, dtype=np.float64)
        posture = home if posture is None else np.array(posture, dtype=np.float64)
        for name, q in (("home", home), ("posture", posture)):
            if q.shape != (7,) or not ((q >= low) & (q <= high)).all():
                raise ValueError(
                    f"{name} must be 7 positions within {low.tolist()} and"
                    f" {high.tolist()}, got {q.tolist()}"
                )
        self._time_step = time_step
        self._tracking = TrackingConfig() if tracking is None else tracking
        self._arm = arm
        self._avoidance = AvoidanceConfig() if avoidance is None else avoidance
        self._solver = JointSolver(
            plant=plant,
            limits=(low, high),
            posture=posture,
            time_step=time_step,
            speed_fraction=speed_fraction,
            acceleration=joint_acceleration,
            centering_gain=centering_gain,
            avoidance=self._avoidance,
        )
        self._desired = self.DeclareAbstractInputPort(
            "desired_nozzle_pose", Value(RigidTransform())
        )
        self._hold = self.DeclareVectorInputPort("hold", 1)
        self._emitted = self.DeclareVectorInputPort("emitted_command", 14)
        self._phase = self.DeclareVectorInputPort("phase", 1)
        self._standoff = self.DeclareVectorInputPort("standoff", 1)
        self._surface_velocity = self.DeclareVectorInputPort("surface_velocity", 6)
        self._obstacles = self.DeclareAbstractInputPort("obstacles", Value(Boxes()))
        start = np.zeros(_SIZE)
        start[_Q] = home
        state = self.DeclareDiscreteState(drake_vector(start))
        self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.0, self._update)
        ticket = {self.discrete_state_ticket(state)}
        self.DeclareVectorOutputPort("joint_command", 14, self._calc_command, ticket)
        self.DeclareVectorOutputPort("ik_status", 1, self._calc_status, ticket)

    def failures(self, context: Context) -> int:
        """Returns how many updates found no usable pose or no solution."""
        return int(_state(context)[_FAILURES])

    def set_command(self, context: Context, q: FloatArray) -> None:
        """Puts the command (7,), rad, into this system's own `context`, at rest."""
        state = np.zeros(_SIZE)
        state[_Q] = q
        context.SetDiscreteState(drake_vector(state))

    def _update(self, context: Any, discrete_state: Any) -> None:
        state = _state(context)
        held = eval_vector(self._hold, context)[0] > 0.5
        X_WE = eval_value(self._desired, context, RigidTransform)
        R, p = np.array(X_WE.rotation().matrix()), np.array(X_WE.translation())
        if held:
            if self._emitted.HasValue(context):
                state[_Q] = eval_vector(self._emitted, context)[:7]
            state = _at_rest(state, STATUS_OK)
        elif not is_pose(R, p):
            state = _at_rest(state, STATUS_STUCK)
        else:
            rows = self._near_things(context, state[_Q])
            state = self._step(state, R, p, self._near_skin(context), rows)
        discrete_state.set_value(drake_vector(state))

    def _near_skin(self, context: Context) -> tuple[float, FloatArray] | None:
        """Stand-off and skin's own velocity; None while the nozzle is far away."""
        if not self._phase.HasValue(context):
            return None
        if eval_vector(self._phase, context)[0] < _DESCEND:
            return None
        (standoff,) = eval_vector(self._standoff, context)
        return standoff, eval_vector(self._surface_velocity, context)

    def _near_things(self, context: Any, q: FloatArray) -> FloatArray | None:
        """Rows of `link_gaps` of what a link is near to; None where nothing is."""
        if self._arm is None:
            return None
        # Links keep further off each other: their rows are told as much nearer.
        keep = self._avoidance
        further = keep.self_stop - keep.stop
        rows = self_gaps(q, self._arm, keep.near + further)
        rows[:, 0] -= further
        if self._obstacles.HasValue(context):
            boxes = eval_value(self._obstacles, context, Boxes)
            things = link_gaps(q, self._arm, boxes, 2.0 * keep.near)
            if (things[:, 0] < 2.0 * keep.near).any():
                rows = np.concatenate([things, rows])
        return rows if len(rows) else None

    def _step(
        self,
        state: FloatArray,
        R_d: FloatArray,
        p_d: FloatArray,
        near_skin: tuple[float, FloatArray] | None,
        rows: FloatArray | None,
    ) -> FloatArray:
        dt, tracking = self._time_step, self._tracking
        R, p = self._solver.nozzle(state[_Q], state[_V])
        feed_forward = np.zeros(6)
        if state[_SEEN] > 0.5:
            last = state[_DESIRED].reshape(3, 4)
            moved = jet_difference(last[:, :3], last[:, 3], R_d, p_d)
            feed_forward = next_feed_forward(state[_FEED_FORWARD], moved, tracking, dt)
        error = jet_difference(R, p, R_d, p_d)
        washed = None
        if near_skin is not None:
            washed = WashedPoint(near_skin[0] * R[:, 2], near_skin[1])
        twist, acceleration = next_twist(
            state[_TWIST],
            state[_ACCELERATION],
            error,
            feed_forward,
            tracking,
            dt,
            washed,
        )
        v = self._solver.solve(state[_Q], state[_V], twist, R, rows)
        if v is None:
            return _at_rest(state, STATUS_STUCK)
        after = state.copy()
        after[_Q] = state[_Q] + dt * v
        after[_V] = v
        # What the joints really do: the solver may have slowed the motion down. They
        # turn about the jet as they like.
        after[_TWIST] = self._solver.twist(v, R)
        done = (after[_TWIST] - state[_TWIST]) / dt
        after[_ACCELERATION] = gentler(acceleration, done)
        after[_FEED_FORWARD] = feed_forward
        after[_DESIRED] = np.column_stack([R_d, p_d]).ravel()
        after[_SEEN], after[_STATUS] = 1.0, STATUS_OK
        return after

    def _calc_command(self, context: Any, output: BasicVector) -> None:
        set_vector(output, _state(context)[: _V.stop])

    def _calc_status(self, context: Any, output: BasicVector) -> None:
        set_vector(output, [_state(context)[_STATUS]])


def _check(**positive: float) -> None:
    for name, value in positive.items():
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} must be positive and finite, got {value}")


def _state(context: Context) -> FloatArray:
    return np.array(context.get_discrete_state_vector().value(), dtype=np.float64)


def _at_rest(state: FloatArray, status: float) -> FloatArray:
    """The same joint positions, everything else forgotten."""
    rest = np.zeros(_SIZE)
    rest[_Q] = state[_Q]
    rest[_STATUS] = status
    rest[_FAILURES] = state[_FAILURES] + (status != STATUS_OK)
    return rest
