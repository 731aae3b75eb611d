"""How near links that must not touch are to each other, and how that changes."""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray, IntArray
from bath_drake.safety.arm_chain import (
    ArmChain,
    link_frames,
    place_segment,
    slope_of_turn,
)
from bath_drake.safety.limits import JOINTS
from bath_drake.safety.self_distance import nearest_shares

# m: of capsules whose segments meet no direction apart can be told.
_MEET = 1e-9


def self_gaps(q: FloatArray, arm: ArmChain, near: float) -> FloatArray:
    """Returns the near pairs' distances, and their derivatives.

    Args:
        q: (7,) joint positions, rad.
        arm: Whose `pairs` are looked at.
        near: Pairs farther apart than this are left out, m.

    Returns:
        (n, 8) distance, m, negative where capsules overlap; its derivatives by the
        joints' positions, m/rad. As of `bath_drake.safety.obstacle_distance.link_gaps`.

    Raises:
        ValueError: If q is not of shape (7,).
    """
    q = np.ascontiguousarray(q, dtype=np.float64)
    if q.shape != (JOINTS,):
        raise ValueError(f"q must have shape ({JOINTS},), got {q.shape}")
    rows = np.empty((len(arm.pairs), 1 + JOINTS))
    count = write_gaps(q, arm.origins, arm.turns, arm.capsules, arm.pairs, near, rows)
    return rows[:count]


@njit(cache=True)
def write_gaps(
    q: FloatArray,
    origins: FloatArray,
    turns: FloatArray,
    capsules: FloatArray,
    pairs: IntArray,
    near: float,
    rows: FloatArray,
) -> int:
    """Writes the rows (n, 8) of near pairs; returns how many. See `self_gaps`."""
    R, p = link_frames(q, origins, turns)
    ends = np.empty((len(capsules), 2, 3))
    for k in range(len(capsules)):
        place_segment(R, p, capsules[k], ends[k])
    outer, away = np.empty(3), np.empty(3)
    count = 0
    for k in range(len(pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        s, t = nearest_shares(ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1])
        apart2 = 0.0
        for x in range(3):
            inner = ends[i, 0, x] + s * (ends[i, 1, x] - ends[i, 0, x])
            outer[x] = ends[j, 0, x] + t * (ends[j, 1, x] - ends[j, 0, x])
            away[x] = outer[x] - inner
            apart2 += away[x] * away[x]
        apart = np.sqrt(apart2)
        gap = apart - capsules[i, 7] - capsules[j, 7]
        if gap > near:
            continue
        rows[count, 0] = gap
        first, last = int(capsules[i, 0]), int(capsules[j, 0])
        for joint in range(len(q)):
            rows[count, 1 + joint] = 0.0
            # What moves both does not move them apart.
            if first <= joint < last and apart > _MEET:
                slope = slope_of_turn(R, p, joint, outer, away)
                rows[count, 1 + joint] = slope / apart
        count += 1
    return count
