"""How near links of the arm that must not touch come to each other.

Each link is a capsule (a segment and a radius) around its collision mesh: less than the
truth is told, never more. Of a Franka Research 3 with the shower nozzle.
"""

from math import isfinite, nan

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray, IntArray
from bath_drake.safety.limits import JOINTS

# s. The fastest joint of the guard's limits (2.63 rad/s, 10 rad/s^2) goes on for 0.13 s
# of its speed while it brakes.
LOOKAHEAD = 0.15
# Places on the way there that are looked at, the first and last included.
_LOOKS = 3

# Each joint's origin in the link before it, m, and sine and cosine of its turn about x.
_ORIGINS = np.array(
    [
        [0.0, 0.0, 0.333],
        [0.0, 0.0, 0.0],
        [0.0, -0.316, 0.0],
        [0.0825, 0.0, 0.0],
        [-0.0825, 0.384, 0.0],
        [0.0, 0.0, 0.0],
        [0.088, 0.0, 0.0],
    ]
)
_TURNS = np.array([0.0, -1.0, 1.0, 1.0, -1.0, 1.0, 1.0])
# Of the nozzle along link 7's z, m: it is counted as link 8.
_FLANGE = 0.107
NOZZLE = 8
# Link; its segment's two ends in the link's frame; its radius, m. Least in volume.
CAPSULES = np.array(
    [
        [0, -0.056, -0.002, 0.023, -0.006, 0.000, 0.053, 0.109],
        [1, 0.000, 0.001, -0.139, 0.002, -0.054, 0.003, 0.079],
        [2, -0.001, 0.000, 0.053, 0.000, -0.142, 0.001, 0.078],
        [3, 0.093, 0.048, 0.007, -0.010, -0.007, -0.093, 0.071],
        [4, -0.002, -0.001, 0.043, -0.086, 0.082, -0.002, 0.073],
        [5, 0.000, 0.066, 0.002, 0.001, 0.012, -0.244, 0.069],
        [6, 0.020, 0.007, 0.015, 0.087, 0.009, 0.001, 0.078],
        [7, -0.003, -0.003, 0.076, 0.031, 0.031, 0.084, 0.052],
        [8, 0.000, 0.000, 0.006, 0.000, 0.000, 0.150, 0.033],
        [8, 0.000, 0.000, 0.150, 0.125, 0.000, 0.150, 0.030],
    ]
)
# A sponge on the nozzle's tip, counted with it.
SPONGE = np.array([[8, 0.140, 0.000, 0.150, 0.170, 0.000, 0.150, 0.033]])
# Pairs of links with so many joints between them: nearer ones meet in a joint, or its
# range keeps them apart.
_APART = 3
# The nozzle and link 5 stayed 10 mm apart in 3000 random postures: link 6 is between.
_NOZZLE_APART = 4


def _capsule_pairs(capsules: FloatArray) -> IntArray:
    links = capsules[:, 0].astype(np.int64)
    return np.array(
        [
            (i, j)
            for i in range(len(links))
            for j in range(i + 1, len(links))
            if links[j] - links[i] >= (_NOZZLE_APART if links[j] == NOZZLE else _APART)
        ]
    )


PAIRS = _capsule_pairs(CAPSULES)
# Capsules and their pairs, by the arm's tool.
TOOLS = {
    "nozzle": (CAPSULES, PAIRS),
    "sponge": (
        np.concatenate([CAPSULES, SPONGE]),
        _capsule_pairs(np.concatenate([CAPSULES, SPONGE])),
    ),
}


def self_distance(q: FloatArray) -> float:
    """Returns the least distance, m, of links that must not touch.

    Args:
        q: (7,) joint positions, rad.

    Returns:
        Less than the truth by what the capsules are too fat; negative where they
        overlap, NaN where a position is no finite number.

    Raises:
        ValueError: If q is not of shape (7,).
    """
    return self_distance_ahead(q, np.zeros(JOINTS), 0.0)


def self_distance_ahead(
    q: FloatArray, v: FloatArray, lookahead: float = LOOKAHEAD, tool: str = "nozzle"
) -> float:
    """Returns the least `self_distance`, m, on the way the arm takes while it brakes.

    Args:
        q: (7,) joint positions, rad.
        v: (7,) joint velocities, rad/s.
        lookahead: For how long it goes on at its speed, s.
        tool: One of `TOOLS`.

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
    return float(_least(q, way, looks, _ORIGINS, _TURNS, _FLANGE, *TOOLS[tool]))


def capsule_ends(q: FloatArray) -> FloatArray:
    """Returns both ends of every capsule's segment, (n, 2, 3), in the arm's base B."""
    q = np.ascontiguousarray(q, dtype=np.float64)
    ends: FloatArray = _ends(q, _ORIGINS, _TURNS, _FLANGE, CAPSULES)
    return ends


@njit(cache=True)
def _ends(
    q: FloatArray,
    origins: FloatArray,
    turns: FloatArray,
    flange: float,
    capsules: FloatArray,
) -> FloatArray:
    ends = np.empty((len(capsules), 2, 3))
    R, turned, p = np.eye(3), np.empty((3, 3)), np.zeros(3)
    link = 0
    for k in range(len(capsules)):
        while link < capsules[k, 0]:
            if link == len(q):
                for i in range(3):
                    p[i] += R[i, 2] * flange
            else:
                s, c = np.sin(q[link]), np.cos(q[link])
                sa = turns[link]
                ca = 1.0 - abs(sa)
                for i in range(3):
                    for j in range(3):
                        p[i] += R[i, j] * origins[link, j]
                    across = ca * R[i, 1] + sa * R[i, 2]
                    turned[i, 0] = c * R[i, 0] + s * across
                    turned[i, 1] = c * across - s * R[i, 0]
                    turned[i, 2] = ca * R[i, 2] - sa * R[i, 1]
                R[:] = turned
            link += 1
        for end in range(2):
            for i in range(3):
                ends[k, end, i] = p[i]
                for j in range(3):
                    ends[k, end, i] += R[i, j] * capsules[k, 1 + 3 * end + j]
    return ends


@njit(cache=True)
def _least(
    q: FloatArray,
    way: FloatArray,
    looks: int,
    origins: FloatArray,
    turns: FloatArray,
    flange: float,
    capsules: FloatArray,
    pairs: IntArray,
) -> float:
    least = np.inf
    for look in range(looks):
        there = q + look / max(looks - 1, 1) * way
        ends = _ends(there, origins, turns, flange, capsules)
        for k in range(len(pairs)):
            i, j = pairs[k, 0], pairs[k, 1]
            gap = _segments(ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1])
            least = min(least, gap - capsules[i, 7] - capsules[j, 7])
    return least


@njit(cache=True)
def _segments(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> float:
    """The distance of two segments ab and cd, neither a point."""
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
    gap2 = 0.0
    for k in range(3):
        gap2 += (a[k] - c[k] + s * (b[k] - a[k]) - t * (d[k] - c[k])) ** 2
    return float(np.sqrt(gap2))
