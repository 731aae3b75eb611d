"""How fast the washed point may go along the skin: a bound, whatever is asked.

The washed point S is the one that the jet points at. It goes with the nozzle's turn,
too, the faster the farther away it is: noise in a normal of the skin moves it.
"""

import math
from dataclasses import dataclass

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


@njit(cache=True)
def along_skin(twist: FloatArray, p_ES_W: FloatArray, skin: FloatArray) -> FloatArray:
    """Returns the velocity (3,) of the washed point along the skin, m/s in W.

    Args:
        twist: (6,) spatial velocity of the nozzle E, rad/s and m/s in W.
        p_ES_W: Of the `WashedPoint`.
        skin: Likewise.
    """
    relative = cross(twist[:3], p_ES_W) + twist[3:] - skin[3:]
    return relative - _part_along(p_ES_W, relative)


@njit(cache=True)
def within_skin_speed(
    twist: FloatArray, p_ES_W: FloatArray, skin: FloatArray, bound: float
) -> FloatArray:
    """Returns the twist (6,) whose washed point goes along the skin within the bound.

    The skin's own motion is followed whole, and so is the way along the jet: a distance
    from the skin is kept whatever happens. Turn and way across the jet, as they are
    seen from the skin, are slowed down together.

    Args:
        twist: (6,) spatial velocity of the nozzle E, rad/s and m/s in W.
        p_ES_W: Of the `WashedPoint`.
        skin: Likewise.
        bound: m/s, greater than zero.
    """
    speed = _length(along_skin(twist, p_ES_W, skin))
    if speed <= bound:
        return twist
    # What a nozzle fixed to the skin would do.
    turned = cross(skin[:3], p_ES_W)
    carried = skin.copy()
    for k in range(3):
        carried[3 + k] -= turned[k]
    relative = twist - carried
    straight = _part_along(p_ES_W, relative[3:])
    kept = carried + relative * (bound / speed)
    for k in range(3):
        kept[3 + k] += straight[k] * (1.0 - bound / speed)
    return kept


@njit(cache=True)
def _part_along(direction: FloatArray, vector: FloatArray) -> FloatArray:
    size, part = _length(direction), 0.0
    for k in range(3):
        part += vector[k] * direction[k] / size
    return direction * (part / size)


@njit(cache=True)
def _length(vector: FloatArray) -> float:
    return math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
