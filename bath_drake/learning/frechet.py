"""The discrete Fréchet distance (paper, Eq. 3 in its discrete form)."""

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.learning import _kernels


def discrete_frechet(a: ArrayLike, b: ArrayLike) -> float:
    """The discrete Fréchet distance of two polylines.

    Two walkers hop along the points of a (n, 2) and b (m, 2), never back; this is
    the shortest leash that serves, over all ways of hopping.

    Raises:
        ValueError: A polyline is empty, of another shape, or not finite.
    """
    curves = []
    for name, curve in (("a", a), ("b", b)):
        points = np.array(curve, dtype=np.float64, order="C")
        if points.ndim != 2 or points.shape[1] != 2 or not len(points):
            raise ValueError(f"{name} must have shape (n, 2), n > 0: {points.shape}")
        if not np.isfinite(points).all():
            raise ValueError(f"{name} must be finite")
        curves.append(points)
    return float(_kernels.frechet(curves[0], len(curves[0]), curves[1]))
