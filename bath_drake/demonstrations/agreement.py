"""Which of several demonstrations do not belong to the others, and why.

One skill has one goal: demonstrations are moved as wholes until all end there. One that
was broken off, goes the other way round or is there twice would move the goal for all.
"""

from collections.abc import Sequence

import numpy as np

from bath_drake.notation import FloatArray

# Ends that differ by more than this share of the strokes' scale are not one goal.
ENDS_APART = 0.2
# So many must agree for another to be called a stray.
QUORUM = 2


def find_strays(
    starts: FloatArray,
    ends: FloatArray,
    scale: float,
    names: Sequence[str],
    hashes: Sequence[str],
) -> dict[int, str]:
    """Finds demonstrations to leave out; of two alone none is.

    Args:
        starts: Where each begins, shape (D, 2), in N.
        ends: Where each ends by itself, shape (D, 2), in N.
        scale: Longest side of their joint box, in N.
        names: What they are called.
        hashes: Of their files.

    Returns:
        The reason by index.
    """
    reasons: dict[int, str] = {}
    for i, digest in enumerate(hashes):
        first = list(hashes).index(digest)
        if first < i and digest:
            reasons[i] = f"is the same recording as {names[first]}"
    once = [i for i in range(len(ends)) if i not in reasons]
    goal = np.median(ends[once], axis=0)
    away = np.linalg.norm(ends - goal, axis=1) / scale
    agree = [i for i in once if away[i] <= ENDS_APART]
    if len(agree) < max(QUORUM, len(once) / 2.0):
        return reasons
    begin = np.median(starts[agree], axis=0)
    for i in once:
        if i in agree:
            continue
        there = np.linalg.norm(starts[i] - goal) <= ENDS_APART * scale
        back = np.linalg.norm(ends[i] - begin) <= ENDS_APART * scale
        if there and back:
            reasons[i] = "goes the other way round: it starts where the others end"
        else:
            reasons[i] = (
                f"ends {away[i]:.2f} of the strokes' scale away from where the others "
                f"do, allowed: {ENDS_APART} (broken off, or another stroke?)"
            )
    return reasons
