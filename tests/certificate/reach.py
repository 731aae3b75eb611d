"""Starts of regions, and what a proof of their region claims."""

import numpy as np
from basins import find_minima, least_beta, psi
from scipy.ndimage import label
from worlds import make

from bath_drake.certificate.result import Certificate
from bath_drake.field.navigation import NavigationField
from bath_drake.notation import FloatArray

# Proved only in part: the minimum lies behind the ellipse, at (-0.97537, 0).
BROADSIDE = make(10, [-0.5, 0, 0.2, 1.6, 0])
BEYOND = [[1.0, 0.5], [0.5, -1.0], [3.0, 2.0]]
BEHIND = [[-3.0, 0.2]]


def free_starts(field: NavigationField, count: int, seed: int) -> FloatArray:
    q = np.random.default_rng(seed).uniform(-5.0, 5.0, (count, 2))
    return q[least_beta(q, field) > 1e-3]


def near_goal(field: NavigationField, seed: int) -> FloatArray:
    """Three free points about the goal, nearer where it is narrow."""
    turns = np.random.default_rng(seed).uniform(-1.0, 1.0, (3, 2))
    reach = 2.0
    while True:
        q = field.goal + reach * turns
        if (least_beta(q, field) > 1e-3).all():
            return q
        reach /= 2.0


def below(field: NavigationField, level: float, seed: int) -> FloatArray:
    q = free_starts(field, 300, seed)
    return q[psi(q, field) <= level][:60]


def joined(field: NavigationField, level: float, a, b, count: int) -> bool:
    """Whether two points are joined on a lattice of points where psi <= level."""
    w = field.workspace
    t = np.linspace(-1.0, 1.0, count)
    grid = w.centre + np.stack(np.meshgrid(t, t, indexing="ij"), -1) * w.semi_axes
    parts, _ = label(psi(grid, field, np.float64) <= level)

    def around(q) -> set[int]:
        i, j = (((q - w.centre) / w.semi_axes + 1.0) / 2.0 * (count - 1)).astype(int)
        return set(parts[i : i + 2, j : j + 2].ravel().tolist()) - {0}

    return bool(around(np.asarray(a)) & around(np.asarray(b)))


def assert_out_of_reach(
    found: Certificate, field: NavigationField, starts: FloatArray
) -> int:
    """No minimum below the level is joined with a start; how many lie below it."""
    assert found.region is not None
    below = 0
    for root in find_minima(field):
        if float(psi([root.x, root.y], field)) > found.region:
            continue
        below += 1
        assert found.apart
        for q in starts:
            # A lattice may skip over a thin ridge: only a finer one convicts.
            assert not all(
                joined(field, found.region, (root.x, root.y), q, count)
                for count in (257, 1025)
            )
    return below
