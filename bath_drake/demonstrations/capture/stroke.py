"""The marker's track on the back: cut to the stroke, its gaps filled or reported."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from bath_drake.notation import BoolArray, FloatArray

# Gaps up to this long are filled, s.
MAX_GAP = 0.2
# Before and after the stroke the hand comes and goes: it is further off the skin than
# in the middle of the stroke by this, m.
LIFTED = 0.03
# Samples on either side of a gap that say how the hand moved through it.
NEIGHBOURS = 4


@dataclass(frozen=True)
class Gap:
    """A time without the marker inside a stroke.

    Attributes:
        start: Of the last frame before, s.
        end: Of the first frame after, s.
        reason: Why the marker was not seen.
        filled: Whether samples stand in for it.
    """

    start: float
    end: float
    reason: str
    filled: bool


@dataclass(frozen=True, eq=False)
class CapturedStroke:
    """A stroke on the back.

    Attributes:
        t: (n,) s.
        points: (n, 3) in the back's own frame, m.
        filled: (n,) samples that stand in for a gap.
        gaps: All gaps, filled or not.
        first: Index of its first frame.
        last: Index of its last one.
    """

    t: FloatArray
    points: FloatArray
    filled: BoolArray
    gaps: tuple[Gap, ...]
    first: int
    last: int

    @property
    def complete(self) -> bool:
        """Whether no gap is left open."""
        return all(gap.filled for gap in self.gaps)


def cut_stroke(
    t: FloatArray,
    points: FloatArray,
    heights: FloatArray,
    reasons: Sequence[str],
    max_gap: float = MAX_GAP,
) -> CapturedStroke | None:
    """Cuts a track to its stroke and closes its short gaps.

    Args:
        t: (n,) times, s.
        points: (n, 3) m; NaN where the marker was not seen.
        heights: (n,) the marker's distance from the skin, m.
        reasons: (n) why it was not seen, empty where it was.
        max_gap: Longer gaps stay open, s; from the last frame before a gap to the
            first after it, less the usual step from frame to frame.

    Returns:
        The stroke; None if the marker is never seen.
    """
    seen: BoolArray = np.isfinite(points[:, 0])
    if not seen.any():
        return None
    on_skin = seen & (np.nan_to_num(heights) <= np.median(heights[seen]) + LIFTED)
    first, last = (int(k) for k in np.flatnonzero(on_skin)[[0, -1]])
    step = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    points, filled = points.copy(), np.zeros(len(t), dtype=np.bool_)
    gaps = []
    k = first
    while k < last:
        if seen[k + 1]:
            k += 1
            continue
        end = k + 1 + int(np.argmax(seen[k + 1 :]))
        # Rounding of the file's times must not make a gap too long.
        close = bool(t[end] - t[k] - step <= max_gap + 1e-3 * step)
        if close:
            points[k + 1 : end] = _between(t, points, seen, k, end)
            filled[k + 1 : end] = True
        inside = list(reasons[k + 1 : end])
        reason = max(set(inside), key=lambda why: (inside.count(why), why))
        gaps.append(Gap(float(t[k]), float(t[end]), reason, close))
        k = end
    kept = np.flatnonzero(seen | filled)
    kept = kept[(kept >= first) & (kept <= last)]
    return CapturedStroke(t[kept], points[kept], filled[kept], tuple(gaps), first, last)


def _between(
    t: FloatArray, points: FloatArray, seen: BoolArray, start: int, end: int
) -> FloatArray:
    """Points of a smooth curve through those on both sides of a gap."""
    before = [k for k in range(max(start - NEIGHBOURS + 1, 0), start + 1) if seen[k]]
    after = [k for k in range(end, min(end + NEIGHBOURS, len(t))) if seen[k]]
    known = before + after
    curve = CubicSpline(t[known], points[known])
    wanted: FloatArray = curve(t[start + 1 : end])
    return wanted


def duration(gaps: Sequence[Gap]) -> float:
    """Returns how long gaps last together, s."""
    return math.fsum(gap.end - gap.start for gap in gaps)
