"""How demonstrations follow their ends, as similarities of a chain's stages.

A demonstration that starts elsewhere than the mean differs from it all along, less and
less towards the common goal. How, is predicted in two parts: the start's offset fades
out, partly as the stroke turned and stretched about its goal; and what the
demonstrations then still differ by is interpolated between their starts by a Gaussian
process. Each stage takes of this the similarity that fits best.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from bath_drake.composition.conditioning import NUMBERS, Conditioning, bells
from bath_drake.learning.alignment import Alignment
from bath_drake.learning.strokes import extent
from bath_drake.notation import FloatArray

# Width of the bells, and variance of what no start explains, in units of the starts'
# own spread and of the process's variance.
WIDTH, NOISE = 2.0, 0.85
# Share of an offset that turns and stretches the stroke; the rest fades out evenly.
TURNED = 0.3
# Starts farther out than this many times the farthest demonstration's are not trusted.
REACH = 1.5
# A stroke whose ends are nearer than this share of its size cannot be turned by them.
_APART = 0.5


def fit_conditioning(aligned: Alignment, cuts: Sequence[int]) -> Conditioning:
    """Similarities of the stages between ``cuts`` of the mean, the ends included.

    Args:
        aligned: Demonstrations that end at one goal.
        cuts: Indices 0 = i_0 < i_1 < ... < i_K = T - 1 of the mean.
    """
    mean = aligned.mean
    starts = aligned.points[:, 0]
    offsets = starts - mean[0]
    spread = float(np.sqrt((offsets**2).sum(axis=1).mean()))
    size = extent(mean)
    spread = max(spread, 1e-3 * size)
    fade = _fading(mean, size)
    basis = np.array([_times(fade, unit) for unit in np.eye(2)])
    share = np.linspace(0.0, 1.0, len(mean))
    ramps = np.array([share[:, None] * unit for unit in np.eye(2)])
    width = WIDTH * spread
    kernel = np.array([bells(q, starts, width) for q in starts])
    kernel += NOISE * np.eye(len(starts))
    rest = aligned.points - mean - np.einsum("da,atb->dtb", offsets, basis)
    weights = np.linalg.solve(kernel, rest.reshape(len(starts), -1))
    curves = np.concatenate([basis, ramps, weights.reshape(rest.shape)])
    pivots, coefficients = [], []
    last = len(cuts) - 2
    for k, (first, stop) in enumerate(pairwise(cuts)):
        piece = slice(first, stop + 1)
        emphasis = np.ones(stop + 1 - first)
        if k == 0:
            emphasis[0] = len(emphasis)  # the start is where the motion is
        pivot = mean[-1] if k == last else np.average(mean[piece], 0, emphasis)
        pivots.append(pivot)
        fit = [
            _similarity(mean[piece] - pivot, curve[piece], emphasis, k == last)
            for curve in curves
        ]
        numbers = np.array(fit).T
        if k == last:
            numbers[2:, 2:4] = np.eye(2)  # the goal moves as it is told to
        coefficients.append(numbers)
    return Conditioning(
        start=mean[0],
        goal=mean[-1],
        starts=starts,
        width=width,
        reach=REACH * max(float(np.hypot(*offsets.T).max()), spread),
        pivots=np.array(pivots),
        coefficients=np.array(coefficients),
    )


def _fading(mean: FloatArray, size: float) -> FloatArray:
    """What is left of a start's offset along the mean, complex numbers as (T, 2)."""
    share = np.linspace(0.0, 1.0, len(mean))
    even = np.stack([1.0 - share, np.zeros_like(share)], axis=-1)
    away = mean - mean[-1]
    gap = float(np.hypot(*away[0]))
    turned = TURNED * min(1.0, gap / (_APART * size))
    if turned == 0.0:
        return even
    square = gap * gap
    whole = np.stack(
        [away @ away[0], away @ np.array([-away[0, 1], away[0, 0]])], axis=-1
    )
    return np.asarray((1.0 - turned) * even + turned * whole / square)


def _times(z: FloatArray, unit: FloatArray) -> FloatArray:
    x, y = unit
    return np.stack([z[:, 0] * x - z[:, 1] * y, z[:, 1] * x + z[:, 0] * y], axis=-1)


def _similarity(
    away: FloatArray, moved: FloatArray, weights: FloatArray, fixed: bool
) -> FloatArray:
    """(re, im of stretch - 1, shift) that best move points by ``moved`` (n, 2).

    Args:
        away: The points from the pivot, which is their weighted mean unless ``fixed``.
        moved: By how much each shall move.
        weights: Of the points, (n,).
        fixed: The pivot stays.
    """
    numbers = np.zeros(NUMBERS)
    w = weights[:, None]
    if not fixed:
        numbers[2:] = np.average(moved, axis=0, weights=weights)
        moved = moved - numbers[2:]
    square = float((w * away**2).sum())
    across = np.stack([-away[:, 1], away[:, 0]], axis=-1)
    numbers[0] = (w * away * moved).sum() / square
    numbers[1] = (w * across * moved).sum() / square
    return numbers
