"""Why the guard does not let a command pass, what it does then, and what ends it."""

from dataclasses import dataclass
from enum import IntEnum
from types import MappingProxyType


class Mode(IntEnum):
    """What the guard does; the greater goes first. The value is the port's number."""

    PASS = 0
    HOLD = 1
    RETREAT = 2
    STOP = 3


class Reason(IntEnum):
    """Why; NONE lets pass. The value is the port's number."""

    NONE = 0
    NO_FRAME = 1
    FRAME_INVALID = 2
    FRAME_STALE = 3
    FRAME_LOST = 4
    FRAME_STAMP = 5
    FRAME_FROZEN = 6
    BODY_HIDDEN = 7
    BODY_LOST = 8
    BODY_JUMPED = 9
    BODY_FAST = 10
    BODY_AMBIGUOUS = 11
    SURFACE_UNSEEN = 12
    WORLD_UNSOUND = 13
    TRAPPED = 14
    POINT_NOT_FREE = 15
    AREA_ENTERED = 16
    CLEARANCE = 17
    COMMAND_NOT_FINITE = 18
    COMMAND_STALE = 19
    COMMAND_JUMP = 20
    JOINT_LIMIT = 21
    SINGULAR = 22
    NO_JOINT_SOLUTION = 23
    SELF_COLLISION = 24
    FORCE_HIGH = 25
    FORCE_STOP = 26
    FORCE_SENSOR = 27
    OVERRUN = 28
    LINK_LOST = 29
    CLOCK = 30
    FACT_NOT_FINITE = 31
    SKIN_NEAR = 32
    LINK_NEAR = 33
    ARM_ASTRAY = 34
    CAMERA_ASTRAY = 35


@dataclass(frozen=True)
class Response:
    """What a reason leads to.

    Attributes:
        mode: What the guard does.
        resumes: Whether it goes on by itself once all has been well for the dwell
            time. Never true of RETREAT and STOP: those ask for a reset.
        meaning: When the reason applies, in words.
    """

    mode: Mode
    resumes: bool
    meaning: str


def _holds(meaning: str) -> Response:
    return Response(Mode.HOLD, True, meaning)


def _holds_until_reset(meaning: str) -> Response:
    return Response(Mode.HOLD, False, meaning)


def _retreats(meaning: str) -> Response:
    return Response(Mode.RETREAT, False, meaning)


def _stops(meaning: str) -> Response:
    return Response(Mode.STOP, False, meaning)


RESPONSES = MappingProxyType(
    {
        Reason.NONE: Response(Mode.PASS, True, "all is well"),
        Reason.NO_FRAME: _holds("no frame has come yet, or its stamp is no number"),
        Reason.FRAME_INVALID: _holds("too many pixels of the frame say nothing"),
        Reason.FRAME_STALE: _holds("the newest frame is older than `frames.hold_age`"),
        Reason.FRAME_LOST: _retreats("... older than `frames.retreat_age`"),
        Reason.FRAME_STAMP: _holds("the frame's stamp went back or is of the future"),
        Reason.FRAME_FROZEN: _holds("the camera gives one frame again and again"),
        Reason.BODY_HIDDEN: _holds("too little of the back is in sight"),
        Reason.BODY_LOST: _holds(
            "... and has been for longer than a passing arm takes"
        ),
        Reason.BODY_JUMPED: _holds("the map is where no body can have come to"),
        Reason.BODY_FAST: _retreats("the body moves faster than the nozzle follows"),
        Reason.BODY_AMBIGUOUS: _holds_until_reset("not exactly one person is in sight"),
        Reason.SURFACE_UNSEEN: _holds("the skin under the nozzle is not seen well"),
        Reason.WORLD_UNSOUND: _holds("the world is not proved free of traps"),
        Reason.TRAPPED: _holds("no motion is asked for, away from the goal"),
        Reason.POINT_NOT_FREE: _holds("the point is in an obstacle or over the rim"),
        Reason.AREA_ENTERED: _retreats("the point is in a restricted area"),
        Reason.CLEARANCE: _holds("the step leaves free space, however slow"),
        Reason.COMMAND_NOT_FINITE: _holds_until_reset("the command holds no numbers"),
        Reason.COMMAND_STALE: _holds("the command is older than it may be"),
        Reason.COMMAND_JUMP: _holds("the command is too far from the last emitted one"),
        Reason.JOINT_LIMIT: _holds("the command is, or leads, too near a joint's end"),
        Reason.SINGULAR: _holds("the Jacobian's condition number is too great"),
        Reason.NO_JOINT_SOLUTION: _holds("inverse kinematics found no motion"),
        Reason.SELF_COLLISION: _holds_until_reset("links come too near to each other"),
        Reason.FORCE_HIGH: _retreats("the contact force is above `force.retreat`"),
        Reason.FORCE_STOP: _stops("... above `force.stop`"),
        Reason.FORCE_SENSOR: _retreats("the force is no number, old, or frozen"),
        Reason.OVERRUN: _holds("a control tick took too long"),
        Reason.LINK_LOST: _stops("the robot has not answered for `loop.link_age`"),
        Reason.CLOCK: _holds_until_reset("the time is no number or went back"),
        Reason.FACT_NOT_FINITE: _holds_until_reset("something measured is no number"),
        Reason.SKIN_NEAR: _retreats("the skin has come nearer than `nozzle.clearance`"),
        Reason.LINK_NEAR: _holds_until_reset(
            "a link comes too near to the person, the stool or the pedestal"
        ),
        Reason.ARM_ASTRAY: _stops("a joint is not where the guard has told it to be"),
        Reason.CAMERA_ASTRAY: _holds("the camera sees through the arm: it was knocked"),
    }
)
