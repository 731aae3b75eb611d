"""A critical point, polished and then proved to be alone in a box."""

import math
from typing import Final

import numpy as np
from numba import njit

from bath_drake.certificate.box_test import hessian, newton_image
from bath_drake.certificate.evaluation import (
    BETA,
    TINY,
    evaluate,
    gradient_at_middle,
    middle,
    radius,
)
from bath_drake.certificate.intervals import (
    Interval,
    add,
    multiply,
    point,
    square,
    subtract,
)
from bath_drake.certificate.world import World
from bath_drake.notation import FloatArray

# What `enclose` proved of a box.
NONE: Final = 0
MINIMUM: Final = 1
SADDLE_POINT: Final = 2
MAXIMUM: Final = 3


@njit(cache=True, nogil=True)
def _at(
    x: float, y: float, world: World, table: FloatArray
) -> tuple[bool, float, float, float, float, float]:
    """Whether a point is free and off the goal; grad psi and Hessian, not rounded."""
    if not evaluate(point(x), point(y), world, table):
        return False, 0.0, 0.0, 0.0, 0.0, 0.0
    px = subtract(point(x), point(world.goal[0]))
    py = subtract(point(y), point(world.goal[1]))
    gamma = add(square(px), square(py))
    free = gamma[0] > TINY
    for j in range(table.shape[0]):
        free = free and table[j, BETA, 0] > TINY
    if not free:
        return False, 0.0, 0.0, 0.0, 0.0, 0.0
    fx, fy = gradient_at_middle(px, py, world, table)
    hxx, hxy, hyy = hessian(px, py, gamma, world, table)
    return True, middle(fx), middle(fy), middle(hxx), middle(hxy), middle(hyy)


@njit(cache=True, nogil=True)
def polish(
    x: float, y: float, leash: float, world: World, table: FloatArray
) -> tuple[bool, float, float, float, float, float]:
    """Newton's method on grad psi: whether it converged within `leash`, the root, H."""
    x0 = x
    y0 = y
    size = max(world.rim[2], world.rim[3])
    for _ in range(40):
        free, fx, fy, a, b, c = _at(x, y, world, table)
        determinant = a * c - b * b
        if not free or determinant == 0.0:
            break
        dx = (b * fy - c * fx) / determinant
        dy = (b * fx - a * fy) / determinant
        x += dx
        y += dy
        if not math.hypot(x - x0, y - y0) <= leash:
            break
        # The coordinates' own rounding may be coarser, far from the origin.
        ulp = 2.0**-52 * (abs(x) + abs(y))
        if math.hypot(dx, dy) <= max(1e-13 * size, 4.0 * ulp):
            return True, x, y, a, b, c
    return False, x, y, 0.0, 0.0, 0.0


@njit(cache=True, nogil=True)
def enclose(x: Interval, y: Interval, world: World, table: FloatArray) -> int:
    """The kind of the one critical point in a box, NONE if none was proved.

    Krawczyk's operator maps the box into its own interior: it holds exactly one root
    of F; the Hessian over the whole box says which kind.
    """
    if not evaluate(x, y, world, table):
        return NONE
    px = subtract(x, point(world.goal[0]))
    py = subtract(y, point(world.goal[1]))
    gamma = add(square(px), square(py))
    if not gamma[0] > TINY:
        return NONE
    for j in range(table.shape[0]):
        if not table[j, BETA, 0] > TINY:
            return NONE
    hxx, hxy, hyy = hessian(px, py, gamma, world, table)
    x_m = middle(x)
    y_m = middle(y)
    mx = subtract(point(x_m), point(world.goal[0]))
    my = subtract(point(y_m), point(world.goal[1]))
    fx, fy = gradient_at_middle(mx, my, world, table)
    ok, nx, ny, sx, sy = newton_image(fx, fy, hxx, hxy, hyy, radius(x), radius(y))
    # The half widths towards either side, rounded down.
    rx = min(x_m - x[0], x[1] - x_m) * (1.0 - 1e-15)
    ry = min(y_m - y[0], y[1] - y_m) * (1.0 - 1e-15)
    inside = nx[0] - sx > -rx and nx[1] + sx < rx and ny[0] - sy > -ry
    if not (ok and inside and ny[1] + sy < ry):
        return NONE
    determinant = subtract(multiply(hxx, hyy), square(hxy))
    if determinant[1] < 0.0:
        return SADDLE_POINT
    if determinant[0] > 0.0 and hxx[0] > 0.0:
        return MINIMUM
    if determinant[0] > 0.0 and hxx[1] < 0.0:
        return MAXIMUM
    return NONE


@njit(cache=True, nogil=True)
def critical_point_near(
    x: Interval, y: Interval, world: World, table: FloatArray, row: FloatArray
) -> bool:
    """Looks for a critical point about a box and, if one is found, writes its row.

    The row (9,) holds x, y, both eigenvalues of the Hessian, what was proved, and the
    largest box tried, low and high ends, that was proved to hold it and no other (all
    zero for NONE).
    """
    leash = 2.0 * max(x[1] - x[0], y[1] - y[0])
    found, px, py, a, b, c = polish(middle(x), middle(y), leash, world, table)
    if not found:
        return False
    mean = 0.5 * (a + c)
    half = math.hypot(0.5 * (a - c), b)
    row[:] = 0.0
    row[0] = px
    row[1] = py
    row[2] = mean - half
    row[3] = mean + half
    size = max(world.rim[2], world.rim[3])
    half = 0.1 * size
    while half > 1e-13 * size:
        x = (px - half, px + half)
        y = (py - half, py + half)
        kind = enclose(x, y, world, table)
        if kind != NONE:
            row[4] = kind
            row[5], row[6] = x
            row[7], row[8] = y
            break
        half *= 0.3
    return True


@njit(cache=True, nogil=True)
def tighten(row: FloatArray, world: World, table: FloatArray) -> FloatArray:
    """A small box that is proved to hold the critical point of a row; shape (4,)."""
    size = max(world.rim[2], world.rim[3])
    half = 1e-9 * size
    while half < 0.5 * (row[6] - row[5]):
        x = (row[0] - half, row[0] + half)
        y = (row[1] - half, row[1] + half)
        if enclose(x, y, world, table) != NONE:
            return np.array([x[0], x[1], y[0], y[1]])
        half *= 10.0
    return row[5:].copy()
