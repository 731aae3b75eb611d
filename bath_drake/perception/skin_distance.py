"""How far a point is from the skin that is seen, in any direction."""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray

# m: skin further off than this is not looked for.
REACH = 0.15
# m^2: less skin than this may be noise, or a pixel between the robot and the back.
LEAST_AREA = 2e-4
# m: distances are counted in steps of this.
STEP = 1e-3


@njit(cache=True)
def skin_distance(points_W: FloatArray, areas: FloatArray, p_WQ: FloatArray) -> float:
    """Returns the distance within which there is some skin, m.

    Args:
        points_W: (n, 3) points of skin, m.
        areas: (n,) the surface each stands for, m^2.
        p_WQ: (3,) the point, m.

    Returns:
        Less than the truth by up to `STEP`; infinite where there is less than
        `LEAST_AREA` within `REACH`.
    """
    # A guard asks this two hundred times a second: counted, not sorted.
    within = np.zeros(int(REACH / STEP) + 1)
    for i in range(len(points_W)):
        x = points_W[i, 0] - p_WQ[0]
        y = points_W[i, 1] - p_WQ[1]
        z = points_W[i, 2] - p_WQ[2]
        squared = x * x + y * y + z * z
        if squared <= REACH * REACH:
            within[int(np.sqrt(squared) / STEP)] += areas[i]
    found = 0.0
    for k in range(len(within)):
        found += within[k]
        if found >= LEAST_AREA:
            return k * STEP
    return np.inf
