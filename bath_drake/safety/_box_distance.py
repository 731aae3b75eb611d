"""Capsules of an arm against boxes, compiled; all in the arm's base frame B."""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray, IntArray
from bath_drake.safety.arm_chain import link_frames, place_segment, slope_of_turn

ArmArrays = tuple[FloatArray, FloatArray, FloatArray]
BoxArrays = tuple[FloatArray, FloatArray, FloatArray, IntArray]

# The nearest place along a segment is found by golden sections: to 0.618^n of it.
_GOLDEN, _SECTIONS = 0.5 * (np.sqrt(5.0) - 1.0), 16


@njit(cache=True)
def gaps(
    q: FloatArray, arm: ArmArrays, boxes: BoxArrays, near: float, rows: FloatArray
) -> None:
    """Writes for each capsule its distance from the nearest box, and how it changes.

    Args:
        q: (7,) rad.
        arm: Origins, turns and capsules (n, 8) as of `ArmChain`.
        boxes: Axes, centres, halves and minded as of `Boxes`.
        near: Of what is farther than this a bound from below is told alone, m.
        rows: (n, 8) out: the distance, m, and its derivatives by the joints' positions,
            m/rad, zero where it is farther than `near`.
    """
    origins, turns, capsules = arm
    axes, centres, halves, minded = boxes
    joints = len(q)
    R, p = link_frames(q, origins, turns)
    ends = np.empty((2, 3))
    point, away, best, best_away = (
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.empty(3),
    )
    for k in range(len(capsules)):
        link = place_segment(R, p, capsules[k], ends)
        length = ((ends[1] - ends[0]) ** 2).sum()
        reach = 0.5 * np.sqrt(length) + capsules[k, 7]
        least, close = np.inf, False
        for m in range(len(centres)):
            if link < minded[m, 0] or link > minded[m, 1]:
                continue
            gap = _gap(ends, 0.5, axes[m], centres[m], halves[m], point, away) - reach
            # No place on it is nearer than from its middle, less the way there.
            if gap > near:
                if gap < least:
                    least, close = gap, False
                continue
            if gap >= least:
                continue
            nearest = _nearest(ends, axes[m], centres[m], halves[m], point, away)
            gap = _gap(ends, nearest, axes[m], centres[m], halves[m], point, away)
            gap -= capsules[k, 7]
            if gap < least:
                least, close = gap, gap <= near
                for i in range(3):
                    best[i], best_away[i] = point[i], away[i]
        rows[k, 0] = least
        for j in range(joints):
            rows[k, 1 + j] = 0.0
            if close and j < link:
                rows[k, 1 + j] = slope_of_turn(R, p, j, best, best_away)


@njit(cache=True)
def least_gap(
    q: FloatArray,
    way: FloatArray,
    looks: int,
    arm: ArmArrays,
    boxes: BoxArrays,
    far: float,
) -> float:
    """The least of all distances at some places from q (7,) to q + way, at most far."""
    least = far
    rows = np.empty((len(arm[2]), 1 + len(q)))
    for look in range(looks):
        gaps(q + look / max(looks - 1, 1) * way, arm, boxes, least, rows)
        for gap in rows[:, 0]:
            least = min(least, gap)
    return least


@njit(cache=True)
def _nearest(
    ends: FloatArray,
    axes: FloatArray,
    centre: FloatArray,
    half: FloatArray,
    point: FloatArray,
    away: FloatArray,
) -> float:
    """Which share of a segment is nearest to a box."""
    low, high = 0.0, 1.0
    a, b = 1.0 - _GOLDEN, _GOLDEN
    at_a = _gap(ends, a, axes, centre, half, point, away)
    at_b = _gap(ends, b, axes, centre, half, point, away)
    for _ in range(_SECTIONS):
        if at_a < at_b:
            high, b, at_b = b, a, at_a
            a = high - _GOLDEN * (high - low)
            at_a = _gap(ends, a, axes, centre, half, point, away)
        else:
            low, a, at_a = a, b, at_b
            b = low + _GOLDEN * (high - low)
            at_b = _gap(ends, b, axes, centre, half, point, away)
    return 0.5 * (low + high)


@njit(cache=True)
def _gap(
    ends: FloatArray,
    share: float,
    axes: FloatArray,
    centre: FloatArray,
    half: FloatArray,
    point: FloatArray,
    away: FloatArray,
) -> float:
    """The signed distance of a place on a segment from a box; convex along it."""
    for i in range(3):
        point[i] = ends[0, i] + share * (ends[1, i] - ends[0, i])
        away[i] = 0.0
    outside, inside, face, side = 0.0, -np.inf, 0, 1.0
    for j in range(3):
        local = 0.0
        for i in range(3):
            local += axes[i, j] * (point[i] - centre[i])
        sign = 1.0 if local > 0.0 else -1.0
        over = abs(local) - half[j]
        if over > inside:
            inside, face, side = over, j, sign
        if over > 0.0:
            outside += over * over
            for i in range(3):
                away[i] += sign * over * axes[i, j]
    if outside > 0.0:
        gap = np.sqrt(outside)
        for i in range(3):
            away[i] /= gap
        return float(gap)
    for i in range(3):
        away[i] = side * axes[i, face]
    return float(inside)
