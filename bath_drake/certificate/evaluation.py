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
COLUMNS: Final = 9  # how many there are

# Where gamma or a beta may be less, nothing is divided by it: no overflow.
TINY: Final = 1e-60


@njit(cache=True)
def new_table(world: World) -> FloatArray:
    """A table of a world; ellipses have the same Hessian everywhere, filled in here."""
    rows = world.obstacles
    table = np.empty((rows.shape[0] + 1, COLUMNS, 2))
    for i in range(rows.shape[0]):
        table[i + 1, HXX] = 2.0 * rows[i, 2]
        table[i + 1, HXY] = 2.0 * rows[i, 3]
        table[i + 1, HYY] = 2.0 * rows[i, 4]
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
    x: Interval, y: Interval, rim: FloatArray
) -> tuple[Interval, Interval, Interval, Interval, Interval]:
    """beta_0, its gradient and its Hessian's diagonal; sharp, as x and y part."""
    a = point(rim[2])
    b = point(rim[3])
    u = divide(subtract(x, point(rim[0])), a)
    v = divide(subtract(y, point(rim[1])), b)
    p = int(rim[4])
    beta = subtract(subtract(point(1.0), power(u, p)), power(v, p))
    gx = divide(scale(-float(p), power(u, p - 1)), a)
    gy = divide(scale(-float(p), power(v, p - 1)), b)
    c = -float(p * (p - 1))
    hxx = divide(divide(scale(c, power(u, p - 2)), a), a)
    hyy = divide(divide(scale(c, power(v, p - 2)), b), b)
    return beta, gx, gy, hxx, hyy


@njit(cache=True)
def evaluate(x: Interval, y: Interval, world: World, table: FloatArray) -> bool:
    """Fills the table for a box; False if some beta_j <= 0 all over it.

    Ellipses are expanded about the middle m: beta is convex, so that its tangent
    plane bounds it from below, and with the second-order term from above.
    """
    beta, gx, gy, hxx, hyy = _rim(x, y, world.rim)
    if beta[1] <= 0.0:
        return False
    _put(table, 0, BETA, beta)
    _put(table, 0, GX, gx)
    _put(table, 0, GY, gy)
    _put(table, 0, HXX, hxx)
    _put(table, 0, HXY, (0.0, 0.0))
    _put(table, 0, HYY, hyy)
    mx = point(middle(x))
    my = point(middle(y))
    rx = radius(x)
    ry = radius(y)
    beta, gx, gy, _, _ = _rim(mx, my, world.rim)
    _put(table, 0, MID_BETA, beta)
    _put(table, 0, MID_GX, gx)
    _put(table, 0, MID_GY, gy)
    rows = world.obstacles
    for i in range(rows.shape[0]):
        a = (rows[i, 2, 0], rows[i, 2, 1])
        b = (rows[i, 3, 0], rows[i, 3, 1])
        c = (rows[i, 4, 0], rows[i, 4, 1])
        dx = subtract(mx, (rows[i, 0, 0], rows[i, 0, 1]))
        dy = subtract(my, (rows[i, 1, 0], rows[i, 1, 1]))
        ex = add(multiply(a, dx), multiply(b, dy))
        ey = add(multiply(b, dx), multiply(c, dy))
        beta = subtract(add(multiply(ex, dx), multiply(ey, dy)), point(1.0))
        gx = double(ex)
        gy = double(ey)
        first = reach(gx, rx, gy, ry)
        tx = reach(a, rx, b, ry)
        ty = reach(b, rx, c, ry)
        second = above(above(tx * rx) + above(ty * ry))
        high = above(above(beta[1] + first) + second)
        if high <= 0.0:
            return False
        _put(table, i + 1, BETA, (below(beta[0] - first), high))
        _put(table, i + 1, GX, widen(gx, 2.0 * tx))
        _put(table, i + 1, GY, widen(gy, 2.0 * ty))
        _put(table, i + 1, MID_BETA, beta)
        _put(table, i + 1, MID_GX, gx)
        _put(table, i + 1, MID_GY, gy)
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
