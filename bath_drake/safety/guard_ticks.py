"""One tick of each guard: check the command, decide, emit. All that is pure of them."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.notation import FloatArray
from bath_drake.safety.canonical_command import GuardedWorld, check_canonical_command
from bath_drake.safety.facts import GuardFacts
from bath_drake.safety.guard import GuardState, guard_step
from bath_drake.safety.joint_command import (
    CheckedJoints,
    Emitted,
    JointRange,
    brake_step,
    check_joint_command,
    retreat_step,
)
from bath_drake.safety.limits import GuardLimits
from bath_drake.safety.reasons import Mode, Reason
from bath_drake.shared import Shared


@dataclass(frozen=True, kw_only=True, eq=False)
class CanonicalTick(Shared):
    """State of the guard of the canonical velocity, and what it emits.

    Attributes:
        state: The guard's memory.
        velocity: (2,) emitted, 1/s.
        limited: At how many ticks it passed less than was asked for.
    """

    state: GuardState = field(default_factory=GuardState)
    velocity: FloatArray = field(default_factory=lambda: np.zeros(2))
    limited: int = 0


def canonical_tick(
    before: CanonicalTick,
    velocity: ArrayLike,
    point: ArrayLike,
    facts: GuardFacts,
    *,
    world: GuardedWorld,
    half_extents: ArrayLike,
    dt: float,
    limits: GuardLimits,
) -> CanonicalTick:
    """The next tick; unless it passes, the point stands still.

    Arguments are those of `check_canonical_command` and `guard_step`.
    """
    checked = check_canonical_command(
        velocity,
        point,
        before.velocity,
        world=world,
        half_extents=half_extents,
        condition_number=facts.condition_number,
        dt=dt,
        limits=limits,
    )
    state, decision = guard_step(
        before.state, _with_report(facts, checked.reason), limits
    )
    if decision.mode is not Mode.PASS:
        return CanonicalTick(state=state, limited=before.limited)
    return CanonicalTick(
        state=state,
        velocity=checked.velocity,
        limited=before.limited + checked.limited,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class JointTick(Shared):
    """State of the guard of the joint command, and what it emits.

    Attributes:
        emitted: What the robot is told.
        state: The guard's memory.
        limited: At how many ticks it passed less than was asked for.
    """

    emitted: Emitted
    state: GuardState = field(default_factory=GuardState)
    limited: int = 0


def joint_tick(
    before: JointTick,
    command: ArrayLike,
    jacobian: ArrayLike,
    facts: GuardFacts,
    *,
    joints: JointRange,
    dt: float,
    limits: GuardLimits,
) -> JointTick:
    """The next tick. HOLD and STOP brake, RETREAT goes along the normal or brakes.

    Args:
        before: The last tick.
        command: (14,) q, v to follow.
        jacobian: (6, 7) of the nozzle at the last emitted position, in W; where it is
            none, all that is left is to brake.
        facts: What is known now.
        joints: The range of the positions, the margin taken off.
        dt: The step, s.
        limits: What to keep to.
    """
    last = before.emitted
    checked = check_joint_command(
        command, jacobian, last, joints=joints, dt=dt, limits=limits
    )
    state, decision = guard_step(
        before.state, _with_report(facts, checked.reason), limits
    )
    if decision.mode is Mode.RETREAT:
        checked = CheckedJoints(None, decision.reason)
        if decision.normal_W is not None:
            checked = retreat_step(
                jacobian,
                decision.normal_W,
                last,
                seconds=state.retreated,
                joints=joints,
                dt=dt,
                limits=limits,
            )
    elif decision.mode is not Mode.PASS:
        checked = CheckedJoints(None, decision.reason)
    if checked.emitted is None:
        slower = brake_step(last, dt=dt, limits=limits)
        return JointTick(emitted=slower, state=state, limited=before.limited)
    limited = before.limited + (checked.limited and decision.mode is Mode.PASS)
    return JointTick(emitted=checked.emitted, state=state, limited=limited)


def _with_report(facts: GuardFacts, reason: Reason) -> GuardFacts:
    if reason is Reason.NONE:
        return facts
    return replace(facts, reported=(*facts.reported, reason))
