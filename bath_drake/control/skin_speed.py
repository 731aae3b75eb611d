"""How fast the washed point may go along the skin: a bound, whatever is asked.

The washed point S is the one that the jet points at. It goes with the nozzle's turn,
too, the faster the farther away it is: noise in a normal of the skin moves it.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray
from bath_drake.perception.quadric import cross

# m/s, beneath the 0.10 m/s of a gentle hand: the arm lags, and overshoots a little.
SKIN_SPEED = 0.085


@dataclass(frozen=True, eq=False)
class WashedPoint:
    """Where the jet meets the skin, and what the skin does there.

    Attributes:
        p_ES_W: (3,) from the nozzle E along the jet to the skin, m, not zero.
        skin: (6,) how the skin turns and moves by itself, rad/s and m/s in W.
    """

    p_ES_W: FloatArray
    skin: FloatArray


def along_skin(twist: FloatArray, washed: WashedPoint) -> FloatArray:
    """Returns the velocity (3,) of the washed point along the skin, m/s in W.

    Args:
        twist: (6,) spatial velocity of the nozzle E, rad/s and m/s in W.
        washed: Where it washes.
    """
    return np.asarray(_along(_plain(twist), _plain(washed.p_ES_W), _plain(washed.skin)))


def within_skin_speed(
    twist: FloatArray, washed: WashedPoint, bound: float = SKIN_SPEED
) -> FloatArray:
    """Returns the twist (6,) whose washed point goes along the skin within the bound.

    The skin's own motion is followed whole, and so is the way along the jet: a distance
    from the skin is kept whatever happens. Turn and way across the jet, as they are
    seen from the skin, are slowed down together.

    Args:
        twist: (6,) spatial velocity of the nozzle E, rad/s and m/s in W.
        washed: Where it washes.
        bound: m/s, greater than zero.
    """
    skin = _plain(washed.skin)
    return np.asarray(within(_plain(twist), _plain(washed.p_ES_W), skin, bound))


@njit(cache=True)
def within(
    twist: FloatArray, p_ES: FloatArray, skin: FloatArray, bound: float
) -> FloatArray:
    """As `within_skin_speed`, of a `WashedPoint`'s numbers."""
    speed = _length(_along(twist, p_ES, skin))
    if speed <= bound:
        return twist
    # What a nozzle fixed to the skin would do.
    turned = cross(skin[:3], p_ES)
    carried = skin.copy()
    for k in range(3):
        carried[3 + k] -= turned[k]
    relative = twist - carried
    straight = _part_along(p_ES, relative[3:])
    kept = carried + relative * (bound / speed)
    for k in range(3):
        kept[3 + k] += straight[k] * (1.0 - bound / speed)
    return kept


@njit(cache=True)
def _along(twist: FloatArray, p_ES: FloatArray, skin: FloatArray) -> FloatArray:
    relative = cross(twist[:3], p_ES) + twist[3:] - skin[3:]
    return relative - _part_along(p_ES, relative)


@njit(cache=True)
def _part_along(direction: FloatArray, vector: FloatArray) -> FloatArray:
    size, part = _length(direction), 0.0
    for k in range(3):
        part += vector[k] * direction[k] / size
    return direction * (part / size)


@njit(cache=True)
def _length(vector: FloatArray) -> float:
    return math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)


def _plain(values: FloatArray) -> FloatArray:
    return np.ascontiguousarray(values, dtype=np.float64)
