"""The test of one box: what it says must hold at every point, to the last digit.

Enclosures are compared with exact rational numbers. Claims are attacked where they
would be wrong: boxes are laid around critical points, the goal and points that are
barely free, and no test may clear them.
"""

from fractions import Fraction

import hypothesis.strategies as st
import numpy as np
import pytest
from basins import find_minima, least_beta, polish, psi, terms
from checks import holds
from hypothesis import given, settings
from worlds import WORLDS, World, make, ring

from bath_drake.certificate import box_test as kernel
from bath_drake.certificate.evaluation import (
    BETA,
    GX,
    GY,
    HXX,
    HXY,
    HYY,
    MID_BETA,
    MID_GX,
    MID_GY,
    evaluate,
    gradient_at_middle,
    middle,
    new_table,
)
from bath_drake.certificate.intervals import add, point, square, subtract
from bath_drake.certificate.isolation import (
    MAXIMUM,
    MINIMUM,
    NONE,
    SADDLE_POINT,
    enclose,
)
from bath_drake.certificate.regions import standing
from bath_drake.certificate.result import Box
from bath_drake.certificate.world import Uncertainty, interval_world
from bath_drake.certificate.world import World as Enclosed
from bath_drake.field.critical_points import find_critical_points
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet

Interval = tuple[float, float]

coordinates = st.floats(-4.5, 4.5)
axes = st.floats(0.05, 2.0)
rows = st.tuples(coordinates, coordinates, axes, axes, st.floats(-4.0, 4.0)).map(list)
fields = st.builds(
    lambda kappa, rows, exponents, power, goal: make(
        kappa, *rows, exponents=exponents[: len(rows)], power=power, goal=goal
    ),
    st.floats(0.0, 3.0).map(lambda e: 10.0**e),
    st.lists(rows, max_size=4),
    st.lists(st.floats(0.01, 5.0), min_size=4, max_size=4),
    st.sampled_from([2, 4, 8]),
    st.tuples(coordinates, coordinates),
)
sizes = st.floats(-12.0, 0.3).map(lambda e: 10.0**e)


def _exact_forms(world) -> list[list[Fraction]]:
    """One realisation of the obstacles within their intervals: the middles."""
    return [
        [(Fraction(low) + Fraction(high)) / 2 for low, high in row]
        for row in world.obstacles.tolist()
    ]


def _exact(world, x: Fraction, y: Fraction) -> list[tuple[Fraction, ...]]:
    """(beta, gradient, Hessian) of every boundary at a rational point, exactly."""
    cx, cy, a, b = map(Fraction, world.rim[:4].tolist())
    p = int(world.rim[4])
    u, v = (x - cx) / a, (y - cy) / b
    found = [
        (
            1 - u**p - v**p,
            -p * u ** (p - 1) / a,
            -p * v ** (p - 1) / b,
            -p * (p - 1) * u ** (p - 2) / a**2,
            Fraction(0),
            -p * (p - 1) * v ** (p - 2) / b**2,
        )
    ]
    for fx, fy, fa, fb, fc in _exact_forms(world):
        dx, dy = x - fx, y - fy
        hx, hy = fa * dx + fb * dy, fb * dx + fc * dy
        found.append((dx * hx + dy * hy - 1, 2 * hx, 2 * hy, 2 * fa, 2 * fb, 2 * fc))
    return found


def _holds(ends, exact: Fraction) -> bool:
    return Fraction(float(ends[0])) <= exact <= Fraction(float(ends[1]))


@settings(max_examples=120)
@given(
    fields,
    coordinates,
    coordinates,
    sizes,
    sizes,
    st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), min_size=4, max_size=4),
)
def test_every_value_over_a_box_lies_in_its_enclosure(
    field: NavigationField, x: float, y: float, w: float, h: float, shares
) -> None:
    world = interval_world(field, None)
    table = new_table(world)
    box_x, box_y = (x, x + w), (y, y + h)
    inside = evaluate(box_x, box_y, world, table)
    for s, t in [*shares, (0.0, 0.0), (1.0, 1.0), (0.0, 1.0)]:
        qx = Fraction(x) + (Fraction(box_x[1]) - Fraction(x)) * Fraction(s)
        qy = Fraction(y) + (Fraction(box_y[1]) - Fraction(y)) * Fraction(t)
        exact = _exact(world, qx, qy)
        if not inside:
            assert min(e[0] for e in exact) <= 0
            continue
        for j, values in enumerate(exact):
            columns = (BETA, GX, GY, HXX, HXY, HYY)
            for column, value in zip(columns, values, strict=True):
                assert _holds(table[j, column], value)
    if inside:
        at = _exact(world, Fraction(middle(box_x)), Fraction(middle(box_y)))
        for j, (beta, gx, gy, *_) in enumerate(at):
            assert _holds(table[j, MID_BETA], beta)
            assert _holds(table[j, MID_GX], gx)
            assert _holds(table[j, MID_GY], gy)


@settings(max_examples=120)
@given(fields, coordinates, coordinates, st.floats(-12.0, -1.0), st.floats(0.0, 1.0))
def test_gradient_and_hessian_of_psi_lie_in_their_enclosures(
    field: NavigationField, x: float, y: float, log_size: float, share: float
) -> None:
    world = interval_world(field, None)
    table = new_table(world)
    size = 10.0**log_size
    box_x, box_y = (x, x + size), (y, y + size)
    gx, gy = field.goal.tolist()
    px, py = subtract(box_x, point(gx)), subtract(box_y, point(gy))
    gamma = add(square(px), square(py))
    free = evaluate(box_x, box_y, world, table) and gamma[0] > 0.0
    if not (free and (table[:, BETA, 0] > 0.0).all()):
        return
    k = 2 * Fraction(field.kappa)
    w = list(map(Fraction, world.exponents.tolist()))

    def derivatives(qx: Fraction, qy: Fraction):
        dx, dy = qx - Fraction(gx), qy - Fraction(gy)
        g = dx * dx + dy * dy
        out = [
            k * dx / g,
            k * dy / g,
            k * (dy * dy - dx * dx) / g**2,
            -2 * k * dx * dy / g**2,
            k * (dx * dx - dy * dy) / g**2,
        ]
        for wj, (b, bx, by, bxx, bxy, byy) in zip(
            w, _exact(world, qx, qy), strict=True
        ):
            out[0] -= wj * bx / b
            out[1] -= wj * by / b
            out[2] += wj * (bx * bx / b - bxx) / b
            out[3] += wj * (bx * by / b - bxy) / b
            out[4] += wj * (by * by / b - byy) / b
        return out

    mx = subtract(point(middle(box_x)), point(gx))
    my = subtract(point(middle(box_y)), point(gy))
    at_middle = derivatives(Fraction(middle(box_x)), Fraction(middle(box_y)))
    found = gradient_at_middle(mx, my, world, table)
    assert _holds(found[0], at_middle[0])
    assert _holds(found[1], at_middle[1])
    step = (Fraction(box_x[1]) - Fraction(x)) * Fraction(share)
    exact = derivatives(Fraction(x) + step, Fraction(y))
    for ends, value in zip(
        kernel.hessian(px, py, gamma, world, table), exact[2:], strict=True
    ):
        assert _holds(ends, value)


@settings(max_examples=100)
@given(
    rows,
    st.floats(0.0, 0.04),
    st.floats(0.0, 0.04),
    st.tuples(*[st.sampled_from([-1, 0, 1])] * 4),
    coordinates,
    coordinates,
    sizes,
)
def test_with_uncertainty_every_realisation_lies_in_the_enclosures(
    row, centres: float, semi_axes: float, signs, x: float, y: float, size: float
) -> None:
    field = make(5.0, row)
    world = interval_world(field, Uncertainty(centres, semi_axes))
    table = new_table(world)
    inside = evaluate((x, x + size), (y, y + size), world, table)
    real = [
        row[0] + signs[0] * centres,
        row[1] + signs[1] * centres,
        row[2] + signs[2] * semi_axes,
        row[3] + signs[3] * semi_axes,
        row[4],
    ]
    rim, value = map(float, terms([x + 0.3 * size, y + 0.8 * size], make(5.0, real))[0])
    # row + slack is rounded here, 2^-53 relative: times the slope of beta in the row.
    rounding = 1e-13 * (abs(value) + 1.0) / min(real[2], real[3])
    if inside:
        assert table[1, BETA, 0] - rounding <= value <= table[1, BETA, 1] + rounding
    else:
        assert min(rim, value) <= rounding


magnitudes = st.floats(-12.0, 12.0).map(lambda e: 10.0**e)


@settings(max_examples=300)
@given(
    st.tuples(magnitudes, magnitudes, st.booleans(), st.booleans()),
    st.tuples(magnitudes, magnitudes, st.floats(-4.0, 4.0)),
    st.lists(st.just(0.0) | st.floats(-16.0, -2.0), min_size=5, max_size=5),
    st.lists(st.floats(0.0, 1.0), min_size=5, max_size=5),
    st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)),
)
def test_ellipses_of_any_size_and_tolerance_lie_in_their_enclosures(
    centre, shape, tolerances, shares, offset
) -> None:
    x, y, left, low = centre
    a, b, angle = shape
    c, s = np.cos(angle), np.sin(angle)
    p, r = 1.0 / a**2, 1.0 / b**2
    middles = np.array(
        [
            -x if left else x,
            -y if low else y,
            c * c * p + s * s * r,
            c * s * (p - r),
            s * s * p + c * c * r,
        ]
    )
    widths = np.array([10.0**t if t else 0.0 for t in tolerances]) * np.abs(middles)
    rows = np.stack([middles - widths, middles + widths], axis=-1)
    world = Enclosed(
        np.array([0.0, 0.0, 1e15, 1e15, 2.0]),
        np.zeros(2),
        1.0,
        rows[None],
        np.ones(2),
    )
    table = new_table(world)
    qx, qy = (middles[:2] + np.array(offset) * (a, b)).tolist()
    inside = evaluate((qx, qx), (qy, qy), world, table)
    # One realisation, corners of the intervals among them, in exact numbers.
    fx, fy, fa, fb, fc = (
        _between_ends(ends, share)
        for ends, share in zip(rows.tolist(), shares, strict=True)
    )
    dx, dy = Fraction(qx) - fx, Fraction(qy) - fy
    hx, hy = fa * dx + fb * dy, fb * dx + fc * dy
    beta = dx * hx + dy * hy - 1
    if not inside:
        assert beta <= 0
        return
    assert _holds(table[1, MID_BETA], beta)
    assert _holds(table[1, MID_GX], 2 * hx)
    assert _holds(table[1, MID_GY], 2 * hy)


def _between_ends(ends: list[float], share: float) -> Fraction:
    low, high = map(Fraction, ends)
    return low + (high - low) * Fraction(share)


@given(rows, st.floats(-1e9, 1e9))
def test_the_quadratic_form_of_an_ellipse_lies_in_its_enclosure(row, turns) -> None:
    for angle in (row[4], turns):
        field = make(5.0, [*row[:4], angle])
        ((_, _, a, b, angle),) = field.obstacles.theta.astype(np.longdouble)
        c, s = np.cos(angle), np.sin(angle)
        p, r = 1 / a**2, 1 / b**2
        # Extended precision errs by 1e-19 of the larger term, the enclosure is 1e-15
        # wide.
        exact = (c * c * p + s * s * r, c * s * (p - r), s * s * p + c * c * r)
        for (low, high), value in zip(
            interval_world(field, None).obstacles[0, 2:], exact, strict=True
        ):
            assert low <= value <= high
            assert high - low <= 1e-13 * float(max(p, r))


@given(rows, st.floats(-4.0, 4.0), st.floats(-16.0, -3.0), st.booleans())
def test_points_near_a_boundary_stand_where_they_do(
    row, turn: float, log_distance: float, out: bool
) -> None:
    distance = (1.0 if out else -1.0) * 10.0**log_distance
    field = make(5.0, row, semi_axes=(20.0, 20.0))
    x, y, a, b, angle = row
    u, v = a * (1 + distance) * np.cos(turn), b * (1 + distance) * np.sin(turn)
    c, s = np.cos(angle), np.sin(angle)
    q = np.array([x + c * u - s * v, y + s * u + c * v])
    value = least_beta(q, field)
    where, boundary = standing(interval_world(field, None), q)
    # Extended precision is right to 1e-17 or so, times 1 / 0.05^2.
    if where == "free":
        assert value > -1e-15
    elif where == "outside":
        assert value < 1e-15
        assert boundary == 1
    if abs(distance) > 1e-10:  # and it is not always in doubt
        assert where == ("free" if out else "outside")


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
