"""How near links of the arm that must not touch come to each other.

Each link is in capsules (a segment and a radius each) around its collision meshes: less
than the truth is told, never more.
"""

from math import isfinite, nan

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray, IntArray
from bath_drake.safety.arm_chain import ArmChain, link_frames, place_segment
from bath_drake.safety.limits import JOINTS

# s. The fastest joint of the guard's limits (2.63 rad/s, 10 rad/s^2) goes on for 0.13 s
# of its speed while it brakes.
LOOKAHEAD = 0.15
# Places on the way there that are looked at, the first and last included.
_LOOKS = 3


def self_distance(q: FloatArray, arm: ArmChain) -> float:
    """Returns the least distance, m, of links that must not touch.

    Args:
        q: (7,) joint positions, rad.
        arm: Whose.

    Returns:
        Less than the truth by what the capsules are too fat; negative where they
        overlap, NaN where a position is no finite number.

    Raises:
        ValueError: If q is not of shape (7,).
    """
    return self_distance_ahead(q, np.zeros(JOINTS), arm, 0.0)


def self_distance_ahead(
    q: FloatArray, v: FloatArray, arm: ArmChain, lookahead: float = LOOKAHEAD
) -> float:
    """Returns the least `self_distance`, m, on the way the arm takes while it brakes.

    Args:
        q: (7,) joint positions, rad.
        v: (7,) joint velocities, rad/s.
        arm: Whose.
        lookahead: For how long it goes on at its speed, s.

    Returns:
        NaN where a position or velocity is no finite number.

    Raises:
        ValueError: If q or v is not of shape (7,), or lookahead is negative or not
            finite.
    """
    q = np.ascontiguousarray(q, dtype=np.float64)
    v = np.ascontiguousarray(v, dtype=np.float64)
    for name, value in (("q", q), ("v", v)):
        if value.shape != (JOINTS,):
            raise ValueError(f"{name} must have shape ({JOINTS},), got {value.shape}")
    if not (isfinite(lookahead) and lookahead >= 0.0):
        raise ValueError(f"lookahead must be >= 0 and finite, got {lookahead}")
    way = lookahead * v
    # A great number and a sum that is none are no positions either.
    if not np.isfinite(q + way).all():
        return nan
    looks = _LOOKS if way.any() else 1
    return float(_least(q, way, looks, arm.origins, arm.turns, arm.capsules, arm.pairs))


def capsule_ends(q: FloatArray, arm: ArmChain) -> FloatArray:
    """Returns both ends of every capsule's segment, (n, 2, 3), in the arm's base B."""
    q = np.ascontiguousarray(q, dtype=np.float64)
    ends: FloatArray = _ends(q, arm.origins, arm.turns, arm.capsules)
    return ends


@njit(cache=True)
def _ends(
    q: FloatArray,
    origins: FloatArray,
    turns: FloatArray,
    capsules: FloatArray,
) -> FloatArray:
    ends = np.empty((len(capsules), 2, 3))
    R, p = link_frames(q, origins, turns)
    for k in range(len(capsules)):
        place_segment(R, p, capsules[k], ends[k])
    return ends


@njit(cache=True)
def _least(
    q: FloatArray,
    way: FloatArray,
    looks: int,
    origins: FloatArray,
    turns: FloatArray,
    capsules: FloatArray,
    pairs: IntArray,
) -> float:
    least = np.inf
    for look in range(looks):
        there = q + look / max(looks - 1, 1) * way
        ends = _ends(there, origins, turns, capsules)
        for k in range(len(pairs)):
            i, j = pairs[k, 0], pairs[k, 1]
            gap = _segments(ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1])
            least = min(least, gap - capsules[i, 7] - capsules[j, 7])
    return least


@njit(cache=True)
def nearest_shares(
    a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray
) -> tuple[float, float]:
    """Which shares of segments ab and cd, neither a point, are nearest."""
    uu = vv = uv = uw = vw = 0.0
    for k in range(3):
        u, v, w = b[k] - a[k], d[k] - c[k], a[k] - c[k]
        uu, vv, uv = uu + u * u, vv + v * v, uv + u * v
        uw, vw = uw + u * w, vw + v * w
    det = uu * vv - uv * uv
    # Parallel ones: any place does, the other is then the nearest to it.
    s = (uv * vw - vv * uw) / det if det > 1e-12 * uu * vv else 0.0
    s = min(max(s, 0.0), 1.0)
    t = min(max((uv * s + vw) / vv, 0.0), 1.0)
    s = min(max((uv * t - uw) / uu, 0.0), 1.0)
    return s, t


@njit(cache=True)
def _segments(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> float:
    """The distance of two segments ab and cd, neither a point."""
    s, t = nearest_shares(a, b, c, d)
    gap2 = 0.0
    for k in range(3):
        gap2 += (a[k] - c[k] + s * (b[k] - a[k]) - t * (d[k] - c[k])) ** 2
    return float(np.sqrt(gap2))
