"""Can stable curves run along a gate's boundary, and do any lie as low as the gate?

A gate's boundary is two pieces, a half circle and its straight side, and on the part of
a piece that lies in free space n . grad psi times gamma is analytic, n being the
piece's normal. If it is not zero at one point of a stretch, then its zeros on that
stretch are finitely many: curves of the flow pass through the others, and each of
them at countably many points only.
"""

import math
from typing import Final

import numpy as np
from numba import njit

from bath_drake.certificate.box_test import CONVEX, OPEN, SADDLE, box_test
from bath_drake.certificate.evaluation import (
    BETA,
    GX,
    GY,
    TINY,
    evaluate,
    get,
    new_table,
)
from bath_drake.certificate.half_disc import halve, outside
from bath_drake.certificate.intervals import (
    Interval,
    above,
    add,
    below,
    divide,
    multiply,
    point,
    scale,
    square,
    subtract,
    widen,
)
from bath_drake.certificate.world import World
from bath_drake.notation import FloatArray

_STACK: Final = 512

APART: Final = 0
CROSSED: Final = 1
NOT_SHOWN: Final = 2


@njit(cache=True, nogil=True)
def boundary_is_crossed(
    world: World, gate: FloatArray, within: FloatArray, budget: int
) -> tuple[int, int]:
    """Looks at the part of a gate's boundary that lies in other half-discs.

    Args:
        world: The field into whose free space this part is to lie.
        gate: The half-disc, shape (5,).
        within: The others, shape (n, 5); none for the whole boundary.
        budget: How many stretches are looked at.

    Returns:
        APART if there is no such part; CROSSED if it is covered by stretches in free
        space with a point each at which the flow is proved to cross it; else
        NOT_SHOWN. And how many stretches were looked at.
    """
    table = new_table(world)
    stack = np.empty((_STACK, 3))
    # Each piece from -1 to 1: along the half circle and along the straight side.
    stack[0] = (0.0, -1.0, 1.0)
    stack[1] = (1.0, -1.0, 1.0)
    top = 2
    looked_at = 0
    found = APART
    while top > 0:
        top -= 1
        piece = int(stack[top, 0])
        low = stack[top, 1]
        high = stack[top, 2]
        looked_at += 1
        x, y = _stretch(piece, low, high, gate)
        apart = False
        for i in range(within.shape[0]):
            apart = apart or outside(x, y, within[i])
        if apart:
            continue
        if _is_free(x, y, world, table) and _is_crossed_at(
            piece, 0.5 * (low + high), gate, world, table
        ):
            found = CROSSED
            continue
        if looked_at >= budget or high - low < 1e-9 or top + 2 > _STACK:
            return NOT_SHOWN, looked_at
        at = low + 0.5 * (high - low)
        stack[top, 2] = at
        stack[top + 1] = (float(piece), at, high)
        top += 2
    return found, looked_at


@njit(cache=True, nogil=True)
def goal_is_alone(
    world: World, level: float, resolution: float, budget: int
) -> tuple[bool, int]:
    """Whether {psi <= level} is proved to hold no critical point; boxes looked at."""
    table = new_table(world)
    stack = np.empty((_STACK, 4))
    for k in range(2):
        stack[0, 2 * k] = below(below(world.rim[k] - world.rim[2 + k]))
        stack[0, 2 * k + 1] = above(above(world.rim[k] + world.rim[2 + k]))
    top = 1
    looked_at = 0
    while top > 0:
        top -= 1
        x = (stack[top, 0], stack[top, 1])
        y = (stack[top, 2], stack[top, 3])
        looked_at += 1
        found = box_test(x, y, world, level, table)
        if found != SADDLE and found != OPEN and found != CONVEX:
            continue
        width = max(x[1] - x[0], y[1] - y[0])
        if looked_at >= budget or width <= resolution or top + 2 > _STACK:
            return False, looked_at
        halve(stack, top)
        top += 2
    return True, looked_at


@njit(cache=True, nogil=True)
def _stretch(
    piece: int, low: float, high: float, gate: FloatArray
) -> tuple[Interval, Interval]:
    """A box that holds the points of a piece from `low` to `high`."""
    r = gate[4]
    ax, ay = _at(piece, low, gate)
    bx, by = _at(piece, high, gate)
    # Of a chord's points the arc is off by at most r (half the angle)^2 / 2; the rest
    # covers what rounding errs in `_at`.
    bulge = 1e-14 * (abs(gate[0]) + abs(gate[1]) + r)
    if piece == 0:
        half = 0.25 * math.pi * (high - low)
        bulge = above(bulge + 0.51 * r * half * half)
    x = widen((min(ax, bx), max(ax, bx)), bulge)
    y = widen((min(ay, by), max(ay, by)), bulge)
    return x, y


@njit(cache=True, nogil=True)
def _at(piece: int, s: float, gate: FloatArray) -> tuple[float, float]:
    """A float point near a piece's point s in [-1, 1].

    Within 1e-14 of size of one of its points, as directions are units to 1e-12 only:
    the half circle's are at the distance r, the straight side's on its line.
    """
    length = math.hypot(gate[2], gate[3])
    ux = gate[2] / length
    uy = gate[3] / length
    along = 0.0
    across = gate[4] * s
    if piece == 0:
        along = gate[4] * math.cos(0.5 * math.pi * s)
        across = gate[4] * math.sin(0.5 * math.pi * s)
    return (
        gate[0] + along * ux - across * uy,
        gate[1] + along * uy + across * ux,
    )


@njit(cache=True, nogil=True)
def _is_free(x: Interval, y: Interval, world: World, table: FloatArray) -> bool:
    if not evaluate(x, y, world, table):
        return False
    for j in range(table.shape[0]):
        if not table[j, BETA, 0] > TINY:
            return False
    return True


@njit(cache=True, nogil=True)
def _is_crossed_at(
    piece: int, s: float, gate: FloatArray, world: World, table: FloatArray
) -> bool:
    """Whether n . grad psi is proved not to be zero at a piece's point."""
    qx, qy = _at(piece, s, gate)
    slack = 1e-14 * (abs(gate[0]) + abs(gate[1]) + gate[4])
    x = widen(point(qx), slack)
    y = widen(point(qy), slack)
    px = subtract(x, point(world.goal[0]))
    py = subtract(y, point(world.goal[1]))
    gamma = add(square(px), square(py))
    if not gamma[0] > TINY or not _is_free(x, y, world, table):
        return False
    fx = divide(scale(2.0 * world.kappa, px), gamma)
    fy = divide(scale(2.0 * world.kappa, py), gamma)
    for j in range(table.shape[0]):
        beta = get(table, j, BETA)
        w = world.exponents[j]
        fx = subtract(fx, scale(w, divide(get(table, j, GX), beta)))
        fy = subtract(fy, scale(w, divide(get(table, j, GY), beta)))
    nx = point(gate[2])
    ny = point(gate[3])
    if piece == 0:
        nx = subtract(x, point(gate[0]))
        ny = subtract(y, point(gate[1]))
    along = add(multiply(nx, fx), multiply(ny, fy))
    return along[0] > 0.0 or along[1] < 0.0
