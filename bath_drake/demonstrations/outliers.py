"""Samples of a recording that no hand made: jumps away from the path and back."""

import numpy as np

from bath_drake.notation import FloatArray, IntArray

# A step there and back at this multiple of the speed around it is no hand's.
OUTLIER_SPEED = 6.0
# ... if it also leaves the path by this share of the box's longest side.
OUTLIER_SIZE = 0.02
OUTLIER_LENGTH = 3
OUTLIER_WINDOW = 10
# Beside a smooth path a sample is astray at this multiple of what is usual around it,
# if its neighbours are at less than this share of it, and a jump is this large.
STRAY, STRAY_ALONE, STRAY_SIZE = 4.0, 0.5, 0.03


def find_outliers(t: FloatArray, points: FloatArray) -> IntArray:
    """Finds samples that jump away from the path and back.

    A run of at most three samples is out when the steps into it and out of it are
    both far longer than the steps around, and longer than what is left between its
    neighbours once it is gone. The first and last samples never are: nothing
    tells a jump there from a motion.

    Args:
        t: Times, shape (n,), s, strictly increasing.
        points: Positions, shape (n, d), m.

    Returns:
        Indices of the outliers, shape (k,), increasing.
    """
    count = t.size
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    speeds = steps / np.diff(t)
    smallest = OUTLIER_SIZE * float(np.max(np.ptp(points, axis=0)))
    out = np.zeros(count, dtype=np.bool_)
    for length in range(1, min(OUTLIER_LENGTH, count - 2) + 1):
        into, back = steps[: count - 1 - length], steps[length:]
        gap = points[length + 1 :] - points[: -length - 1]
        across = np.linalg.norm(gap, axis=1)
        jumps = np.minimum(into, back) > np.maximum(smallest, 2.0 * across)
        for first in np.flatnonzero(jumps) + 1:
            last = first + length
            around = np.r_[
                speeds[max(0, first - 1 - OUTLIER_WINDOW) : first - 1],
                speeds[last : last + OUTLIER_WINDOW],
            ]
            usual = float(np.median(around)) if around.size else np.inf
            jump = min(speeds[first - 1], speeds[last - 1])
            # A neighbour found before has steps of its own that would mislead.
            if jump > OUTLIER_SPEED * usual and not np.any(out[first - 1 : last + 1]):
                out[first:last] = True
    return np.flatnonzero(out)


def find_strays(residuals: FloatArray, side: float) -> IntArray:
    """Finds samples that stand out from what a smooth path leaves of a recording.

    Where tremor is strong and samples are few, a jump is not much longer than the
    steps around it; off the smooth path it is alone all the same.

    Args:
        residuals: From the smooth path to the samples, shape (n, d), m.
        side: Longest side of the path's box, m.

    Returns:
        Their indices, shape (k,), increasing; never the first or the last sample.
    """
    off = np.linalg.norm(residuals, axis=1)
    found = []
    for i in np.flatnonzero(off > STRAY_SIZE * side):
        if i in (0, len(off) - 1):
            continue
        around = np.r_[
            off[max(0, i - OUTLIER_WINDOW) : i], off[i + 1 : i + 1 + OUTLIER_WINDOW]
        ]
        alone = max(off[i - 1], off[i + 1]) < STRAY_ALONE * off[i]
        if alone and off[i] > STRAY * float(np.median(around)):
            found.append(int(i))
    return np.array(found, dtype=np.int64)
