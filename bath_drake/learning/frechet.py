"""The discrete Fréchet distance (paper, Eq. 3 in its discrete form)."""

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.learning import _frechet
from bath_drake.notation import FloatArray

# Squares from here on lose nothing to underflow. For smaller ones, and where they
# overflow, a power of two scales what is squared, which changes no digit of it.
_LEAST_SQUARE: Final = 2.0**-900
_SCALE: Final = 2.0**600


class FrechetGradient(NamedTuple):
    """The discrete Fréchet distance of a and b, and how it grows with a.

    Attributes:
        distance: As from `discrete_frechet`.
        pair: The indices (i, j) of the points whose distance it is.
        gradient: The distance's derivatives to a's coordinates, shape (n, 2): the
            unit vector from b[j] to a[i] in row i, zero elsewhere. To b's coordinates
            they are the opposite, in row j.
    """

    distance: float
    pair: tuple[int, int]
    gradient: FloatArray


def discrete_frechet(a: ArrayLike, b: ArrayLike) -> float:
    """The discrete Fréchet distance of two polylines.

    Two walkers hop along the points of a (n, 2) and b (m, 2), never back; this is
    the shortest leash that serves, over all ways of hopping. Exact but for the
    rounding of one distance, whatever the size of the coordinates; inf if it overflows.

    Raises:
        ValueError: A polyline is empty, of another shape, or not finite.
    """
    first, second = _points("a", a), _points("b", b)
    square = _frechet.squared_frechet(first, len(first), second, math.inf)
    if _LEAST_SQUARE <= square < math.inf:
        return math.sqrt(square)
    return _scaled(first, second, square)[0]


def discrete_frechet_gradient(a: ArrayLike, b: ArrayLike) -> FrechetGradient:
    """The discrete Fréchet distance, the pair of points it hangs on, and its gradient.

    The distance is differentiable where a single pair of points is that far apart and
    the distance is not zero. Elsewhere the pair is one that some shortest leash needs,
    and what is returned is the gradient of that pair's distance; zero if it is zero.

    Raises:
        ValueError: A polyline is empty, of another shape, or not finite.
    """
    first, second = _points("a", a), _points("b", b)
    distance, i, j = _frechet.bottleneck(first, len(first), second)
    if not _LEAST_SQUARE <= distance * distance < math.inf:
        distance, i, j = _scaled(first, second, distance * distance)
    gradient = np.zeros_like(first)
    half = 0.5 if distance > 1e300 else 1.0  # the difference itself might overflow
    away = half * first[i] - half * second[j]
    size = np.abs(away).max()
    if size > 0.0:
        away /= size
        gradient[i] = away / math.hypot(away[0], away[1])
    return FrechetGradient(distance, (i, j), gradient)


def _points(name: str, curve: ArrayLike) -> FloatArray:
    points = np.array(curve, dtype=np.float64, order="C")
    if points.ndim != 2 or points.shape[1] != 2 or not len(points):
        raise ValueError(f"{name} must have shape (n, 2), n > 0: {points.shape}")
    if not _frechet.all_finite(points):
        raise ValueError(f"{name} must be finite")
    return points


def _scaled(a: FloatArray, b: FloatArray, square: float) -> tuple[float, int, int]:
    """Distance and pair where the square is too small or too large for a double."""
    if square < _LEAST_SQUARE:
        # Differences, not coordinates: others of these may be large.
        small, i, j = _frechet.scaled_bottleneck(a, len(a), b, _SCALE)
        return small, i, j
    large, i, j = _frechet.bottleneck(a / _SCALE, len(a), b / _SCALE)
    return large * _SCALE, i, j
