"""How fast the washed point may go along the skin: a bound, whatever is asked.

The washed point S is the one that the jet points at. It goes with the nozzle's turn,
too, the faster the farther away it is: noise in a normal of the skin moves it.
"""

import math
from dataclasses import dataclass

import numpy as np

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
    p_ES = washed.p_ES_W
    relative = cross(twist[:3], p_ES) + twist[3:] - washed.skin[3:]
    return np.asarray(relative - _part_along(p_ES, relative))


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
    speed = math.hypot(*along_skin(twist, washed).tolist())
    if speed <= bound:
        return twist
    # What a nozzle fixed to the skin would do.
    p_ES, skin = washed.p_ES_W, washed.skin
    carried = np.concatenate([skin[:3], skin[3:] - cross(skin[:3], p_ES)])
    relative = twist - carried
    straight = np.concatenate([np.zeros(3), _part_along(p_ES, relative[3:])])
    return np.asarray(carried + straight + (relative - straight) * (bound / speed))


def _part_along(direction: FloatArray, vector: FloatArray) -> FloatArray:
    unit = direction / math.hypot(*direction.tolist())
    return np.asarray((vector @ unit) * unit)
