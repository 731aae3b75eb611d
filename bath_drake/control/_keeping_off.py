"""What `bath_drake.control.avoidance` does, compiled; rows are those of `link_gaps`."""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray

# Singular values below such a share of the greatest are lost; m^2/rad^2 below which no
# motion in the null space moves a link; how often the worst link is looked after.
_LOST, _FLAT, _BENDS = 1e-2, 1e-4, 6
# m^2/rad^2 below which a link is nobody's to push: no joint moves it away.
_UNMOVED = 1e-6


@njit(cache=True)
def push_away(rows: FloatArray, near: float, gain: float, most: float) -> FloatArray:
    """Returns joint velocities (7,), rad/s, that take links away, at most so fast."""
    push = np.zeros(rows.shape[1] - 1)
    for n in range(len(rows)):
        if not rows[n, 0] < near:
            continue
        size = 0.0
        for k in range(len(push)):
            size += rows[n, 1 + k] ** 2
        if size > _UNMOVED:
            for k in range(len(push)):
                push[k] += rows[n, 1 + k] * (gain * (near - rows[n, 0]) / size)
    fastest = 0.0
    for k in range(len(push)):
        fastest = max(fastest, abs(push[k]))
    if fastest > most:
        push *= most / fastest
    return push


@njit(cache=True)
def bend(
    v: FloatArray, J: FloatArray, rows: FloatArray, stop: float, gain: float
) -> FloatArray:
    """Returns what to add to v (7,), rad/s, in the null space of J (5, 7)."""
    added = np.zeros(len(v))
    if damped_share(v, rows, stop, gain) == 1.0:
        return added
    free = np.eye(len(v)) - np.linalg.pinv(J, _LOST) @ J
    for _ in range(_BENDS):
        worst, most = 0, -np.inf
        for n in range(len(rows)):
            missing = -_allowed(rows[n, 0], stop, gain)
            for k in range(len(v)):
                missing -= rows[n, 1 + k] * (v[k] + added[k])
            if missing > most:
                worst, most = n, missing
        slope = rows[worst, 1:] @ free
        size = slope @ slope
        if most <= 0.0 or size < _FLAT:
            break
        added += slope * (most / size)
    return added


@njit(cache=True)
def reachable_share(
    start: FloatArray, change: FloatArray, low: FloatArray, high: FloatArray
) -> float:
    """Returns how much of a change (7,) keeps within bounds (7,), 0 to 1."""
    share = 1.0
    for k in range(len(change)):
        size = abs(change[k])
        if size > 1e-12:
            room = high[k] - start[k] if change[k] > 0.0 else start[k] - low[k]
            share = min(share, max(room, 0.0) / size)
    return share


@njit(cache=True)
def damped_share(v: FloatArray, rows: FloatArray, stop: float, gain: float) -> float:
    """Returns how much of v (7,), rad/s, may be gone: from 0 to 1."""
    share = 1.0
    for n in range(len(rows)):
        nearing = 0.0
        for k in range(len(v)):
            nearing -= rows[n, 1 + k] * v[k]
        allowed = _allowed(rows[n, 0], stop, gain)
        if nearing > allowed:
            share = min(share, allowed / nearing)
    return share


@njit(cache=True)
def _allowed(gap: float, stop: float, gain: float) -> float:
    """How fast a link may near what it is next to, m/s."""
    return gain * max(gap - stop, 0.0)
