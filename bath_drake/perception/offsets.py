"""Many points less one: numpy's own broadcasting over rows of three is slow."""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray


def less(points: FloatArray, origin: FloatArray) -> FloatArray:
    """Returns points (..., 3) less one of them, (3,)."""
    points = np.asarray(points, dtype=np.float64)
    if points.ndim != 2 or not points.flags.c_contiguous:
        return points - origin
    return _less(points, origin[0], origin[1], origin[2])


@njit(cache=True)
def _less(points: FloatArray, x: float, y: float, z: float) -> FloatArray:
    offsets = np.empty(points.shape)
    for i in range(len(points)):
        offsets[i, 0] = points[i, 0] - x
        offsets[i, 1] = points[i, 1] - y
        offsets[i, 2] = points[i, 2] - z
    return offsets
