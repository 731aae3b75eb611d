"""One step of a velocity towards another: speed, acceleration and jerk are bounded.

By construction, whatever is wanted: from any velocity and acceleration the acceleration
can be run down with the jerk there is, along a straight line of velocities. No step is
taken after which that line would leave the ball of allowed speeds, so that there is
always a next step within all three bounds.
"""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray

# How often a step is halved before the acceleration is run down instead.
_HALVINGS = 4


@njit(cache=True)
def next_smooth(
    v: FloatArray,
    a: FloatArray,
    wanted: FloatArray,
    speed: float,
    most: float,
    jerk: float,
    rate: float,
    dt: float,
) -> FloatArray:
    """Returns velocity and acceleration (3,) one step later, in one row (6,).

    Args:
        v: (3,) velocity now.
        a: (3,) acceleration that led to it.
        wanted: (3,) velocity to come to.
        speed: Bound of the velocity.
        most: Bound of the acceleration.
        jerk: Bound of its change, 1/s.
        rate: What is wanted is approached with so much of the difference, 1/s.
        dt: s.

    A velocity beyond the speed's bound comes back within it; one within stays.
    """
    step = jerk * dt
    difference = np.sqrt(((wanted - v) ** 2).sum())
    # No more than can be run down before the wanted velocity is passed.
    size = np.sqrt(0.25 * step**2 + 2.0 * jerk * difference) - 0.5 * step
    size = min(size, rate * difference, most)
    change = -a
    if difference > 0.0:
        change = (wanted - v) * (size / difference) - a
    length = np.sqrt((change**2).sum())
    if length > step:
        change = change * (step / length)
    down = _run_down(a, step)
    bound = max(speed, _size_at_rest(v, down, step, dt))
    meant = a + change
    share = 1.0
    for _ in range(_HALVINGS):
        if _size_at_rest(v, down + share * (meant - down), step, dt) <= bound:
            break
        share *= 0.5
    else:
        share = 0.0
    after = np.empty(6)
    for k in range(3):
        after[3 + k] = down[k] + share * (meant[k] - down[k])
        after[k] = v[k] + dt * after[3 + k]
    return after


@njit(cache=True)
def _run_down(a: FloatArray, step: float) -> FloatArray:
    """The acceleration one step nearer to none."""
    size = np.sqrt((a**2).sum())
    return a * (1.0 - step / size) if size > step else np.zeros(3)


@njit(cache=True)
def _size_at_rest(v: FloatArray, a: FloatArray, step: float, dt: float) -> float:
    """The speed after a step with `a`, and then running it down."""
    size = np.sqrt((a**2).sum())
    ticks = np.floor(size / step)
    # 1 + the sum of what is left of it at each tick, as a share of it.
    share = 1.0
    if size > 0.0:
        share += ticks - 0.5 * step * ticks * (ticks + 1.0) / size
    return float(np.sqrt(((v + dt * share * a) ** 2).sum()))
