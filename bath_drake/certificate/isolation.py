"""A critical point, polished and then proved to be alone in a box."""

import math
from typing import Final

from numba import njit

from bath_drake.certificate.box_test import TINY, hessian, newton_image
from bath_drake.certificate.evaluation import (
    BETA,
    evaluate,
    gradient_at_middle,
    middle,
    radius,
)
from bath_drake.certificate.intervals import (
    Interval,
    above,
    add,
    multiply,
    point,
    square,
    subtract,
)
from bath_drake.certificate.world import World, log_bounds
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
        if math.hypot(dx, dy) <= 1e-13 * size:
            return True, x, y, a, b, c
    return False, x, y, 0.0, 0.0, 0.0


@njit(cache=True, nogil=True)
def enclose(
    x: Interval, y: Interval, world: World, level: float, table: FloatArray
) -> int:
    """The kind of the one critical point in a box, NONE if none was proved.

    Krawczyk's operator maps the box into its own interior: it holds exactly one root
    of F; the Hessian over the whole box says which kind. With a finite `level` the
    box must lie in {psi <= level}.
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
    if level < math.inf and not _under(gamma, world, level, table):
        return NONE
    hxx, hxy, hyy = hessian(px, py, gamma, world, table)
    x_m = middle(x)
    y_m = middle(y)
    mx = subtract(point(x_m), point(world.goal[0]))
    my = subtract(point(y_m), point(world.goal[1]))
    fx, fy = gradient_at_middle(mx, my, world, table)
    rx = radius(x)
    ry = radius(y)
    ok, nx, ny, sx, sy = newton_image(fx, fy, hxx, hxy, hyy, rx, ry)
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
def _under(gamma: Interval, world: World, level: float, t: FloatArray) -> bool:
    most = above(world.kappa * log_bounds(gamma[1])[1])
    for j in range(t.shape[0]):
        most = above(most - world.exponents[j] * log_bounds(t[j, BETA, 0])[0])
    return most <= level


@njit(cache=True, nogil=True)
def grow(
    x: float,
    y: float,
    world: World,
    level: float,
    table: FloatArray,
    box: FloatArray,
) -> int:
    """The kind of a root; the largest square tried that is proved to hold just it."""
    size = max(world.rim[2], world.rim[3])
    half = 1e-12 * size
    kind = NONE
    while half < size:
        last = kind
        found = enclose((x - half, x + half), (y - half, y + half), world, level, table)
        if found == NONE and last != NONE:
            break
        if found != NONE:
            kind = found
            box[0] = x - half
            box[1] = x + half
            box[2] = y - half
            box[3] = y + half
        half *= 4.0
    return kind


@njit(cache=True, nogil=True)
def minimum_near(
    x: float,
    y: float,
    leash: float,
    world: World,
    level: float,
    table: FloatArray,
    box: FloatArray,
) -> bool:
    """Whether a minimum about `leash` away was proved; its box (4,) is written.

    Gives up at once where psi is not convex at the point.
    """
    free, _, _, a, b, c = _at(x, y, world, table)
    if not (free and a + c > 0.0 and a * c - b * b > 0.0):
        return False
    found, x, y, _, _, _ = polish(x, y, 2.0 * leash, world, table)
    return found and grow(x, y, world, level, table, box) == MINIMUM
