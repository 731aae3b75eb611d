"""Random fields for benchmarks and tests, the same ones from the same seed.

The workspace is a disc of radius 5 about the origin. The goal is uniform over the disc
of 0.8 of that radius. An ellipse has a long semi-axis uniform in 0.35..1 of
0.62 * 5 / sqrt(count + 1), so that the obstacles' share of the area hardly depends on
their number; two in five are discs, the others have a ratio of axes uniform in 1..2.5
and an angle uniform in 0..pi. All exponents are 1.
"""

import math

import numpy as np

from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.field.obstacles import ObstacleSet, Workspace, pair_gaps, support
from bath_drake.notation import FloatArray

RADIUS = 5.0
# What is kept between things that are not to touch.
GAP = 0.03 * RADIUS
# From about 400 on they find no room any more.
_MOST = 200
_DIRECTIONS = 180


def disjoint_world(
    rng: np.random.Generator, count: int, kappa: float
) -> NavigationField:
    """A field of `count` ellipses that lie apart.

    Centres are uniform over the workspace's square; what comes closer than `GAP` to
    the goal, to the rim or to an earlier ellipse is drawn again.

    Raises:
        ValueError: `count` is not in 0..200.
    """
    if not 0 <= count <= _MOST:
        raise ValueError(f"count must be in 0..{_MOST}, got {count}")
    while True:
        goal = _in_disc(rng, 0.8 * RADIUS)
        rows: list[FloatArray] = []
        # Where each thing begins along every direction; the goal is a point.
        begins = [_UNIT @ goal]
        for _ in range(100 * max(count, 1)):
            if len(rows) == count:
                return _field(rows, goal, kappa)
            row = _ellipse(rng, count, rng.uniform(-RADIUS, RADIUS, 2))
            low, high = _span(row)
            # Support functions: the greatest one is the distance from the origin.
            if high.max() > RADIUS - GAP:
                continue
            slits = np.stack(begins) - high
            if slits.max(axis=1).min() < GAP:
                continue
            rows.append(row)
            begins.append(low)


def overlapping_world(
    rng: np.random.Generator, count: int, kappa: float
) -> NavigationField:
    """A field of `count` ellipses that overlap each other and are cut by the rim.

    Centres are uniform over the workspace's disc; what comes closer than `GAP` to the
    goal is drawn again, and so is a world where no two ellipses overlap or none
    crosses the rim. The goal may lie in a pocket.

    Raises:
        ValueError: `count` is less than 2.
    """
    if count < 2:
        raise ValueError(f"count must be at least 2 for an overlap, got {count}")
    while True:
        goal = _in_disc(rng, 0.8 * RADIUS)
        rows: list[FloatArray] = []
        while len(rows) < count:
            row = _ellipse(rng, count, _in_disc(rng, RADIUS))
            if (_UNIT @ goal - _span(row)[1]).max() >= GAP:
                rows.append(row)
        field = _field(rows, goal, kappa)
        cut = max(_span(row)[1].max() for row in rows) > RADIUS
        if cut and pair_gaps(field.obstacles, _DIRECTIONS).min() < 0.0:
            return field


def free_points(
    rng: np.random.Generator, field: NavigationField, count: int
) -> FloatArray:
    """Points uniform over the free space of a field, shape (count, 2).

    The workspace must be a disc or an ellipse and have free space.
    """
    found = np.empty((0, 2))
    while len(found) < count:
        t = rng.uniform(0.0, 2.0 * math.pi, 2 * count)
        r = np.sqrt(rng.uniform(0.0, 1.0, 2 * count))
        unit = np.stack([r * np.cos(t), r * np.sin(t)], axis=-1)
        q = field.workspace.centre + unit * field.workspace.semi_axes
        found = np.concatenate([found, q[min_beta(q, field) > 0.0]])
    return found[:count]


def _circle(count: int) -> FloatArray:
    t = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
    return np.stack([np.cos(t), np.sin(t)], axis=-1)


_UNIT = _circle(_DIRECTIONS)


def _in_disc(rng: np.random.Generator, radius: float) -> FloatArray:
    r = radius * math.sqrt(rng.uniform())
    t = rng.uniform(0.0, 2.0 * math.pi)
    return np.array([r * math.cos(t), r * math.sin(t)])


def _ellipse(rng: np.random.Generator, count: int, centre: FloatArray) -> FloatArray:
    a = rng.uniform(0.35, 1.0) * 0.62 * RADIUS / math.sqrt(count + 1)
    if rng.uniform() < 0.4:
        return np.array([*centre, a, a, 0.0])
    return np.array([*centre, a, a / rng.uniform(1.0, 2.5), rng.uniform(0.0, math.pi)])


def _span(row: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where an ellipse begins and ends along every direction."""
    middle = _UNIT @ row[:2]
    reach = support(ObstacleSet(row[None]), _UNIT)[:, 0]
    return middle - reach, middle + reach


def _field(rows: list[FloatArray], goal: FloatArray, kappa: float) -> NavigationField:
    return NavigationField(
        workspace=Workspace(np.zeros(2), np.full(2, RADIUS)),
        goal=goal,
        kappa=kappa,
        obstacles=ObstacleSet(np.array(rows).reshape(-1, 5)),
    )
