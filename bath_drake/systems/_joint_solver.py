"""Joint velocities by Drake's differential IK, within limits that change.

At most steps no limit binds. The velocity is then the solution of linear equations: it
is looked for first, in a tenth of the time that Drake's quadratic program takes.
"""

from typing import Any

import numpy as np
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsParameters,
    DifferentialInverseKinematicsStatus,
    DoDifferentialInverseKinematics,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from bath_drake.control._joint_velocities import FREE, solve
from bath_drake.control.avoidance import (
    AvoidanceConfig,
    bend,
    damped_share,
    push_away,
    reachable_share,
)
from bath_drake.control.pose_tracking import across_jet
from bath_drake.notation import FloatArray
from bath_drake.safety._joint_steps import stopping_speeds
from bath_drake.systems._ports import drake_vector
from bath_drake.systems.nozzle_kinematics import NOZZLE_FRAME

# Of a twist in E, all but the turn about the jet: a round one has no roll.
_FOLLOWED = np.array([0, 1, 3, 4, 5])
_ORIGIN = drake_vector(np.zeros(3))


class JointSolver:
    """The seven joints' velocities for a velocity of the nozzle, one step at a time.

    It remembers nothing of what it is asked: what it keeps are Drake's parameters, told
    anew only where they change.
    """

    def __init__(
        self,
        *,
        plant: MultibodyPlant,
        limits: tuple[FloatArray, FloatArray],
        posture: FloatArray,
        time_step: float,
        speed_fraction: float,
        acceleration: float,
        centering_gain: float,
        avoidance: AvoidanceConfig,
    ) -> None:
        """Takes the arm and its limits.

        Args:
            plant: The arm alone, finalised, seven positions.
            limits: Least and greatest positions (7,), rad.
            posture: (7,) what the null space is drawn to, rad.
            time_step: s.
            speed_fraction: Of each joint's speed limit, in (0, 1].
            acceleration: Bound on each joint's velocity, rad/s^2.
            centering_gain: Pull to the posture in the null space, 1/s.
            avoidance: When and how hard links are kept off things.
        """
        self._plant = plant
        self._frame = plant.GetFrameByName(NOZZLE_FRAME)
        # A scratch pad, written before every use: it remembers nothing.
        self._scratch = plant.CreateDefaultContext()
        self._time_step = time_step
        self._acceleration = acceleration
        self._posture = self._nominal = posture
        self._centering_gain = centering_gain
        self._avoidance = avoidance
        self._range = self._admitted = limits
        self._speed = speed_fraction * np.array(plant.GetVelocityUpperLimits())
        self._speeds, self._told = (self._speed, self._speed), b""
        self._unbounded, self._parameters = (
            _parameters(plant, posture, limits, time_step, self._speed, centering_gain)
            for _ in range(2)
        )
        bound = drake_vector(np.full(7, acceleration))
        self._parameters.set_joint_acceleration_limits((-bound, bound))

    def nozzle(self, q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Returns rotation (3, 3) and origin (3,), m, of the nozzle in W.

        `solve` and `twist` are then of these positions q and velocities v (7,).
        """
        self._plant.SetPositions(self._scratch, drake_vector(q))
        self._plant.SetVelocities(self._scratch, drake_vector(v))
        X_WE = self._frame.CalcPoseInWorld(self._scratch)
        return np.array(X_WE.rotation().matrix()), np.array(X_WE.translation())

    def solve(
        self,
        q: FloatArray,
        v: FloatArray,
        twist: FloatArray,
        R_WE: FloatArray,
        near: FloatArray | None,
    ) -> FloatArray | None:
        """Returns the next joint velocities (7,), rad/s, or None where there are none.

        Args:
            q: (7,) positions now, rad.
            v: (7,) velocities now, rad/s.
            twist: (6,) of the nozzle, rad/s and m/s in W.
            R_WE: (3, 3) the nozzle's rotation, of `nozzle`.
            near: Rows of `link_gaps` of what a link is near to; None for nothing.
        """
        self._admit(q)
        self._push(near)
        J = self._followed_jacobian()
        found = self._unhindered(q, v, J, (twist.reshape(2, 3) @ R_WE).ravel())
        if found is None:
            found = self._solve(v, twist)
        return found if found is None or near is None else self._off(found, v, J, near)

    def twist(self, v: FloatArray, R_WE: FloatArray) -> FloatArray:
        """Returns the nozzle's (6,) in W without its turn about the jet."""
        self._plant.SetVelocities(self._scratch, drake_vector(v))
        V_WE = self._frame.CalcSpatialVelocityInWorld(self._scratch)
        return across_jet(drake_vector(V_WE.get_coeffs()), R_WE)

    def _admit(self, q: FloatArray) -> None:
        """Widens the range to a position (7,) that was taken over, as far as it is.

        From beyond a limit no motion within it begins, not even the one back.
        """
        low, high = self._range
        inside = self._slow_down(q)
        if self._admitted is self._range and inside:
            return
        admitted = np.minimum(low, q), np.maximum(high, q)
        if np.array_equal(admitted, self._admitted):
            return
        self._admitted = (
            self._range if np.array_equal(admitted, self._range) else admitted
        )
        limits = drake_vector(admitted[0]), drake_vector(admitted[1])
        for parameters in (self._parameters, self._unbounded):
            parameters.set_joint_position_limits(limits)

    def _slow_down(self, q: FloatArray) -> bool:
        """Bounds the speed towards each end of the range by what stops there.

        Returns:
            Whether the position (7,) is within the range.
        """
        low, high = self._range
        speeds, inside = stopping_speeds(
            q, low, high, self._speed, self._acceleration, self._time_step
        )
        told = speeds.tobytes()
        if told != self._told:
            self._told, self._speeds = told, (speeds[0], speeds[1])
            limits = drake_vector(-speeds[0]), drake_vector(speeds[1])
            for parameters in (self._parameters, self._unbounded):
                parameters.set_joint_velocity_limits(limits)
        return bool(inside)

    def _unhindered(
        self, q: FloatArray, v_last: FloatArray, J: FloatArray, V_E: FloatArray
    ) -> FloatArray | None:
        """What Drake would say (7,) where no limit is in the way, else None."""
        low, high = self._bounds(v_last)
        # Taken over beyond an end of its range, a joint may go no further.
        least, most = self._admitted
        low = np.maximum(low, (least - q) / self._time_step)
        high = np.minimum(high, (most - q) / self._time_step)
        v = np.empty(7)
        pull = self._centering_gain * (self._nominal - q)
        if solve(J, V_E[_FOLLOWED], pull, low, high, v) != FREE:
            return None
        return v if np.isfinite(v).all() else None

    def _bounds(self, v_last: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Least and greatest velocities (7,) by speed and acceleration, rad/s."""
        (slowest, fastest), most = self._speeds, self._acceleration * self._time_step
        return (
            np.maximum(-slowest, v_last - most),
            np.minimum(fastest, v_last + most),
        )

    def _off(
        self, v: FloatArray, v_last: FloatArray, J: FloatArray, rows: FloatArray
    ) -> FloatArray:
        """Bends the null space of v (7,), and slows it, to keep the links off."""
        most, added = self._acceleration * self._time_step, np.zeros(7)
        if damped_share(v, rows, self._avoidance) < 1.0:
            added = bend(v, J, rows, self._avoidance)
        low, high = self._bounds(v_last)
        v = v + reachable_share(v, added, low, high) * added
        change = v * damped_share(v, rows, self._avoidance) - v_last
        bound = np.full(7, most)
        return v_last + reachable_share(np.zeros(7), change, -bound, bound) * change

    def _followed_jacobian(self) -> FloatArray:
        """The nozzle's (5, 7) in E, the turn about the jet left out."""
        world: Any = self._plant.world_frame()
        J = np.array(
            self._plant.CalcJacobianSpatialVelocity(
                self._scratch,
                JacobianWrtVariable.kV,
                self._frame,
                _ORIGIN,
                world,
                self._frame,
            )
        )
        return np.asarray(J[_FOLLOWED])

    def _push(self, rows: FloatArray | None) -> None:
        """Draws the null space away from near things, on top of the posture."""
        nominal = self._posture
        if rows is not None:
            push = push_away(rows, self._avoidance)
            nominal = nominal + push / self._centering_gain
        if nominal is self._nominal or np.array_equal(nominal, self._nominal):
            return
        self._nominal = nominal
        for parameters in (self._parameters, self._unbounded):
            parameters.set_nominal_joint_position(drake_vector(nominal))

    def _solve(self, v_last: FloatArray, twist: FloatArray) -> FloatArray | None:
        """Returns joint velocities (7,), or None where there are none."""
        v = self._ask_drake(twist, self._parameters)
        if v is None:
            # No velocity along the twist may lie within the acceleration bound;
            # then go as far to the one beyond it as the bound allows.
            v = self._ask_drake(twist, self._unbounded)
            if v is not None:
                change = np.abs(v - v_last).max()
                share = min(1.0, self._acceleration * self._time_step / change)
                v = v_last + share * (v - v_last)
        return v

    def _ask_drake(
        self, twist: FloatArray, parameters: DifferentialInverseKinematicsParameters
    ) -> FloatArray | None:
        # Of Drake's stubs some give it types, some none.
        solve: Any = DoDifferentialInverseKinematics
        result = solve(
            self._plant, self._scratch, drake_vector(twist), self._frame, parameters
        )
        if result.status != DifferentialInverseKinematicsStatus.kSolutionFound:
            return None
        v = np.array(result.joint_velocities, dtype=np.float64)
        return v if np.isfinite(v).all() else None


def _parameters(
    plant: MultibodyPlant,
    posture: FloatArray,
    limits: tuple[FloatArray, FloatArray],
    time_step: float,
    speed: FloatArray,
    centering_gain: float,
) -> DifferentialInverseKinematicsParameters:
    parameters = DifferentialInverseKinematicsParameters(7, 7)
    parameters.set_time_step(time_step)
    parameters.set_nominal_joint_position(drake_vector(posture))
    # The turn about the jet is left to the posture.
    flags: Any = np.isin(np.arange(6), _FOLLOWED)
    parameters.set_end_effector_velocity_flag(flags)
    low, high = limits
    parameters.set_joint_position_limits((drake_vector(low), drake_vector(high)))
    parameters.set_joint_velocity_limits((drake_vector(-speed), drake_vector(speed)))
    parameters.set_joint_centering_gain(drake_vector(centering_gain * np.eye(7)))
    return parameters
