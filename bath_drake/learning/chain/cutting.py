"""Where a stroke is cut into stages, and the gates there.

A field's flow bends gladly once, and badly where it first leads away from its goal. So
each stage gets an equal share of the stroke's turning (and a little of its length),
and is cut where the stroke is straightest nearby: a hand-over is then the same
motion before and after it.
"""

import math

import numpy as np

from bath_drake.composition.chain import Gate
from bath_drake.learning.strokes import extent, headings
from bath_drake.notation import FloatArray

# A stroke's length, in units of its size, weighs like this much turning, rad.
_LENGTH = 0.5
# How far, in shares of a stage, a cut may move to a straighter place.
_SLACK = 0.25
# The goal of a stage lies this far beyond its gate, in N.
BEYOND = 0.10
# The gate reaches so much farther than the goal.
MARGIN = 0.03


def stage_count(curve: FloatArray, turning: float) -> int:
    """How many stages give each at most ``turning``, rad, of a curve (T, 2)."""
    total = float(np.abs(np.diff(headings(curve))).sum())
    return max(1, math.ceil(total / turning))


def cut(curve: FloatArray, count: int) -> tuple[int, ...]:
    """Indices at which a curve (T, 2) is cut into stages, both ends included.

    There may be fewer stages than ``count`` where no room is left between two cuts.
    """
    last = len(curve) - 1
    turn = np.abs(np.diff(headings(curve)))
    steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    effort = turn + _LENGTH / extent(curve) * steps
    effort = np.concatenate([[0.0], np.cumsum(effort)])
    effort /= effort[-1]
    window = np.hanning(15)
    bend = np.convolve(np.pad(turn, 7, mode="edge"), window / window.sum(), "valid")
    bend = np.append(bend, bend[-1])
    cuts = [0]
    for k in range(1, count):
        off = np.abs(effort * count - k)
        near = np.flatnonzero(off <= _SLACK)
        if not len(near):
            near = np.array([int(np.argmin(off))])
        # Between equally straight places the more even cut is taken.
        best = near[np.argmin(bend[near] + 2e-3 * off[near])]
        if cuts[-1] + 4 <= best <= last - 4:
            cuts.append(int(best))
    return (*cuts, last)


def gate_at(curve: FloatArray, at: int, before: int) -> tuple[Gate, FloatArray]:
    """The gate at a point of a curve (T, 2), and the goal (2,) beyond it.

    It is as large as it may be without holding a part of the stage before it, which
    begins at index ``before``: the motion would leave the stage too early.
    """
    reach = min(4, at - before, len(curve) - 1 - at)
    direction = curve[at + reach] - curve[at - reach]
    direction = direction / np.hypot(*direction)
    earlier = curve[before : max(before + 1, at - 2)] - curve[at]
    ahead = earlier @ direction >= 0.0
    room = np.inf
    if ahead.any():
        room = max(float(np.hypot(*earlier[ahead].T).min()) - 0.02, 0.06)
    radius = min(BEYOND + MARGIN, room)
    goal = curve[at] + min(BEYOND, radius - 0.5 * MARGIN) * direction
    return Gate(curve[at], direction, radius), goal
