"""Every beta_j with its derivatives over a box, as intervals."""

from typing import Final

import numpy as np
from numba import njit

from bath_drake.certificate.intervals import (
    Interval,
    above,
    add,
    below,
    divide,
    double,
    magnitude,
    multiply,
    point,
    power,
    reach,
    scale,
    square,
    subtract,
    widen,
)
from bath_drake.certificate.world import World
from bath_drake.notation import FloatArray

# Columns of a table (Q + 1, columns, 2): a row a boundary, the rim first.
BETA: Final = 0
GX: Final = 1  # gradient over the box
GY: Final = 2
HXX: Final = 3  # Hessian over the box
HXY: Final = 4
HYY: Final = 5
MID_BETA: Final = 6  # at the box's middle
MID_GX: Final = 7
MID_GY: Final = 8
# Not an interval: w over beta at the middle; across a boundary, over the greatest beta.
WEIGHT: Final = 9
# An ellipse's centre and form as middle and radius; the same for every box. Of the
# rim, _A and _B are the intervals of its inverse semi-axes.
_CX: Final = 10
_CY: Final = 11
_A: Final = 12
_B: Final = 13
_C: Final = 14
_COLUMNS: Final = 15
# Where gamma or a beta may be less, nothing is divided by it: no overflow.
TINY: Final = 1e-60
# Rounding: a unit in the last place, twice what one operation errs; and a factor that
# covers the few dozen roundings of a sum of positive terms that bounds an error.
_UNIT: Final = 2.0**-52
_RESERVE: Final = 1.0 + 2.0**-46
_UNDERFLOW: Final = 1e-300


@njit(cache=True)
def new_table(world: World) -> FloatArray:
    """A table of a world, with all that is the same for every box filled in."""
    rows = world.obstacles
    table = np.zeros((rows.shape[0] + 1, _COLUMNS, 2))
    _put(table, 0, _A, divide(point(1.0), point(world.rim[2])))
    _put(table, 0, _B, divide(point(1.0), point(world.rim[3])))
    for i in range(rows.shape[0]):
        table[i + 1, HXX] = 2.0 * rows[i, 2]
        table[i + 1, HXY] = 2.0 * rows[i, 3]
        table[i + 1, HYY] = 2.0 * rows[i, 4]
        for k in range(5):
            x = (rows[i, k, 0], rows[i, k, 1])
            table[i + 1, _CX + k, 0] = middle(x)
            if x[0] < x[1]:
                table[i + 1, _CX + k, 1] = radius(x)
    return table


@njit(cache=True)
def get(table: FloatArray, j: int, column: int) -> Interval:
    """One entry of a table."""
    return table[j, column, 0], table[j, column, 1]


@njit(cache=True)
def _put(table: FloatArray, j: int, column: int, value: Interval) -> None:
    table[j, column, 0] = value[0]
    table[j, column, 1] = value[1]


@njit(cache=True)
def radius(x: Interval) -> float:
    """A bound of the distance from the middle, as `middle` rounds it, to an end."""
    m = middle(x)
    return max(above(x[1] - m), above(m - x[0]))


@njit(cache=True)
def middle(x: Interval) -> float:
    """A float near the middle of an interval."""
    return x[0] + 0.5 * (x[1] - x[0])


@njit(cache=True)
def _rim(
    x: Interval, y: Interval, rim: FloatArray, row: FloatArray
) -> tuple[Interval, Interval, Interval, Interval, Interval]:
    """beta_0, its gradient and its Hessian's diagonal; sharp, as x and y part."""
    a = (row[_A, 0], row[_A, 1])  # of 1/a and 1/b
    b = (row[_B, 0], row[_B, 1])
    u = multiply(subtract(x, point(rim[0])), a)
    v = multiply(subtract(y, point(rim[1])), b)
    p = int(rim[4])
    if p == 2:  # by far the most common
        beta = subtract(subtract(point(1.0), square(u)), square(v))
        gx = multiply((-2.0 * u[1], -2.0 * u[0]), a)
        gy = multiply((-2.0 * v[1], -2.0 * v[0]), b)
        return beta, gx, gy, scale(-2.0, square(a)), scale(-2.0, square(b))
    beta = subtract(subtract(point(1.0), power(u, p)), power(v, p))
    gx = multiply(scale(-float(p), power(u, p - 1)), a)
    gy = multiply(scale(-float(p), power(v, p - 1)), b)
    c = -float(p * (p - 1))
    hxx = multiply(scale(c, power(u, p - 2)), square(a))
    hyy = multiply(scale(c, power(v, p - 2)), square(b))
    return beta, gx, gy, hxx, hyy


@njit(cache=True)
def _ellipse(
    mx: float, my: float, row: FloatArray
) -> tuple[Interval, Interval, Interval]:
    """Encloses beta and half its gradient at a point, faster than by `intervals`.

    Each quantity is computed once, as a float, and a bound of its error beside it:
    what its factors err, propagated to first and second order, and its own rounding,
    at most half a unit in the last place of each term and of each partial sum.
    """
    a = row[_A, 0]
    b = row[_B, 0]
    c = row[_C, 0]
    dx = mx - row[_CX, 0]
    dy = my - row[_CY, 0]
    sx = row[_CX, 1] + _UNIT * abs(dx)
    sy = row[_CY, 1] + _UNIT * abs(dy)
    ax = abs(dx) + sx
    ay = abs(dy) + sy
    ex = a * dx + b * dy
    ey = b * dx + c * dy
    tx = abs(a) * sx + row[_A, 1] * ax + abs(b) * sy + row[_B, 1] * ay
    ty = abs(b) * sx + row[_B, 1] * ax + abs(c) * sy + row[_C, 1] * ay
    tx += _UNIT * (abs(a * dx) + abs(b * dy)) * 2.0
    ty += _UNIT * (abs(b * dx) + abs(c * dy)) * 2.0
    tx = tx * _RESERVE + _UNDERFLOW
    ty = ty * _RESERVE + _UNDERFLOW
    beta = ex * dx + ey * dy - 1.0
    t = tx * ax + abs(ex) * sx + ty * ay + abs(ey) * sy
    t += _UNIT * (abs(ex * dx) + abs(ey * dy) + 1.0) * 2.0
    t = t * _RESERVE + _UNDERFLOW
    return (
        (below(beta - t), above(beta + t)),
        (below(ex - tx), above(ex + tx)),
        (below(ey - ty), above(ey + ty)),
    )


@njit(cache=True)
def evaluate(x: Interval, y: Interval, world: World, table: FloatArray) -> bool:
    """Fills the table for a box; False if some beta_j <= 0 all over it.

    Ellipses are expanded about the middle m: beta is convex, so that its tangent
    plane bounds it from below, and with the second-order term from above.
    """
    beta, gx, gy, hxx, hyy = _rim(x, y, world.rim, table[0])
    if beta[1] <= 0.0:
        return False
    _put(table, 0, BETA, beta)
    _put(table, 0, GX, gx)
    _put(table, 0, GY, gy)
    _put(table, 0, HXX, hxx)
    _put(table, 0, HYY, hyy)
    mx = middle(x)
    my = middle(y)
    rx = radius(x)
    ry = radius(y)
    beta, gx, gy, _, _ = _rim(point(mx), point(my), world.rim, table[0])
    _put(table, 0, MID_BETA, beta)
    _put(table, 0, MID_GX, gx)
    _put(table, 0, MID_GY, gy)
    for i in range(1, table.shape[0]):
        beta, gx, gy = _ellipse(mx, my, table[i])
        gx = double(gx)
        gy = double(gy)
        a = table[i, _A, 0] + table[i, _A, 1]
        b = abs(table[i, _B, 0]) + table[i, _B, 1]
        c = table[i, _C, 0] + table[i, _C, 1]
        first = reach(gx, rx, gy, ry)
        tx = (a * rx + b * ry) * _RESERVE
        ty = (b * rx + c * ry) * _RESERVE
        second = (tx * rx + ty * ry) * _RESERVE
        high = above(above(beta[1] + first) + second) + _UNDERFLOW
        if high <= 0.0:
            return False
        _put(table, i, BETA, (below(beta[0] - first), high))
        _put(table, i, GX, widen(gx, 2.0 * tx + _UNDERFLOW))
        _put(table, i, GY, widen(gy, 2.0 * ty + _UNDERFLOW))
        _put(table, i, MID_BETA, beta)
        _put(table, i, MID_GX, gx)
        _put(table, i, MID_GY, gy)
    for j in range(table.shape[0]):
        cut = not table[j, BETA, 0] > 0.0
        beta_j = table[j, BETA, 1] if cut else table[j, MID_BETA, 0]
        table[j, WEIGHT, 0] = world.exponents[j] / beta_j
    return True


@njit(cache=True)
def gradient_at_middle(
    px: Interval, py: Interval, world: World, table: FloatArray
) -> tuple[Interval, Interval]:
    """Encloses grad psi at the box's middle, which is (px, py) from the goal."""
    gamma = add(multiply(px, px), multiply(py, py))
    k = 2.0 * world.kappa
    fx = divide(scale(k, px), gamma)
    fy = divide(scale(k, py), gamma)
    for j in range(table.shape[0]):
        w = world.exponents[j]
        beta = get(table, j, MID_BETA)
        fx = subtract(fx, scale(w, divide(get(table, j, MID_GX), beta)))
        fy = subtract(fy, scale(w, divide(get(table, j, MID_GY), beta)))
    return fx, fy


@njit(cache=True)
def gradient_reach(
    table: FloatArray, j: int, ux: float, uy: float, rx: float, ry: float
) -> float:
    """A bound of |u . (grad beta_j(q) - grad beta_j(m))| over the box."""
    hxx = scale(ux, get(table, j, HXX))
    hyy = scale(uy, get(table, j, HYY))
    across = get(table, j, HXY)
    return above(
        above(magnitude(add(hxx, scale(uy, across))) * rx)
        + above(magnitude(add(scale(ux, across), hyy)) * ry)
    )
