"""Demonstrations laid beside each other point by point, and their mean.

At equal shares of arc length a corner that one carer makes a little later than another
is averaged away. Where that matters, points are matched by time warping and the mean
is the one of matched points (barycentre averaging, Petitjean, Ketterlin and Gancarski,
A global averaging method for dynamic time warping, 2011).
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.learning._alignment import matches
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.strokes import resample
from bath_drake.notation import FloatArray

_ROUNDS = 6
# Matched indices are averaged over so many points: a warp that jumps is no motion.
_SMOOTH = 3
# Time warping must bring the mean this much nearer, in shares, to be worth it.
_GAIN = 0.05


@dataclass(frozen=True, eq=False)
class Alignment:
    """Demonstrations as functions of one parameter.

    Attributes:
        points: Point t of each answers to point t of the others, shape (D, T, 2).
        mean: Shape (T, 2), at nearly equal steps.
    """

    points: FloatArray
    mean: FloatArray


def align(strokes: FloatArray, mean: FloatArray | None = None) -> Alignment:
    """Aligns strokes (D, T, 2) of equal steps that end at one goal.

    Their mean at equal shares of arc length is the reference, unless that of time
    warping is clearly nearer to them by the Fréchet distance; or the ``mean`` given.
    """
    if mean is not None:
        return Alignment(_matched(mean, strokes), mean)
    if len(strokes) == 1:
        return Alignment(strokes, strokes[0])
    count = strokes.shape[1]
    plain = resample(strokes.mean(axis=0), count)
    warped = plain
    for _ in range(_ROUNDS):
        warped = resample(_matched(warped, strokes).mean(axis=0), count)
    worth = _far(warped, strokes) < (1.0 - _GAIN) * _far(plain, strokes)
    chosen = warped if worth else plain
    chosen[-1] = strokes[0, -1]  # the common goal, whatever the sum rounded to
    return Alignment(_matched(chosen, strokes), chosen)


def _far(mean: FloatArray, strokes: FloatArray) -> float:
    return float(np.mean([discrete_frechet(mean, stroke) for stroke in strokes]))


def _matched(reference: FloatArray, strokes: FloatArray) -> FloatArray:
    """Each stroke at the points that answer to those of the reference (T, 2)."""
    index = np.arange(strokes.shape[1])
    window = np.full(2 * _SMOOTH + 1, 1.0 / (2 * _SMOOTH + 1))
    found = []
    for stroke in strokes:
        at = matches(reference, np.ascontiguousarray(stroke))
        at = np.convolve(np.pad(at, _SMOOTH, mode="edge"), window, mode="valid")
        at[0], at[-1] = 0.0, index[-1]
        columns = [np.interp(at, index, stroke[:, k]) for k in range(2)]
        found.append(np.stack(columns, axis=-1))
    return np.array(found)
