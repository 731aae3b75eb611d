"""Restricted areas beside virtual obstacles: which give way, and by how much."""

import numpy as np

from bath_drake.field.obstacles import ObstacleSet, pair_gaps, support
from bath_drake.notation import FloatArray

# Between an area and a virtual obstacle or an intermediate goal, in N.
GAP = 0.05
_SHRINK, _SMALLEST = 0.85, 0.15


def make_room(
    virtual: ObstacleSet, areas: ObstacleSet, gap: float = GAP
) -> ObstacleSet:
    """Shrinks virtual obstacles until each keeps `gap` to every area.

    One that would have to shrink to less than a seventh is dropped.
    """
    rows, exponents = [], []
    for row, exponent in zip(virtual.theta, virtual.powers, strict=True):
        scale = 1.0
        while scale > _SMALLEST:
            shrunk = row.copy()
            shrunk[2:4] *= scale
            pair = ObstacleSet(np.vstack([shrunk, areas.theta]))
            if pair_gaps(pair)[0, 1:].min() >= gap:
                rows.append(shrunk)
                exponents.append(exponent)
                break
            scale *= _SHRINK
    return ObstacleSet(np.array(rows).reshape(-1, 5), np.array(exponents))


def inflated(areas: ObstacleSet, slack: float) -> ObstacleSet:
    """Returns areas with `slack` added to both semi-axes, in N."""
    theta = areas.theta.copy()
    theta[:, 2:4] += slack
    return ObstacleSet(theta, areas.powers)


def contain(outer: ObstacleSet, inner: ObstacleSet, directions: int = 90) -> bool:
    """Whether each ellipse lies within the outer one of the same index."""
    if len(outer) != len(inner):
        return False
    turns = np.linspace(0.0, 2.0 * np.pi, directions, endpoint=False)
    n = np.stack([np.cos(turns), np.sin(turns)], axis=1)

    def reach(areas: ObstacleSet) -> FloatArray:
        return np.asarray(n @ areas.theta[:, :2].T + support(areas, n))

    return bool((reach(inner) <= reach(outer)).all())
