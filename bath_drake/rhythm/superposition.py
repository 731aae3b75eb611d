"""The periodic motion on top of the discrete one, step by step.

The hand is at q + A (f(phi) + d): q the discrete motion's point, A in [0, 1] the share
of the cycle there is room for. A never exceeds room / (R + |d|), with the radius R of
the cycle and the radius of a free disc round q (`clearance`): so the sum is in that
disc. The whole cycle shrinks: circles stay circles.

Both motions keep the pace of the demonstrations, `pitch` of the discrete one to a
cycle; where their sum would be faster along the skin than it may, time runs slower
for both, and what is washed stays the same curve.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import FloatArray
from bath_drake.rhythm.clearance import clearance
from bath_drake.rhythm.limit_cycle import LimitCycle, decayed

# The cycles are gone this far before the goal, in N: the motion ends as the discrete
# one does, and nothing that swings is taken for an arrival.
SETTLED = 0.03
# The displacement of a step is nearly proportional to its time.
_ROUNDS = 6


@dataclass(frozen=True, eq=False)
class Rhythm:
    """Where the periodic motion is.

    Attributes:
        phase: rad.
        deviation: d, shape (2,), in N.
        share: A as far as the past goes: the cycle grows no faster than in a period.
        travelled: Length of the discrete motion so far, in N.
    """

    phase: float = 0.0
    deviation: FloatArray = field(default_factory=lambda: np.zeros(2))
    share: float = 0.0
    travelled: float = 0.0


@dataclass(frozen=True, eq=False)
class Room:
    """What the sum must not enter.

    Attributes:
        areas: Restricted ones, in N.
        workspace: Its rim is not crossed.
        half_box: See `clearance`.
        margin: Kept to all of them, in N.
    """

    areas: ObstacleSet
    workspace: Workspace
    half_box: float = 1.0
    margin: float = 0.0

    def around(self, q: FloatArray) -> float:
        """Radius of the free disc round `q`, the margin taken off."""
        free = clearance(q, self.areas, self.workspace, self.half_box)
        return max(0.0, free - self.margin)


@dataclass(frozen=True, eq=False)
class Pace:
    """How fast, and how far to go.

    Attributes:
        speed: Of the sum along the skin, at most, m/s.
        half_extents: Of the body, shape (2,), m.
        length: Expected length of the whole discrete motion, in N.
    """

    speed: float
    half_extents: FloatArray
    length: float


def offset(cycle: LimitCycle, rhythm: Rhythm, q: FloatArray, room: Room) -> FloatArray:
    """From the discrete motion's point `q` (2,) to the hand, shape (2,), in N."""
    share = min(rhythm.share, _fitting(cycle, rhythm.deviation, room.around(q)))
    return np.asarray(share * _whole(cycle, rhythm))


def advance(
    cycle: LimitCycle,
    rhythm: Rhythm,
    q: FloatArray,
    velocity: FloatArray,
    to_goal: float,
    room: Room,
    pace: Pace,
    dt: float,
) -> tuple[Rhythm, FloatArray]:
    """One step of both motions.

    Args:
        cycle: The periodic motion.
        rhythm: Where it is.
        q: Where the discrete motion is, shape (2,), in N.
        velocity: The discrete motion's by itself, shape (2,), 1/s.
        to_goal: Distance from `q` to the last goal, in N; infinite if another goal
            comes first.
        room: What must not be entered.
        pace: Limits.
        dt: s.

    Returns:
        Where the rhythm is then, and the velocity the discrete motion must have, (2,).
    """
    wanted = _wanted(cycle, rhythm, to_goal, pace)
    along = float(np.hypot(velocity[0], velocity[1]))
    slower = min(1.0, cycle.pitch / (cycle.period * along)) if along > 0.0 else 1.0
    velocity = velocity * (1.0 + wanted * (slower - 1.0))
    now = q + offset(cycle, rhythm, q, room)
    time = dt
    allowed = pace.speed * dt
    for attempt in range(_ROUNDS + 1):
        moved = q + time * velocity
        then = _turned(cycle, rhythm, time)
        share = min(
            wanted,
            rhythm.share + time / cycle.period,
            _fitting(cycle, then.deviation, room.around(moved)),
        )
        then = replace(then, share=share)
        step = moved + share * _whole(cycle, then) - now
        far = float(np.hypot(*(step * pace.half_extents)))
        if far <= allowed or attempt == _ROUNDS:
            break
        time *= allowed / far
    velocity = velocity * (time / dt)
    travelled = rhythm.travelled + dt * float(np.hypot(*velocity))
    return replace(then, travelled=travelled), velocity


def _turned(cycle: LimitCycle, rhythm: Rhythm, time: float) -> Rhythm:
    periods = time / cycle.period
    return replace(
        rhythm,
        phase=(rhythm.phase + 2.0 * np.pi * periods) % (2.0 * np.pi),
        deviation=decayed(rhythm.deviation, periods),
    )


def _whole(cycle: LimitCycle, rhythm: Rhythm) -> FloatArray:
    return np.asarray(cycle.offset(rhythm.phase) + rhythm.deviation)


def _wanted(cycle: LimitCycle, rhythm: Rhythm, to_goal: float, pace: Pace) -> float:
    """The share of the cycle where there is room: 0 before and after the cycles."""
    if rhythm.travelled < cycle.begin:
        return 0.0
    # It fades within a period.
    left = min(pace.length - rhythm.travelled - cycle.end, to_goal - SETTLED)
    return float(np.clip(left / cycle.pitch, 0.0, 1.0))


def _fitting(cycle: LimitCycle, deviation: FloatArray, room: float) -> float:
    """The share of the cycle that a disc of radius `room` holds."""
    return min(1.0, room / (cycle.radius + float(np.hypot(*deviation))))
