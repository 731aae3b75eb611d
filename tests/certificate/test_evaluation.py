"""Enclosures of every beta, of psi's gradient and Hessian: against exact rationals."""

from fractions import Fraction

import hypothesis.strategies as st
import numpy as np
from basins import least_beta, terms
from hypothesis import given, settings
from worlds import make

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
from bath_drake.certificate.regions import standing
from bath_drake.certificate.world import Uncertainty, interval_world
from bath_drake.certificate.world import World as Enclosed
from bath_drake.field.navigation import NavigationField

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
