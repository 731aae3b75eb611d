"""The test of one box: what it says must hold at every point.

Claims are attacked where they would be wrong: boxes are laid around critical points,
the goal and points that are barely free, and no test may clear them.
"""

import numpy as np
import pytest
from basins import find_minima, least_beta, polish, psi
from checks import holds
from worlds import WORLDS, World, make, ring

from bath_drake.certificate import box_test as kernel
from bath_drake.certificate.evaluation import (
    new_table,
)
from bath_drake.certificate.isolation import (
    MAXIMUM,
    MINIMUM,
    NONE,
    SADDLE_POINT,
    enclose,
)
from bath_drake.certificate.result import Box
from bath_drake.certificate.world import interval_world
from bath_drake.field.critical_points import find_critical_points
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet

# Worlds with narrow places, traps, overlaps and every kind of boundary.
_CHOSEN = (
    "one disc",
    "broadside ellipse",
    "overlapping discs across the way",
    "kappa one",
    "kappa a thousand",
    "five discs",
    "a gap of 0.2 % of the radius",
    "a needle along the way",
    "a needle askew",
    "twice the same ellipse, other exponents",
    "an obstacle of a millionth",
    "a goal beside an obstacle",
    "two ellipses in a superellipse",
    "an ellipse in an off-centre superellipse",
    "a closed ring",
    "a wall through the workspace",
    "discs that touch, across the way",
)


def _roots(field: NavigationField):
    """Critical points in extended precision."""
    places = [(p.x, p.y) for p in find_critical_points(field, resolution=24)]
    places += [(m.x, m.y) for m in find_minima(field)]
    found = [polish(x, y, field) for x, y in places]
    return [r for r in found if r is not None and r.step < 1e-14 and r.clear > 0.0]


def _around(x: float, y: float, size: float, rng):
    """A box that holds (x, y), at least a hundredth of its width from every edge."""
    w, h = size * rng.uniform(0.1, 1.0, 2)
    s, t = rng.uniform(0.01, 0.99, 2)
    return (x - s * w, x + (1.0 - s) * w), (y - t * h, y + (1.0 - t) * h)


def _attack(field: NavigationField, count: int, rng) -> int:
    """Lays `count` boxes around every critical point; how many were laid."""
    world = interval_world(field, None)
    table = new_table(world)
    scale = float(field.workspace.semi_axes.max())
    laid = 0
    for root in _roots(field):
        allowed = {kernel.OPEN, kernel.CONVEX}
        if not root.is_minimum:
            allowed.add(kernel.SADDLE)
        # From 1e-12, a thousand times the root's error, to the whole workspace.
        for size in scale * 10.0 ** rng.uniform(-12.0, 0.3, count):
            x, y = _around(root.x, root.y, size, rng)
            found = kernel.box_test(x, y, world, np.inf, table)
            assert found in allowed, (root, x, y, found)
            laid += 1
    return laid


@pytest.mark.parametrize("name", _CHOSEN)
def test_no_test_clears_a_box_with_a_critical_point_in_it(name: str, rng) -> None:
    world: World = WORLDS[name]
    assert _attack(world.field, 300, rng) >= 300


@pytest.mark.parametrize("name", _CHOSEN)
def test_no_test_takes_the_goal_or_a_free_point_for_one_outside(name: str, rng) -> None:
    field = WORLDS[name].field
    world = interval_world(field, None)
    table = new_table(world)
    scale = float(field.workspace.semi_axes.max())
    gx, gy = field.goal.tolist()
    for size in scale * 10.0 ** rng.uniform(-12.0, 0.3, 200):
        x, y = _around(gx, gy, size, rng)
        # At the goal psi is -inf: it lies in every sublevel set, and only RADIAL
        # knows of it.
        assert kernel.box_test(x, y, world, -50.0, table) in (
            kernel.RADIAL,
            kernel.OPEN,
            kernel.CONVEX,
        )
    # Points barely free: the boundaries of the obstacles, moved out by 1e-9 or so.
    grown = field.obstacles.theta * np.array([1, 1, 1, 1, 1.0])
    grown[:, 2:4] *= 1.0 + 10.0 ** rng.uniform(-12, -3, (len(grown), 1))
    near = ObstacleSet(grown).boundary(64).reshape(-1, 2)
    q = near[least_beta(near, field) > 1e-14]
    level = psi(q, field)
    for (qx, qy), c in zip(q.tolist(), level.astype(float).tolist(), strict=True):
        for size in scale * 10.0 ** rng.uniform(-12.0, 0.0, 3):
            x, y = _around(qx, qy, size, rng)
            found = kernel.box_test(x, y, world, c + 1e-9 * (1.0 + abs(c)), table)
            assert found not in (kernel.OUTSIDE, kernel.ABOVE)


def _random_world(rng) -> NavigationField:
    count = int(rng.integers(1, 13))
    theta = np.column_stack(
        [
            rng.uniform(-4.5, 4.5, (count, 2)),
            10.0 ** rng.uniform(-1.5, 0.2, (count, 2)),
            rng.uniform(-4.0, 4.0, count),
        ]
    )
    return make(
        10.0 ** rng.uniform(0.0, 2.2),
        *theta.tolist(),
        exponents=rng.choice([1.0, 1.0, 0.3, 2.0], count).tolist(),
        power=int(rng.choice([2, 2, 4])),
        goal=tuple(rng.uniform(-3.0, 3.0, 2)),
    )


def test_no_test_clears_a_critical_point_of_random_worlds(rng) -> None:
    laid = sum(_attack(_random_world(rng), 20, rng) for _ in range(25))
    assert laid > 1000


def test_a_box_said_to_hold_one_critical_point_does_and_of_that_kind(rng) -> None:
    enclosed = 0
    for _ in range(16):
        field = _random_world(rng)
        world = interval_world(field, None)
        table = new_table(world)
        for root in _roots(field):
            for size in 5.0 * 10.0 ** rng.uniform(-12.0, -0.5, 20):
                # Half of the boxes miss the root by up to their own width.
                s, t = rng.uniform(-1.0, 2.0, 2)
                x = (root.x - s * size, root.x + (1.0 - s) * size)
                y = (root.y - t * size, root.y + (1.0 - t) * size)
                kind = enclose(x, y, world, table)
                if kind == NONE:
                    continue
                enclosed += 1
                held = polish(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]), field)
                assert held is not None
                assert holds(Box(*x, *y), held)
                true = SADDLE_POINT if held.low < 0.0 else MINIMUM
                assert kind == (MAXIMUM if held.high < 0.0 else true)
    assert enclosed > 150


@pytest.mark.exhaustive
def test_a_million_boxes_around_critical_points_are_never_cleared() -> None:
    rng = np.random.default_rng(77)
    laid = 0
    while laid < 1_000_000:
        laid += _attack(_random_world(rng), 500, rng)


def test_a_box_that_holds_all_critical_points_is_open() -> None:
    field = make(10, *ring(-1.5, 0, 1.5, 0.7, 8))
    world = interval_world(field, None)
    whole = kernel.box_test((-5.0, 5.0), (-5.0, 5.0), world, np.inf, new_table(world))
    assert whole in (kernel.OPEN, kernel.CONVEX)


def test_the_tests_do_settle_boxes_of_each_kind() -> None:
    """Without this, a kernel that always says OPEN would pass all of the above."""
    field = make(4, [0, 0, 1, 1, 0])
    world = interval_world(field, None)
    table = new_table(world)
    saddle = polish(-1.67172, 0.0, field)
    assert saddle is not None

    def at(x: float, y: float, size: float, level: float = np.inf) -> int:
        box = (x - size, x + size), (y - size, y + size)
        return int(kernel.box_test(*box, world, level, table))

    assert at(0.0, 0.0, 0.2) == kernel.OUTSIDE
    assert at(3.0, 0.0, 0.2) == kernel.RADIAL
    assert at(saddle.x, saddle.y, 1e-3) == kernel.SADDLE
    assert at(-0.8, 0.8, 0.05) == kernel.ONE_WAY
    beside = saddle.x - 0.02
    assert at(beside, 0.0, 0.01) in (kernel.ONE_WAY, kernel.NO_ROOT)
    low = float(psi([beside, 0.0], field)) - 0.5
    assert at(beside, 0.0, 0.01, low) == kernel.ABOVE
