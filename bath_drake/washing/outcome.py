"""What a run washed: coverage of the target, and what got wet that must not.

Coverage is the share of the target's area that was in the tool's footprint at least
once. The target is a box of canonical space or a band along a stroke, less what is to
be spared around wounds and given areas.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bath_drake.notation import BoolArray, FloatArray
from bath_drake.patient.wound import signed_polygon_distance
from bath_drake.washing.config import WashingConfig
from bath_drake.washing.places import SkinPlaces

_CM2 = 1e4


@dataclass(frozen=True, eq=False)
class WashOutcome:
    """n places of the back, and what was done to them.

    Attributes:
        places: The places.
        seconds: (n,) for how long each was under jet or sponge.
        target: (n,) whether it was to be washed.
        wounded: (n,) whether it lies in a wound or a given area.
    """

    places: SkinPlaces
    seconds: FloatArray
    target: BoolArray
    wounded: BoolArray

    @property
    def washed(self) -> BoolArray:
        """Whether each place was washed at all, shape (n,)."""
        return np.asarray(self.seconds > 0.0)

    @property
    def coverage(self) -> float | None:
        """Share of the target's area that was washed, 0 to 1; None without target."""
        target = self._area(self.target)
        return self._area(self.target & self.washed) / target if target > 0.0 else None

    def figures(self) -> dict[str, Any]:
        """The block `washing` of metrics.json; areas in cm^2, of the skin at rest."""
        washed = self.target & self.washed
        area = self._area(washed)
        seconds = float(self.places.areas[washed] @ self.seconds[washed])
        return {
            "target_cm2": _CM2 * self._area(self.target),
            "washed_cm2": _CM2 * area,
            "washed_besides_cm2": _CM2 * self._area(self.washed & ~self.target),
            "wound_cm2": _CM2 * self._area(self.wounded),
            "wound_wetted_cm2": _CM2 * self._area(self.wounded & self.washed),
            "seconds_per_place": seconds / area if area > 0.0 else None,
        }

    def _area(self, chosen: BoolArray) -> float:
        return float(self.places.areas[chosen].sum())


def wash_outcome(
    places: SkinPlaces,
    seconds: FloatArray,
    washing: WashingConfig,
    *,
    stroke: FloatArray,
    half_extents: FloatArray,
    wounds: Sequence[FloatArray],
    spared: float,
) -> WashOutcome:
    """Says what was to be washed, and puts it beside what was.

    Args:
        places: Of the back.
        seconds: (n,) of `bath_drake.washing.washed_places.washed_seconds`.
        washing: Has the target's box or band.
        stroke: (m, 2) the path that was asked for, in N: the band's middle.
        half_extents: (2,) of the true canonical map, m.
        wounds: Outlines (k, 2) of wounds and given areas in that map's plane, m.
        spared: Around them, m, not to be washed.
    """
    if washing.target_low is not None and washing.target_high is not None:
        inside = (places.p_N >= washing.target_low) & (
            places.p_N <= washing.target_high
        )
        target = inside.all(axis=1)
    else:
        target = path_distance(places.plane, stroke * half_extents) <= washing.band
    wounded = np.zeros(len(places), dtype=bool)
    for outline in wounds:
        distance = signed_polygon_distance(places.plane, outline)
        wounded |= distance < 0.0
        target &= distance >= spared
    return WashOutcome(places, seconds, np.asarray(target), wounded)


def path_distance(points: FloatArray, path: FloatArray) -> FloatArray:
    """Distance (n,) of points (n, 2) to a polygonal path (m >= 2, 2)."""
    best = np.full(len(points), np.inf)
    for start, end in itertools.pairwise(path):
        edge, offset = end - start, points - start
        share = np.clip(offset @ edge / max(float(edge @ edge), 1e-300), 0.0, 1.0)
        np.minimum(best, ((offset - share[:, None] * edge) ** 2).sum(axis=1), out=best)
    return np.asarray(np.sqrt(best))
