"""The whole motion without a simulator: cycles along a path of the discrete motion."""

import numpy as np

from bath_drake.notation import FloatArray
from bath_drake.rhythm.limit_cycle import LimitCycle
from bath_drake.rhythm.superposition import Pace, Rhythm, Room, advance, offset

# Steps of the paper's Euler integration, s, and the longest motion that is followed.
STEP_S = 0.01
LONGEST_S = 3600.0


def whole_motion(
    cycle: LimitCycle,
    path: FloatArray,
    room: Room,
    *,
    speed: float,
    half_extents: FloatArray,
    slow_radius: float = 0.1,
) -> tuple[FloatArray, FloatArray]:
    """Follows a path with the cycle on top, as `PeriodicMotion` does in the loop.

    Args:
        cycle: The periodic motion.
        path: Of the discrete motion, shape (n, 2), in N; its end is the goal.
        room: What the sum must not enter.
        speed: Of the sum along the skin, at most, m/s.
        half_extents: Of the body, shape (2,), m.
        slow_radius: Within it of the goal the discrete motion slows, in N.

    Returns:
        Times (m,), s, and points (m, 2), in N, to where the path ends.
    """
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    moving = np.append(True, steps > 0.0)
    path, steps = path[moving], steps[steps > 0.0]
    along = np.concatenate([[0.0], np.cumsum(steps)])
    pace = Pace(speed, half_extents, float(along[-1]))
    rhythm, done = Rhythm(), 0.0
    points: list[FloatArray] = []
    for _ in range(round(LONGEST_S / STEP_S)):
        k = min(int(np.searchsorted(along, done, side="right")), len(along) - 1)
        q = np.stack([np.interp(done, along, column) for column in path.T])
        points.append(q + offset(cycle, rhythm, q, room))
        left = float(along[-1]) - done
        if left <= 1e-3:
            break
        direction = (path[k] - path[k - 1]) / steps[k - 1]
        slowed = speed * min(1.0, left / slow_radius + 1e-2)
        velocity = direction * (slowed / np.linalg.norm(direction * half_extents))
        away = float(np.hypot(*(path[-1] - q)))
        rhythm, velocity = advance(cycle, rhythm, q, velocity, away, room, pace, STEP_S)
        done += STEP_S * float(np.hypot(*velocity))
    times: FloatArray = STEP_S * np.arange(len(points), dtype=np.float64)
    return times, np.array(points)
