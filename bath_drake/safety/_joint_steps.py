"""Compiled arithmetic of `bath_drake.safety.joint_command`: the step of seven joints.

Positions, velocities and accelerations are (n,) in rad, rad/s and rad/s^2, Jacobians
(6, n), dt in s. Every comparison is written so that what is not a number is refused.
"""

import math
from typing import Any

import numpy as np

from bath_drake.field._boundaries import compiled
from bath_drake.notation import FloatArray
from bath_drake.safety.reasons import Reason

# Of the acceleration, for catching up with a command that is ahead: the rest is left
# for the command's own.
_CATCH_UP = 0.5
# Beyond any meaning, and of a finite square: rad/s, m/rad and rad/rad.
HUGE = 1e3
FINE = int(Reason.NONE)
_NOT_FINITE = int(Reason.COMMAND_NOT_FINITE)
_OUT_OF_RANGE, _JUMPED = int(Reason.JOINT_LIMIT), int(Reason.COMMAND_JUMP)
# Of two rows' directions, as a cosine; and after so many rounds none is left over.
_SQUARE, _SWEEPS = 1e-14, 30
# Slower changes than this are none, rad/s.
_NONE = 1e-12


@compiled
def is_small(values: FloatArray) -> bool:
    """Whether every number is finite and less than `HUGE` in size."""
    for value in values.flat:
        if not abs(value) < HUGE:
            return False
    return True


@compiled
def stoppable(way: Any, acceleration: Any, dt: float) -> Any:
    """The speed from which, after one more step, one stops within `way` >= 0.

    It solves dt v + v^2 / (2 a) = way, elementwise.
    """
    step = acceleration * dt
    return np.sqrt(step * step + 2.0 * acceleration * way) - step


@compiled
def stopping_speeds(
    q: FloatArray,
    low: FloatArray,
    high: FloatArray,
    speed: FloatArray,
    acceleration: float,
    dt: float,
) -> tuple[FloatArray, bool]:
    """How fast each joint may go, so that after one more step it stops in its range.

    Args:
        q: (n,) positions, rad.
        low: (n,) the range's lower ends, rad.
        high: (n,) its upper ends, rad.
        speed: (n,) speeds that none goes beyond, rad/s.
        acceleration: rad/s^2.
        dt: The step, s.

    Returns:
        Speeds (2, n) down and up, rad/s, zero beyond an end; and whether all positions
        are within the range.
    """
    speeds, inside = np.empty((2, len(q))), True
    for k in range(len(q)):
        inside = inside and low[k] <= q[k] <= high[k]
        for row, way in enumerate((q[k] - low[k], high[k] - q[k])):
            most = stoppable(max(way, 0.0), acceleration, dt)
            speeds[row, k] = min(speed[k], most)
    return speeds, inside


@compiled
def refusal(
    q: FloatArray,
    v: FloatArray,
    q_last: FloatArray,
    low: FloatArray,
    high: FloatArray,
    jump: float,
) -> int:
    """The `Reason` why a command q, v cannot be followed from q_last, or NONE."""
    for k in range(len(q)):
        if not (math.isfinite(q[k]) and math.isfinite(v[k])):
            return _NOT_FINITE
    for k in range(len(q)):
        if not low[k] <= q[k] <= high[k]:
            return _OUT_OF_RANGE
    for k in range(len(q)):
        if not (abs(q[k] - q_last[k]) <= jump and abs(v[k]) <= HUGE):
            return _JUMPED
    return FINE


@compiled
def catching_up(
    q: FloatArray,
    v: FloatArray,
    q_last: FloatArray,
    acceleration: FloatArray,
    dt: float,
) -> FloatArray:
    """v, and what takes away the lag that following v alone would leave."""
    wanted = np.empty(len(q))
    for k in range(len(q)):
        lag = q[k] - q_last[k] - dt * v[k]
        speed = stoppable(abs(lag), _CATCH_UP * acceleration[k], dt)
        wanted[k] = v[k] + math.copysign(speed, lag)
    return wanted


@compiled
def next_velocity(
    wanted: FloatArray,
    J: FloatArray,
    q_last: FloatArray,
    v_last: FloatArray,
    low: FloatArray,
    high: FloatArray,
    velocity: FloatArray,
    acceleration: FloatArray,
    tip_speed: float,
    dt: float,
) -> tuple[FloatArray, float]:
    """As far from the last velocity to the one wanted as the limits allow.

    Returns:
        The velocity, and how much of what was wanted it is: the share of the change,
        over what the wanted one was too fast. The share is -1 if no velocity will do.
    """
    n = len(wanted)
    # All joints by one factor; then one that is at its speed does not keep the others
    # from changing theirs. Between two slow tips every tip is slow.
    excess, tip2 = 1.0, 0.0
    for i in range(3, 6):
        along = 0.0
        for k in range(n):
            along += J[i, k] * wanted[k]
        tip2 += along * along
    excess = max(excess, math.sqrt(tip2) / tip_speed)
    for k in range(n):
        excess = max(excess, abs(wanted[k]) / velocity[k])
    least, most = np.empty(n), np.empty(n)
    first, final = 0.0, 1.0
    for k in range(n):
        # What is out of its range may only come back.
        slowest = -stoppable(max(q_last[k] - low[k], 0.0), acceleration[k], dt)
        fastest = stoppable(max(high[k] - q_last[k], 0.0), acceleration[k], dt)
        change = dt * acceleration[k]
        least[k] = max(-velocity[k], slowest, v_last[k] - change)
        most[k] = min(velocity[k], fastest, v_last[k] + change)
        # The largest s in [0, 1] with least <= v_last + s d <= most.
        d = wanted[k] / excess - v_last[k]
        if abs(d) < _NONE:
            if not least[k] - _NONE <= v_last[k] <= most[k] + _NONE:
                return least, -1.0
            continue
        one, other = (least[k] - v_last[k]) / d, (most[k] - v_last[k]) / d
        first, final = max(first, min(one, other)), min(final, max(one, other))
    if not first <= final:
        return least, -1.0
    v_next = np.empty(n)
    for k in range(n):
        # Rounding alone is clipped: the share was chosen within the bounds.
        v = v_last[k] + final * (wanted[k] / excess - v_last[k])
        v_next[k] = min(max(v, least[k]), most[k])
    return v_next, final / excess


@compiled
def followed_rows(J_W: FloatArray, R_WE: FloatArray) -> FloatArray:
    """Returns (5, n): turns about E's x and y, then the tip's shifts in W.

    In which axes the shifts are told is nothing to the singular values.
    """
    rows = np.empty((5, J_W.shape[1]))
    for k in range(J_W.shape[1]):
        for i in range(2):
            rows[i, k] = 0.0
            for j in range(3):
                rows[i, k] += R_WE[j, i] * J_W[j, k]
        for i in range(3):
            rows[2 + i, k] = J_W[3 + i, k]
    return rows


@compiled
def singular_value_ratio(rows: FloatArray) -> float:
    """The greatest singular value of a matrix (m, n), m <= n, over the least.

    Its rows are turned against each other until every two are square to each other:
    their lengths are the singular values (Hestenes 1958), the small ones to their own
    last digits. Infinite where one is zero.
    """
    rows = rows.copy()
    m, n = rows.shape
    for _ in range(_SWEEPS):
        turned = False
        for i in range(m):
            for j in range(i + 1, m):
                a, b, c = 0.0, 0.0, 0.0
                for k in range(n):
                    a += rows[i, k] * rows[i, k]
                    b += rows[j, k] * rows[j, k]
                    c += rows[i, k] * rows[j, k]
                if not abs(c) > _SQUARE * math.sqrt(a * b):
                    continue
                turned = True
                half = 0.5 * (b - a) / c
                t = math.copysign(1.0, half) / (abs(half) + math.hypot(1.0, half))
                cosine = 1.0 / math.hypot(1.0, t)
                sine = t * cosine
                for k in range(n):
                    x, y = rows[i, k], rows[j, k]
                    rows[i, k] = cosine * x - sine * y
                    rows[j, k] = sine * x + cosine * y
        if not turned:
            break
    least, greatest = math.inf, 0.0
    for i in range(m):
        length = math.sqrt((rows[i] * rows[i]).sum())
        least, greatest = min(least, length), max(greatest, length)
    return greatest / least if least > 0.0 else math.inf
