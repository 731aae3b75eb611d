"""Demonstrations that go different ways, and those that go astray."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bath_drake.learning.frechet import discrete_frechet
from bath_drake.notation import FloatArray, IntArray

# Demonstrations nearer than this share of the strokes' scale go the same way.
ALIKE = 0.35
# One that is alone is an outlier where so many others agree, if it starts this near to
# them, in shares of the scale: starts decide which way a motion goes.
_QUORUM, _BESIDE = 3, 0.2


@dataclass(frozen=True)
class Outlier:
    """A demonstration that is left out.

    Attributes:
        index: Which one, from 0.
        name: What it is called.
        reason: Why, in words.
    """

    index: int
    name: str
    reason: str


def group_strokes(
    strokes: FloatArray, scale: float, names: Sequence[str]
) -> tuple[tuple[IntArray, ...], tuple[Outlier, ...]]:
    """Groups strokes (D, T, 2) by the way they go.

    Two that are near by the Fréchet distance go the same way, and so do both's
    neighbours (single linkage). A stroke that is alone where three or more others agree
    is an outlier if it starts where they do; from elsewhere, or where demonstrations
    are that few, it is a way of its own.

    Returns:
        Each group's indices, the largest group first, and the outliers.
    """
    count = len(strokes)
    apart = np.zeros((count, count))
    for i in range(count):
        for j in range(i):
            apart[i, j] = apart[j, i] = discrete_frechet(strokes[i], strokes[j]) / scale
    labels = np.arange(count)
    for i in range(count):
        for j in range(i):
            if apart[i, j] < ALIKE:
                labels[labels == labels[i]] = labels[j]
    groups = [np.flatnonzero(labels == label) for label in dict.fromkeys(labels)]
    groups.sort(key=lambda group: (-len(group), int(group[0])))
    kept: list[IntArray] = []
    outliers = []
    for group in groups:
        i = int(group[0])
        starts = np.delete(strokes[:, 0], i, axis=0) - strokes[i, 0]
        beside = float(np.hypot(*starts.T).min(initial=np.inf)) <= _BESIDE * scale
        if len(group) > 1 or len(groups[0]) < _QUORUM or not beside:
            kept.append(group)
            continue
        nearest = float(np.delete(apart[i], i).min())
        outliers.append(
            Outlier(
                i,
                names[i],
                f"starts like others and goes another way: its Fréchet distance to the "
                f"nearest is {nearest:.2f} of the strokes' scale, allowed: below "
                f"{ALIKE}",
            )
        )
    return tuple(kept), tuple(outliers)
