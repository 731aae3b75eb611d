"""What a learner needs to know about a set of strokes before it starts."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from bath_drake.errors import DemonstrationError
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.notation import FloatArray, IntArray


class Stroke(Protocol):
    """The part of a canonical demonstration that the learner reads."""

    @property
    def name(self) -> str:
        """What it is called in messages."""

    @property
    def points(self) -> FloatArray:
        """Points in N, shape (T, 2)."""

    @property
    def sha256(self) -> str:
        """Hash of the file it came from."""


@dataclass(frozen=True, eq=False)
class StrokeSet:
    """Demonstrations resampled by arc length and laid onto one goal.

    Attributes:
        points: Shape (D, T, 2), in N.
        mean: Their mean at equal shares of arc length, shape (T, 2).
        goal: The mean end, shape (2,); every demonstration ends there.
        offsets: How far each was moved for that, shape (D, 2).
        scale: The longest side of their joint box; Fréchet figures are
            divided by it.
        turning: Angle the mean's direction sweeps, without sign, rad.
    """

    points: FloatArray
    mean: FloatArray
    goal: FloatArray
    offsets: FloatArray
    scale: float
    turning: float

    @property
    def floor(self) -> float:
        """Mean Fréchet distance of the demonstrations to their mean, over scale."""
        each = [discrete_frechet(self.mean, d) for d in self.points]
        return float(np.mean(each)) / self.scale

    @property
    def length(self) -> float:
        """Arc length of the longest demonstration."""
        return float(np.linalg.norm(np.diff(self.points, axis=1), axis=2).sum(1).max())


def resample(points: FloatArray, count: int) -> FloatArray:
    """A polyline (n, 2) at ``count`` equal shares of its arc length."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    at = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(at, along, points[:, k]) for k in range(2)], axis=-1)


def gather_strokes(demonstrations: Sequence[Stroke], count: int = 160) -> StrokeSet:
    """Resamples demonstrations to ``count`` points and moves their ends together.

    Raises:
        DemonstrationError: There is none, or one has fewer than two points, a number
            that is not finite, or no length.
    """
    if not demonstrations:
        raise DemonstrationError("no demonstration given, at least one is needed")
    curves = []
    for d in demonstrations:
        points = np.asarray(d.points, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
            raise DemonstrationError(
                f"{d.name}: found points of shape {points.shape}, need (T >= 2, 2)"
            )
        if not np.isfinite(points).all():
            raise DemonstrationError(f"{d.name}: a point is not finite")
        if not np.ptp(points, axis=0).max() > 1e-6:
            raise DemonstrationError(f"{d.name}: the stroke has no length")
        curves.append(resample(points, count))
    stacked = np.stack(curves)
    goal = stacked[:, -1].mean(axis=0)
    offsets = goal - stacked[:, -1]
    stacked = stacked + offsets[:, None]
    stacked[:, -1] = goal  # exact, whatever the sum rounded to
    mean = resample(stacked.mean(axis=0), count)
    scale = float(np.ptp(stacked.reshape(-1, 2), axis=0).max())
    turning = float(np.abs(np.diff(headings(mean))).sum())
    return StrokeSet(stacked, mean, goal, offsets, scale, turning)


def subset(strokes: StrokeSet, members: IntArray) -> StrokeSet:
    """Some of the demonstrations, with a mean of their own; goal and scale stay."""
    points = strokes.points[members]
    mean = resample(points.mean(axis=0), points.shape[1])
    return StrokeSet(
        points,
        mean,
        strokes.goal,
        strokes.offsets[members],
        strokes.scale,
        float(np.abs(np.diff(headings(mean))).sum()),
    )


def extent(curve: FloatArray) -> float:
    """The size of a curve (T, 2), however it is turned: twice its farthest reach."""
    away = curve - curve.mean(axis=0)
    return 2.0 * float(np.hypot(*away.T).max())


def headings(curve: FloatArray, share: float = 0.06) -> FloatArray:
    """Directions along a curve (T, 2), unwrapped, over chords of a share of it."""
    reach = max(1, round(0.5 * share * len(curve)))
    last = len(curve) - 1
    i = np.arange(len(curve))
    chord = curve[np.minimum(i + reach, last)] - curve[np.maximum(i - reach, 0)]
    return np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
