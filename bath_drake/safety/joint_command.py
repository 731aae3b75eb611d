"""Checks a joint command: finite, within positions, speeds and accelerations.

The guard emits positions and velocities of its own, which follow the command as far as
the limits let them. From what it emits it can always brake in time: at every tick each
joint's position plus its way to brake lies within the joint's range less the margin.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.notation import BoolArray, FloatArray
from bath_drake.safety._joint_steps import (
    catching_up,
    followed_rows,
    is_small,
    next_velocity,
    refusal,
    singular_value_ratio,
)
from bath_drake.safety.facts import Vector
from bath_drake.safety.limits import JOINTS, GuardLimits, retreat_way
from bath_drake.safety.reasons import Reason

# Damping of the Jacobian's inverse, of the size of its singular values near a
# singularity (m/rad, rad/rad).
_DAMPING = 0.05


@dataclass(frozen=True, eq=False)
class JointRange:
    """Positions between which the joints stay, rad, the margin taken off; (7,) each."""

    low: FloatArray
    high: FloatArray

    def __post_init__(self) -> None:
        """Raises ValueError unless both are 7 finite numbers and low is below high."""
        for name in ("low", "high"):
            value = np.array(getattr(self, name), dtype=np.float64)
            if value.shape != (JOINTS,) or not np.isfinite(value).all():
                raise ValueError(f"{name} must be {JOINTS} finite numbers, got {value}")
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        if not (self.low < self.high).all():
            raise ValueError(f"low must be below high, got {self.low} and {self.high}")


@dataclass(frozen=True, eq=False)
class Emitted:
    """What the robot was last told: positions (7,), rad, and velocities (7,), rad/s."""

    q: FloatArray
    v: FloatArray

    @staticmethod
    def at_rest(q: ArrayLike) -> "Emitted":
        """Standing at `q` (7,)."""
        return Emitted(np.array(q, dtype=np.float64), np.zeros(JOINTS))

    def vector(self) -> FloatArray:
        """(14,) q, v."""
        return np.concatenate([self.q, self.v])


@dataclass(frozen=True, eq=False)
class CheckedJoints:
    """What may be done of a command.

    Attributes:
        emitted: What to tell the robot next; None unless `reason` is NONE.
        reason: Why it must be held, or NONE.
        limited: Whether it was scaled.
    """

    emitted: Emitted | None
    reason: Reason
    limited: bool = False


def check_joint_command(
    command: ArrayLike,
    jacobian: ArrayLike,
    last: Emitted,
    *,
    joints: JointRange,
    dt: float,
    limits: GuardLimits,
) -> CheckedJoints:
    """Checks a command against what was emitted last.

    A command that is ahead by no more than `joints.jump` is caught up with; what would
    be too fast or too sudden is scaled, all joints by one share of the change, so that
    the direction of the change stays. Held are a command that is not finite, further
    ahead, out of the joints' range, or that no share of keeps the limits.

    Args:
        command: (14,) q in rad, v in rad/s.
        jacobian: (6, 7) of the nozzle at the last emitted position: angular rows
            (rad/rad) first, then the tip's (m/rad).
        last: What was emitted at the last tick.
        joints: The range, the margin taken off.
        dt: The step, s.
        limits: What to keep to.
    """
    wanted = np.asarray(command, dtype=np.float64)
    if wanted.shape != (2 * JOINTS,):
        return CheckedJoints(None, Reason.COMMAND_NOT_FINITE)
    q, v = wanted[:JOINTS], wanted[JOINTS:]
    reason = refusal(q, v, last.q, joints.low, joints.high, limits.joints.jump)
    if reason == Reason.COMMAND_NOT_FINITE:
        return CheckedJoints(None, Reason.COMMAND_NOT_FINITE)
    J = _plain(jacobian)
    if not _is_jacobian(J):
        return CheckedJoints(None, Reason.FACT_NOT_FINITE)
    if reason != Reason.NONE:
        return CheckedJoints(None, Reason(reason))
    acceleration = np.array(limits.joints.acceleration)
    to_follow = catching_up(q, v, last.q, acceleration, dt)
    return _towards(to_follow, J, last, joints, dt, limits)


def retreat_step(
    jacobian: ArrayLike,
    normal_W: Vector,
    last: Emitted,
    *,
    seconds: float,
    joints: JointRange,
    dt: float,
    limits: GuardLimits,
) -> CheckedJoints:
    """One step of the nozzle along the normal, without turning.

    The speed asked for out comes from nothing, smoothly, and what the nozzle did before
    is braked meanwhile as hard as the joints' limits allow.

    Args:
        jacobian: (6, 7) of the nozzle at the last emitted position: angular rows
            (rad/rad) first, then the tip's (m/rad), in W.
        normal_W: Outward, unit, in W.
        last: What was emitted at the last tick.
        seconds: For how long it has retreated, s.
        joints: The range, the margin taken off.
        dt: The step, s.
        limits: What to keep to.
    """
    J = _plain(jacobian)
    if not _is_jacobian(J):
        return CheckedJoints(None, Reason.FACT_NOT_FINITE)
    twist = np.zeros(6)
    twist[3:] = retreat_way(limits).mean_speed(seconds, dt) * np.array(normal_W)
    v = J.T @ np.linalg.solve(J @ J.T + _DAMPING**2 * np.eye(6), twist)
    return _towards(v, J, last, joints, dt, limits)


def brake_step(last: Emitted, *, dt: float, limits: GuardLimits) -> Emitted:
    """The next step to rest: every joint as slower as its acceleration allows."""
    change = dt * np.array(limits.joints.acceleration)
    v = np.sign(last.v) * np.maximum(np.abs(last.v) - change, 0.0)
    return Emitted(last.q + dt * v, v)


def condition_number(jacobian_W: ArrayLike, R_WE: ArrayLike) -> float:
    """Of the nozzle's five directions that are followed; not finite of what is none.

    Args:
        jacobian_W: (6, 7), angular rows (rad/rad) first, then the tip's (m/rad), in W.
            Radians and metres stand side by side, as the limits of this number have it.
        R_WE: (3, 3) the nozzle's axes: the turn about the jet, its z, is free and left
            out.
    """
    J, R = _plain(jacobian_W), _plain(R_WE)
    if not (_is_jacobian(J) and R.shape == (3, 3) and is_small(R)):
        return float("nan")
    return float(singular_value_ratio(followed_rows(J, R)))


def can_brake(
    emitted: Emitted, joints: JointRange, limits: GuardLimits, tolerance: float
) -> bool:
    """Whether every joint can stop within its range, to a tolerance in rad."""
    way = emitted.v * np.abs(emitted.v) / (2.0 * np.array(limits.joints.acceleration))
    stops = emitted.q + way
    inside: BoolArray = (stops >= joints.low - tolerance) & (
        stops <= joints.high + tolerance
    )
    return bool(inside.all())


def _plain(values: ArrayLike) -> FloatArray:
    """As the compiled steps take it: one layout, one compilation."""
    return np.ascontiguousarray(values, dtype=np.float64)


def _is_jacobian(J: FloatArray) -> bool:
    return J.shape == (6, JOINTS) and bool(is_small(J))


def _towards(
    v: FloatArray,
    J: FloatArray,
    last: Emitted,
    joints: JointRange,
    dt: float,
    limits: GuardLimits,
) -> CheckedJoints:
    """As far from the last velocity to `v` as the limits allow."""
    v_next, share = next_velocity(
        v,
        J,
        last.q,
        last.v,
        joints.low,
        joints.high,
        np.array(limits.joints.velocity),
        np.array(limits.joints.acceleration),
        limits.nozzle.speed,
        dt,
    )
    if share < 0.0:
        return CheckedJoints(None, Reason.JOINT_LIMIT)
    emitted = Emitted(last.q + dt * v_next, v_next)
    return CheckedJoints(emitted, Reason.NONE, limited=share < 1.0 - 1e-6)
