"""What the guard is told at a tick, what it remembers of it, and what is wrong with it.

Every comparison is written so that what is not a number counts as wrong.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import hypot, inf, isfinite

from bath_drake.safety.limits import GuardLimits
from bath_drake.safety.reasons import Reason

# Stamps in steps of a period accumulate rounding, s.
ROUNDING = 1e-9

# A body that too little has been seen of for so long, s, is lost; until then it is
# hidden, by an arm that passes.
LOST_TIME = 0.1

Vector = tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class GuardFacts:
    """What is known at one tick; a default is what stands for "nobody watches this".

    Attributes:
        now: The time, s.
        frame_stamp: When the newest frame was taken, s; not finite before the first.
        invalid_share: Of its pixels.
        frame_frozen: Whether the camera gives one frame again and again.
        frame_stamp_bad: Whether a frame's stamp went back or is none.
        seen_through: Share of the arm's pixels that show what is behind it.
        body_found: Whether enough of the back is in sight.
        body_lost: Whether it has not been for longer than something passing by takes.
        map_believed: Whether the map is where a body can have come to.
        body_speed: Of the skin under the nozzle, m/s.
        bodies: How many people are in sight.
        surface_found: Whether the skin under the nozzle is seen well.
        world_sound: Whether the world is proved free of traps.
        joint_solution: Whether inverse kinematics found a motion.
        condition_number: Of the nozzle's Jacobian.
        self_distance: Least distance of links that must not touch, m.
        obstacle_distance: Of links from person, stool and pedestal, m.
        nozzle_clearance: Of the nozzle off the skin, m; infinite where no skin is seen.
        command_age: How old the command is, s.
        wrench: Torque (N m) and force (N) on the nozzle, six numbers.
        wrench_stamp: When it was measured, s.
        loop_seconds: What the last control tick took, s.
        robot_stamp: When the robot last answered, s.
        following_error: The most that a joint is off what the guard emitted, rad.
        normal_W: Outward normal of the skin, unit, in W: the way to retreat.
        reset: The level of the operator's reset.
        reported: What another check says: that of the command, or another guard's.
    """

    now: float
    frame_stamp: float
    invalid_share: float = 0.0
    frame_frozen: bool = False
    frame_stamp_bad: bool = False
    seen_through: float = 0.0
    body_found: bool = True
    body_lost: bool = False
    map_believed: bool = True
    body_speed: float = 0.0
    bodies: int = 1
    surface_found: bool = True
    world_sound: bool = True
    joint_solution: bool = True
    condition_number: float = 1.0
    self_distance: float | None = None
    obstacle_distance: float | None = None
    nozzle_clearance: float | None = None
    command_age: float = 0.0
    wrench: Vector | None = None
    wrench_stamp: float = 0.0
    loop_seconds: float = 0.0
    robot_stamp: float | None = None
    following_error: float | None = None
    normal_W: Vector | None = None
    reset: bool = False
    reported: tuple[Reason, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Memory:
    """What later ticks are compared with.

    Attributes:
        now: Time of the last tick, s.
        frame_stamp: The latest stamp of a frame so far, s.
        wrench: The last one measured.
        wrench_changed: When it last became another one, s.
    """

    now: float = -inf
    frame_stamp: float = -inf
    wrench: Vector | None = None
    wrench_changed: float = -inf


def remember(memory: Memory, facts: GuardFacts) -> Memory:
    """The memory after a tick; times that are none, or of the future, are not kept."""
    now = facts.now if isfinite(facts.now) else memory.now
    # Before the first frame, and where it is not a number, its stamp says nothing.
    known = isfinite(facts.frame_stamp) and facts.frame_stamp <= now + ROUNDING
    stamp = facts.frame_stamp if known else -inf
    same = facts.wrench == memory.wrench
    return Memory(
        now=now,
        frame_stamp=max(memory.frame_stamp, stamp),
        wrench=facts.wrench,
        wrench_changed=memory.wrench_changed if same else now,
    )


def present_reasons(
    memory: Memory, facts: GuardFacts, limits: GuardLimits
) -> Iterator[Reason]:
    """Every reason there is not to pass; NaN is always one."""
    yield from (reason for reason in facts.reported if reason is not Reason.NONE)
    if not isfinite(facts.now):
        # No age can be told: those of the last tick stand.
        yield Reason.CLOCK
        facts = replace(facts, now=memory.now)
    elif facts.now < memory.now:
        yield Reason.CLOCK
    yield from _frame_reasons(memory, facts, limits)
    yield from _force_reasons(memory, facts, limits)
    measured = (facts.body_speed, facts.condition_number, facts.invalid_share)
    further = (facts.command_age, facts.loop_seconds)
    distances = (facts.self_distance or 0.0, facts.obstacle_distance or 0.0)
    if not all(map(isfinite, measured + further + distances)):
        yield Reason.FACT_NOT_FINITE
    for bad, reason in (
        (not facts.body_found and facts.body_lost, Reason.BODY_LOST),
        (not facts.body_found and not facts.body_lost, Reason.BODY_HIDDEN),
        (not facts.map_believed, Reason.BODY_JUMPED),
        (facts.body_speed > limits.frames.body_speed, Reason.BODY_FAST),
        (facts.body_found and facts.bodies != 1, Reason.BODY_AMBIGUOUS),
        (not facts.surface_found, Reason.SURFACE_UNSEEN),
        (not facts.world_sound, Reason.WORLD_UNSOUND),
        (not facts.joint_solution, Reason.NO_JOINT_SOLUTION),
        (facts.condition_number > limits.joints.condition_stop, Reason.SINGULAR),
        (
            facts.self_distance is not None
            and facts.self_distance < limits.joints.self_distance,
            Reason.SELF_COLLISION,
        ),
        (
            facts.obstacle_distance is not None
            and not facts.obstacle_distance >= limits.joints.obstacle_distance,
            Reason.LINK_NEAR,
        ),
        (
            facts.nozzle_clearance is not None
            and not facts.nozzle_clearance >= limits.nozzle.clearance,
            Reason.SKIN_NEAR,
        ),
        (facts.command_age > limits.frames.hold_age + ROUNDING, Reason.COMMAND_STALE),
        (
            facts.loop_seconds > limits.loop.overrun * limits.loop.period + ROUNDING,
            Reason.OVERRUN,
        ),
        (
            facts.robot_stamp is not None
            and not _fresh(facts.robot_stamp, facts.now, limits.loop.link_age),
            Reason.LINK_LOST,
        ),
        (
            facts.following_error is not None
            and not facts.following_error <= limits.joints.following,
            Reason.ARM_ASTRAY,
        ),
    ):
        if bad:
            yield reason


def _fresh(stamp: float, now: float, age: float) -> bool:
    """Whether a stamp is not of the future and not too old; NaN never is."""
    return -ROUNDING <= now - stamp <= age + ROUNDING


def _frame_reasons(
    memory: Memory, facts: GuardFacts, limits: GuardLimits
) -> Iterator[Reason]:
    frames, stamp = limits.frames, facts.frame_stamp
    if not isfinite(stamp):
        # Of a camera that had spoken, no age can be told any more.
        yield Reason.FRAME_LOST if isfinite(memory.frame_stamp) else Reason.NO_FRAME
        return
    went_back = facts.frame_stamp_bad or stamp < memory.frame_stamp - ROUNDING
    if went_back or stamp > facts.now + ROUNDING:
        yield Reason.FRAME_STAMP
    if not facts.now - stamp <= frames.retreat_age + ROUNDING:
        yield Reason.FRAME_LOST
    elif not facts.now - stamp <= frames.hold_age + ROUNDING:
        yield Reason.FRAME_STALE
    if facts.invalid_share > frames.invalid_share:
        yield Reason.FRAME_INVALID
    if facts.frame_frozen:
        yield Reason.FRAME_FROZEN
    if not facts.seen_through <= frames.seen_through:
        yield Reason.CAMERA_ASTRAY


def _force_reasons(
    memory: Memory, facts: GuardFacts, limits: GuardLimits
) -> Iterator[Reason]:
    if facts.wrench is None:
        return
    force = limits.force
    # hypot: a square of a great number is infinite.
    size = hypot(*facts.wrench[3:])
    if size > force.stop:
        yield Reason.FORCE_STOP
    elif size > force.retreat:
        yield Reason.FORCE_HIGH
    # An exact zero is what a simulated sensor says off the skin, for as long as it is.
    frozen = (
        facts.wrench == memory.wrench
        and any(facts.wrench)
        and not facts.now - memory.wrench_changed <= force.frozen_time + ROUNDING
    )
    if (
        frozen
        or not all(map(isfinite, facts.wrench))
        or not _fresh(facts.wrench_stamp, facts.now, force.age)
    ):
        yield Reason.FORCE_SENSOR
