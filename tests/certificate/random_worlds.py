"""Random worlds of every sort the certificate is asked about."""

import numpy as np
from worlds import make

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, beta
from bath_drake.notation import FloatArray

KINDS = ("disjoint", "overlapping", "rim-cut")

# Squares of side 1.5 that lie in the disc of radius 5: whatever is drawn within one
# keeps clear of the rest, so that no draw is ever thrown away.
_SIDE = 1.5
_STEPS = (np.arange(6) - 2.5) * _SIDE
CELLS = np.array(
    [
        (x, y)
        for x in _STEPS
        for y in _STEPS
        if np.hypot(abs(x) + _SIDE / 2, abs(y) + _SIDE / 2) < 5.0
    ]
)


def in_cells(cells: FloatArray, rng: np.random.Generator) -> FloatArray:
    """One ellipse (cx, cy, a, b, angle) within each cell, a gap of 0.05 around it."""
    n = len(cells)
    long = rng.uniform(0.15, 0.5, n) * _SIDE - 0.05
    short = long / rng.uniform(1.0, 3.0, n)
    room = _SIDE / 2 - long - 0.05
    centres = cells + room[:, None] * rng.uniform(-1.0, 1.0, (n, 2))
    swap = rng.random(n) < 0.5
    a, b = np.where(swap, short, long), np.where(swap, long, short)
    return np.column_stack([centres, a, b, rng.uniform(-np.pi, np.pi, n)])


def leave_free(theta: FloatArray, goal: FloatArray, margin: float) -> FloatArray:
    """Shrinks the ellipses that a goal is in or near: beta(goal) >= margin then."""
    theta = theta.copy()
    if len(theta):
        value = beta(goal, ObstacleSet(theta)) + 1.0
        shrink = np.minimum(1.0, np.sqrt(value / (1.0 + margin)))
        theta[:, 2:4] *= np.maximum(shrink, 1e-6)[:, None]
    return theta


def random_world(kind: str, rng: np.random.Generator) -> NavigationField:
    """Up to 20 obstacles, kappa 1 to 150, exponents about half of the time.

    In a disc of radius 5; the goal is free in all but one of twenty.
    """
    count = int(rng.integers(0, 21))
    cells = rng.permutation(len(CELLS))
    goal = CELLS[cells[0]] + rng.uniform(-0.5, 0.5, 2)
    if kind == "disjoint":
        theta = in_cells(CELLS[cells[1 : count + 1]], rng)
    else:
        reach = 0.8 if kind == "overlapping" else 1.1
        radius, turn = 5.0 * reach * np.sqrt(rng.random(count)), rng.random(count) * 7
        axes = 10.0 ** rng.uniform(-0.9, 0.1, (count, 2))
        theta = np.column_stack(
            [radius * np.cos(turn), radius * np.sin(turn), axes, rng.random(count) * 7]
        )
    if rng.random() < 0.95:
        theta = leave_free(theta, goal, 0.02)
    exponents = np.ones(count)
    if rng.random() < 0.5:
        exponents = 10.0 ** rng.uniform(-1.0, 0.7, count)
    # Half of them with the kappa that so many obstacles need (FACTS 1.13).
    lowest = 0.0 if rng.random() < 0.5 else 1.5
    kappa = 10.0 ** rng.uniform(lowest, np.log10(150.0))
    return make(
        kappa,
        *theta.tolist(),
        exponents=exponents.tolist(),
        goal=(float(goal[0]), float(goal[1])),
    )
