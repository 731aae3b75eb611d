"""The plane, the axes and the extents of some ten thousand points, compiled."""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray, IntArray
from bath_drake.perception.quadric import cross
from bath_drake.perception.quantiles import low_quantile, ordered

# Where the variances along the two in-plane principal axes are within the first
# ratio their directions are noise and gravity decides; above the second the
# principal axes alone decide; between the two the angle is blended. Either is but
# a first guess, which the midline corrects.
SQUARE_RATIO = 1.15
OBLONG_RATIO = 1.5

# The midline: levels of this height (metres), the outermost share of the back at
# either end left out, slopes between levels at least so far apart (metres).
LEVEL = 0.01
MIDLINE_TRIM = 0.03
MIDLINE_SPAN = 0.1
MIDLINE_ROUNDS = 2

# What `principal_axes` may say of points.
FOUND, ON_A_LINE, LEVEL_PLANE = 0, 1, 2


@njit(cache=True)
def principal_axes(
    points: FloatArray, weights: FloatArray, up: FloatArray, eye: FloatArray
) -> tuple[int, FloatArray, FloatArray]:
    """Returns what `bath_drake.perception.canonical.principal_frame` does.

    Args:
        points: (n, 3), metres.
        weights: (n,) of each, of any sum.
        up: (3,) whose side the y axis takes.
        eye: (3,) to which z points, metres.

    Returns:
        `FOUND`, or why not; the mean (3,); the axes (3, 3), as columns.
    """
    mean, variances, axes = _moments(points, weights)
    if not variances[1] > 1e-8:
        return ON_A_LINE, mean, axes
    z = axes[:, 0].copy()
    if _dot(z, eye - mean) < 0.0:
        z = -z
    up = up - _dot(up, z) * z
    length = np.sqrt(_dot(up, up))
    if not length > 1e-6:
        return LEVEL_PLANE, mean, axes
    y = _first_guess(axes[:, 2].copy(), variances[2] / variances[1], z, up / length)
    along, across = np.empty(len(points)), np.empty(len(points))
    for _ in range(MIDLINE_ROUNDS):
        x = cross(y, z)
        _project(points, mean, y, along)
        _project(points, mean, x, across)
        angle = _midline_slope(along, across)
        y = np.cos(angle) * y + np.sin(angle) * x
    R = np.empty((3, 3))
    R[:, 0], R[:, 1], R[:, 2] = cross(y, z), y, z
    return FOUND, mean, R


@njit(cache=True)
def trimmed_box(
    points: FloatArray,
    weights: FloatArray,
    mean: FloatArray,
    R: FloatArray,
    trim: float,
) -> FloatArray:
    """Returns (2, 2) the lower and upper ends of points along two axes.

    Args:
        points: (n, 3), metres.
        weights: (n,) of each, of any sum.
        mean: (3,) from which the ends are counted, metres.
        R: (3, 3) the axes, as columns.
        trim: Share of the weights left out at each end.
    """
    box, values = np.empty((2, 2)), np.empty(len(points))
    shares = weights / weights.sum()
    for k in range(2):
        _project(points, mean, R[:, k].copy(), values)
        box[0, k] = low_quantile(values, shares, trim)
        box[1, k] = -low_quantile(-values, shares, trim)
    return box


@njit(cache=True)
def _dot(a: FloatArray, b: FloatArray) -> float:
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@njit(cache=True)
def _project(
    points: FloatArray, mean: FloatArray, axis: FloatArray, out: FloatArray
) -> None:
    """Writes where points (n, 3) are along an axis (3,) from their mean."""
    for i in range(len(points)):
        out[i] = (
            (points[i, 0] - mean[0]) * axis[0]
            + (points[i, 1] - mean[1]) * axis[1]
            + (points[i, 2] - mean[2]) * axis[2]
        )


@njit(cache=True)
def _moments(
    points: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Returns the mean (3,), the variances (3,), rising, and their axes (3, 3)."""
    total, mean = 0.0, np.zeros(3)
    for i in range(len(points)):
        total += weights[i]
        for k in range(3):
            mean[k] += weights[i] * points[i, k]
    mean /= total
    moments = np.zeros((3, 3))
    for i in range(len(points)):
        a, b, c = points[i, 0] - mean[0], points[i, 1] - mean[1], points[i, 2] - mean[2]
        share = weights[i] / total
        moments[0, 0] += share * a * a
        moments[1, 0] += share * b * a
        moments[1, 1] += share * b * b
        moments[2, 0] += share * c * a
        moments[2, 1] += share * c * b
        moments[2, 2] += share * c * c
    for j in range(3):
        for k in range(j):
            moments[k, j] = moments[j, k]
    variances, axes = np.linalg.eigh(moments)
    return mean, variances, axes


@njit(cache=True)
def _first_guess(
    major: FloatArray, ratio: float, normal: FloatArray, up: FloatArray
) -> FloatArray:
    """Chooses the in-plane y axis; `ratio` is that of the two variances."""
    right = cross(up, normal)
    # Angle from up to the major axis; axes are lines and come in a cross, so the
    # nearest arm of the cross is within 45 degrees.
    angle = np.arctan2(-_dot(major, right), _dot(major, up))
    angle = (angle + np.pi / 4.0) % (np.pi / 2.0) - np.pi / 4.0
    share = (ratio - SQUARE_RATIO) / (OBLONG_RATIO - SQUARE_RATIO)
    share = min(max(share, 0.0), 1.0)
    angle *= share * share * (3.0 - 2.0 * share)
    y: FloatArray = np.cos(angle) * up - np.sin(angle) * right
    return y


@njit(cache=True)
def _midline_slope(along: FloatArray, across: FloatArray) -> float:
    """Returns the angle of the midline to the `along` axis, towards `across`."""
    last = len(along) - 1
    first, end = MIDLINE_TRIM * last, (1.0 - MIDLINE_TRIM) * last
    i, j = int(first), int(end)
    places = np.array([i, min(i + 1, last), j, min(j + 1, last)])
    a, b, c, d = ordered(along, places)
    low, high = a + (first - i) * (b - a), c + (end - j) * (d - c)
    _, left, right = edges_between(along, across, low, high)
    slopes = _slopes(left, right)
    count = len(slopes)
    if count == 0:  # too short a region to have a midline
        return 0.0
    a, b = ordered(slopes, np.array([(count - 1) // 2, count // 2]))
    return float(np.arctan(0.5 * (a + b)))


@njit(cache=True)
def edges_between(
    along: FloatArray, across: FloatArray, low: float, high: float
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Returns the edges of a region's levels, of the points from `low` to `high`.

    Args and returns are those of `bath_drake.perception.canonical.edges_by_level`; the
    level of the other points is -1.
    """
    least, greatest = np.inf, -np.inf
    for a in along:
        if low <= a <= high:
            least, greatest = min(least, a), max(greatest, a)
    count = int((greatest - least) / LEVEL) + 1 if greatest >= least else 0
    level = np.full(len(along), -1, dtype=np.int64)
    left, right = np.full(count, np.inf), np.full(count, -np.inf)
    for i in range(len(along)):
        if low <= along[i] <= high:
            k = int((along[i] - least) / LEVEL)
            level[i] = k
            left[k], right[k] = min(left[k], across[i]), max(right[k], across[i])
    return level, left, right


@njit(cache=True)
def _slopes(left: FloatArray, right: FloatArray) -> FloatArray:
    """Returns the slope of the midline between all levels that are far apart."""
    count = len(left)
    slopes = np.empty(count * count)
    found = 0
    for i in range(count):
        for j in range(i + 1, count):
            apart = (j - i) * LEVEL
            if apart >= MIDLINE_SPAN and right[i] > left[i] and right[j] > left[j]:
                rise = (left[j] + right[j]) / 2.0 - (left[i] + right[i]) / 2.0
                slopes[found] = rise / apart
                found += 1
    return slopes[:found].copy()
