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
    # Half of them with the kappa that so many obstacles need.
    lowest = 0.0 if rng.random() < 0.5 else 1.5
    kappa = 10.0 ** rng.uniform(lowest, np.log10(150.0))
    return make(
        kappa,
        *theta.tolist(),
        exponents=exponents.tolist(),
        goal=(float(goal[0]), float(goal[1])),
    )


def exotic_world(rng: np.random.Generator) -> NavigationField:
    """Off-centre superellipses, needles, near-touching pairs, kappa 0.6 to 1000."""
    centre = rng.uniform(-20.0, 20.0, 2)
    semi_axes = rng.uniform(1.0, 4.0, 2)
    count = int(rng.integers(0, 8))
    share = rng.uniform(-0.9, 0.9, (count, 2))
    long = semi_axes.min() * 10.0 ** rng.uniform(-2.0, -0.2, count)
    thin = long * 10.0 ** -rng.choice([0.0, 0.3, 1.0, 1.7], count)
    theta = np.column_stack(
        [centre + share * semi_axes, long, thin, rng.uniform(-np.pi, np.pi, count)]
    )
    # Some discs are put beside the one before, a small gap or overlap between.
    for i in range(1, count):
        if rng.random() < 0.3:
            gap = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-6.0, -1.5)
            turn = rng.uniform(-np.pi, np.pi)
            theta[i - 1, 3] = theta[i - 1, 2]
            theta[i, 3] = theta[i, 2]
            apart = theta[i - 1, 2] + theta[i, 2] + gap * semi_axes.min()
            along = np.array([np.cos(turn), np.sin(turn)])
            theta[i, :2] = theta[i - 1, :2] + apart * along
    goal = centre + rng.uniform(-0.7, 0.7, 2) * semi_axes
    return make(
        10.0 ** rng.uniform(-0.2, 3.0),
        *leave_free(theta, goal, 0.02).tolist(),
        exponents=(10.0 ** rng.uniform(-2.0, 1.3, count)).tolist(),
        goal=(float(goal[0]), float(goal[1])),
        centre=(float(centre[0]), float(centre[1])),
        semi_axes=(float(semi_axes[0]), float(semi_axes[1])),
        power=int(rng.choice([2, 4, 6, 8])),
    )
