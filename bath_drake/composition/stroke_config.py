"""Several strokes that are washed in turn, as a schema for scenario files."""

import math
from dataclasses import dataclass, field

# Canonical: of a stroke, and between two lanes.
_SHORTEST_STROKE, _LEAST_SPACING = 0.05, 0.05


@dataclass(kw_only=True)
class StrokeConfig:
    """One of several strokes that are washed in turn."""

    start: list[float] = field(default_factory=lambda: [-0.6, 0.0])  # canonical
    goal: list[float] = field(default_factory=lambda: [0.6, 0.0])  # canonical
    skill: str | None = None  # a path or a name as the scenario's; null: the scenario's


@dataclass(kw_only=True)
class LanesConfig:
    """Strokes to and fro across a box of canonical space, from below upwards."""

    low: list[float] = field(default_factory=lambda: [-0.6, -0.5])
    high: list[float] = field(default_factory=lambda: [0.6, 0.5])
    spacing: float = 0.17  # canonical, at most


def check_strokes(strokes: list[StrokeConfig], lanes: LanesConfig | None) -> None:
    """Raises ValueError naming the key that makes no stroke, and what is allowed."""
    for k, stroke in enumerate(strokes):
        for key in ("start", "goal"):
            _check_corner(f"strokes[{k}].{key}", getattr(stroke, key))
        if math.dist(stroke.start, stroke.goal) < _SHORTEST_STROKE:
            raise ValueError(
                f"strokes[{k}].goal: found {stroke.goal}, allowed {_SHORTEST_STROKE} or"
                f" more from the start"
            )
    if lanes is None:
        return
    if strokes:
        raise ValueError("lanes: found beside strokes, allowed one of the two")
    _check_corner("lanes.low", lanes.low)
    _check_corner("lanes.high", lanes.high)
    if not _LEAST_SPACING <= lanes.spacing <= 1.0:
        raise ValueError(
            f"lanes.spacing: found {lanes.spacing}, allowed {_LEAST_SPACING} to 1.0"
        )
    if not all(a < b for a, b in zip(lanes.low, lanes.high, strict=True)):
        raise ValueError(
            f"lanes.high: found {lanes.high}, allowed more than lanes.low {lanes.low}"
        )


def _check_corner(key: str, point: list[float]) -> None:
    if len(point) != 2 or not all(-1.0 <= value <= 1.0 for value in point):
        raise ValueError(f"{key}: found {point}, allowed two numbers of -1 to 1")
