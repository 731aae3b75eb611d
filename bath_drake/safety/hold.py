"""When the robot must hold: the decision, apart from any system.

Holding means: keep the last joint command. It is the careful answer whenever
what the robot knows of the person is missing, old or too little.
"""

from enum import IntEnum
from math import isfinite


class HoldReason(IntEnum):
    """Why the robot holds; NONE lets it move. The value is the port's number."""

    NONE = 0
    NO_FRAME = 1
    STALE_FRAME = 2
    BODY_LOST = 3
    SURFACE_UNSEEN = 4
    NO_JOINT_SOLUTION = 5
    UNSOUND_WORLD = 6
    BODY_HIDDEN = 7
    BODY_JUMPED = 8


# Two camera periods of 33 ms pass by themselves; the third is one too many.
MAX_FRAME_AGE = 0.1

# A body that too little has been seen of for so long, s, is lost; until then it is
# hidden, by an arm that passes.
LOST_TIME = 0.1


def hold_reason(
    *,
    stamp: float,
    now: float,
    body_found: bool,
    body_lost: bool,
    map_believed: bool,
    surface_found: bool,
    joint_solution: bool,
    world_sound: bool,
    max_frame_age: float = MAX_FRAME_AGE,
) -> HoldReason:
    """Decides whether to hold, and why: the first reason that applies.

    Args:
        stamp: When the newest frame was taken, s; not finite before the first.
        now: The time, s. A frame from the future is as useless as an old one.
        body_found: Whether enough of the body is visible in the newest frame.
        body_lost: Whether it has not been for longer than something passing by takes.
        map_believed: Whether it is where a body can have come to since.
        surface_found: Whether the skin under the nozzle is.
        joint_solution: Whether inverse kinematics found a motion.
        world_sound: Whether the field with all sensed areas is proved free of traps.
        max_frame_age: Age above which a frame is stale, s.
    """
    # Time stamps in steps of a camera period accumulate rounding.
    rounding = 1e-9
    if not isfinite(stamp):
        return HoldReason.NO_FRAME
    if not -rounding <= now - stamp <= max_frame_age + rounding:
        return HoldReason.STALE_FRAME
    if not body_found:
        return HoldReason.BODY_LOST if body_lost else HoldReason.BODY_HIDDEN
    if not map_believed:
        return HoldReason.BODY_JUMPED
    if not surface_found:
        return HoldReason.SURFACE_UNSEEN
    if not world_sound:
        return HoldReason.UNSOUND_WORLD
    if not joint_solution:
        return HoldReason.NO_JOINT_SOLUTION
    return HoldReason.NONE
