"""Times in which a recording saw nothing: short ones are filled, long ones reported."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from bath_drake.notation import BoolArray, FloatArray

# Gaps up to this long are filled, s.
MAX_GAP = 0.2
# Samples on either side of a gap that say how the hand moved through it.
NEIGHBOURS = 4


@dataclass(frozen=True)
class Gap:
    """A time without samples inside a stroke.

    Attributes:
        start: Of the last sample before, s.
        end: Of the first sample after, s.
        reason: Why there are none.
        filled: Whether samples stand in for it.
    """

    start: float
    end: float
    reason: str
    filled: bool


def fill_gaps(
    t: FloatArray,
    points: FloatArray,
    reasons: Sequence[str] | None = None,
    max_gap: float = MAX_GAP,
) -> tuple[FloatArray, BoolArray, tuple[Gap, ...]]:
    """Closes the short gaps between the first and the last sample that is there.

    Args:
        t: (n,) times, s, increasing.
        points: (n, d) m; rows with NaN where nothing was seen.
        reasons: (n) why, where nothing was seen.
        max_gap: Longer gaps stay open, s; from the last sample before a gap to the
            first after it, less the usual step from sample to sample.

    Returns:
        The points, (n,) which of them stand in for a gap, and all gaps.
    """
    seen: BoolArray = np.asarray(np.isfinite(points).all(axis=1))
    points, filled = points.copy(), np.zeros(len(t), dtype=np.bool_)
    there = np.flatnonzero(seen)
    step = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    gaps = []
    for start, end in pairwise(there.tolist()):
        if end == start + 1:
            continue
        # Rounding of the file's times must not make a gap too long.
        close = bool(t[end] - t[start] - step <= max_gap + 1e-3 * step)
        if close:
            points[start + 1 : end] = _between(t, points, seen, start, end)
            filled[start + 1 : end] = True
        inside = [] if reasons is None else list(reasons[start + 1 : end])
        reason = max(set(inside), key=lambda why: (inside.count(why), why), default="")
        gaps.append(Gap(float(t[start]), float(t[end]), reason, close))
    return points, filled, tuple(gaps)


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
