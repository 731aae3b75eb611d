"""The marker's track on the back: cut to the stroke, its gaps filled or reported."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bath_drake.demonstrations.gaps import MAX_GAP, Gap, fill_gaps
from bath_drake.notation import BoolArray, FloatArray

# Before and after the stroke the hand comes and goes: it is further off the skin than
# in the middle of the stroke by this, m.
LIFTED = 0.03


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
    stretch = slice(first, last + 1)
    points, filled = points.copy(), np.zeros(len(t), dtype=np.bool_)
    points[stretch], filled[stretch], gaps = fill_gaps(
        t[stretch], points[stretch], reasons[stretch], max_gap
    )
    kept = np.flatnonzero(seen | filled)
    kept = kept[(kept >= first) & (kept <= last)]
    return CapturedStroke(t[kept], points[kept], filled[kept], gaps, first, last)
