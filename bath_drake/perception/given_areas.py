"""Restricted areas that the carer gives, as polygons in canonical space.

What no camera tells from skin, a scar or a place that hurts, must be kept off all the
same. A polygon in N belongs to the body: it is on the same skin however that moves.
"""

from collections.abc import Sequence

import numpy as np

from bath_drake.field.obstacles import ObstacleSet
from bath_drake.notation import FloatArray
from bath_drake.perception.area_memory import merge_areas
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.ellipses import enclosing_ellipse

# The box of the back is [-1, 1]^2; an area may reach over its edge.
FURTHEST = 1.5


def check_polygon(corners: Sequence[Sequence[float]]) -> FloatArray:
    """Returns a polygon's corners (n, 2) in N.

    Raises:
        ValueError: Unless they are at least three, finite, within 1.5 of the middle
            along both axes, not on a line, and no two sides cross; says which.
    """
    try:
        points = np.array(corners, dtype=np.float64)
    except (TypeError, ValueError):
        points = np.zeros(0)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 3:
        raise ValueError(
            f"found {list(corners)}, allowed at least 3 corners of 2 numbers, [x, y]"
        )
    for k, point in enumerate(points):
        if not (np.isfinite(point).all() and (np.abs(point) <= FURTHEST).all()):
            raise ValueError(
                f"corner {k + 1}: found {point.tolist()}, allowed -{FURTHEST} to "
                f"{FURTHEST}; the box of the back is -1 to 1"
            )
    x, y = points.T
    area = abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2.0
    if not area > 1e-6:
        raise ValueError(f"found {points.tolist()}, allowed corners around an area")
    for i in range(len(points)):
        for j in range(i + 2, len(points)):
            if (j + 1) % len(points) != i and _cross(points, i, j):
                raise ValueError(f"sides {i + 1} and {j + 1} cross; allowed none")
    return points


def given_areas(
    polygons: Sequence[FloatArray], canonical_map: CanonicalMap, margin_m: float
) -> ObstacleSet:
    """Returns the least ellipses in N around polygons with a margin around each.

    Args:
        polygons: Corners (n, 2) of each, in N.
        canonical_map: How large the back is.
        margin_m: Kept around each along the back's plane, metres.

    Returns:
        The ellipses; of polygons whose ellipses meet, one around all of them.
    """
    areas = ObstacleSet()
    for corners in polygons:
        ellipse = enclosing_ellipse(corners * canonical_map.half_extents, margin_m)
        row = canonical_map.ellipse_to_canonical(ellipse)
        areas = merge_areas(areas, ObstacleSet(row[None]), tolerance=0.0)
    return areas


def _cross(points: FloatArray, i: int, j: int) -> bool:
    """Whether side i, from corner i to the next, meets side j."""
    a, b = points[i], points[(i + 1) % len(points)]
    c, d = points[j], points[(j + 1) % len(points)]

    def side(p: FloatArray, q: FloatArray, r: FloatArray) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) <= 0.0 and side(c, d, a) * side(c, d, b) <= 0.0
