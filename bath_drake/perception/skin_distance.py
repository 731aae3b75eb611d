"""How far a point is from the skin that is seen, in any direction."""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray

# m: skin further off than this is not looked for.
REACH = 0.15
# m^2: less skin than this may be noise, or a pixel between the robot and the back.
LEAST_AREA = 2e-4


@njit(cache=True)
def skin_distance(
    points_W: FloatArray,
    areas: FloatArray,
    p_WQ: FloatArray,
    reach: float = REACH,
    least_area: float = LEAST_AREA,
) -> float:
    """Returns the distance within which there is some skin, m; infinite beyond `reach`.

    Args:
        points_W: (n, 3) points of skin, m.
        areas: (n,) the surface each stands for, m^2.
        p_WQ: (3,) the point, m.
        reach: How far is looked, m.
        least_area: How much skin has to be within the distance, m^2.
    """
    distances = np.empty(len(points_W))
    weights = np.empty(len(points_W))
    count = 0
    for i in range(len(points_W)):
        x = points_W[i, 0] - p_WQ[0]
        y = points_W[i, 1] - p_WQ[1]
        z = points_W[i, 2] - p_WQ[2]
        squared = x * x + y * y + z * z
        if squared <= reach * reach:
            distances[count], weights[count] = squared, areas[i]
            count += 1
    found = 0.0
    for i in np.argsort(distances[:count]):
        found += weights[i]
        if found >= least_area:
            return float(np.sqrt(distances[i]))
    return np.inf
