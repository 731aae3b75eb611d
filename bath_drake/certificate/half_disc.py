"""Proofs about a closed half-disc {|q - c| <= r, (q - c) . d >= 0}: a chain's gate.

Branch and bound over the boxes that meet it. A gate is the row (centre x, y, direction
x, y, radius) of exact floats; the direction need not be a unit vector to the last bit.
"""

import math
from typing import Final

import numpy as np
from numba import njit

from bath_drake.certificate.evaluation import (
    BETA,
    HXX,
    HYY,
    MID_BETA,
    MID_GX,
    MID_GY,
    TINY,
    evaluate,
    get,
    middle,
    new_table,
    radius,
)
from bath_drake.certificate.intervals import (
    Interval,
    above,
    add,
    below,
    magnitude,
    point,
    reach,
    scale,
    square,
    subtract,
)
from bath_drake.certificate.world import World, log_bounds
from bath_drake.notation import FloatArray

_STACK: Final = 512
# Bounds are made no sharper: of the least beta by this share of it, of psi by this
# share of kappa and the exponents.
_SHARE: Final = 0.1
_SLACK: Final = 0.02

FREE: Final = 0
NOT_FREE: Final = 1
STUCK: Final = 2


@njit(cache=True, nogil=True)
def outside(x: Interval, y: Interval, gate: FloatArray) -> bool:
    """Whether a box is proved to meet no point of the half-disc."""
    dx = subtract(x, point(gate[0]))
    dy = subtract(y, point(gate[1]))
    if add(scale(gate[2], dx), scale(gate[3], dy))[1] < 0.0:
        return True
    return add(square(dx), square(dy))[0] > square(point(gate[4]))[1]


@njit(cache=True, nogil=True)
def inside(x: Interval, y: Interval, gate: FloatArray) -> bool:
    """Whether a box is proved to lie in the half-disc's interior."""
    dx = subtract(x, point(gate[0]))
    dy = subtract(y, point(gate[1]))
    if not add(scale(gate[2], dx), scale(gate[3], dy))[0] > 0.0:
        return False
    return add(square(dx), square(dy))[1] < square(point(gate[4]))[0]


@njit(cache=True, nogil=True)
def least_beta(
    world: World, gate: FloatArray, resolution: float, budget: int
) -> tuple[int, float, FloatArray, int]:
    """Bounds the least beta_j over a half-disc from below.

    Args:
        world: The field.
        gate: Shape (5,).
        resolution: Boxes not wider than this are left open, units of N.
        budget: How many boxes are looked at.

    Returns:
        FREE and a positive bound, with the box it is of; NOT_FREE and a point (a box
        of no width) of the half-disc at which a beta_j is proved to be zero or less;
        or STUCK and a box that is open. Then how many boxes were looked at.
    """
    table = new_table(world)
    stack = np.empty((_STACK, 4))
    put_hull(gate, stack[0])
    top = 1
    looked_at = 0
    most = math.inf  # the least beta is not greater
    least = math.inf
    where = stack[0].copy()
    while top > 0:
        top -= 1
        x = (stack[top, 0], stack[top, 1])
        y = (stack[top, 2], stack[top, 3])
        if outside(x, y, gate):
            continue
        looked_at += 1
        px, py = _pulled_in(middle(x), middle(y), gate)
        if inside(point(px), point(py), gate):
            free = evaluate(point(px), point(py), world, table)
            high = _least(table, 1) if free else 0.0
            if high <= 0.0:
                where[0] = where[1] = px
                where[2] = where[3] = py
                return NOT_FREE, 0.0, where, looked_at
            most = min(most, high)
        low = -math.inf
        if evaluate(x, y, world, table):
            low = _least(table, 0)
            if low < (1.0 - _SHARE) * most:
                low = _least_within(x, y, gate, table)
        if low > 0.0 and low >= (1.0 - _SHARE) * most:
            if low < least:
                least = low
                copy_box(stack[top], where)
            continue
        width = max(x[1] - x[0], y[1] - y[0])
        if looked_at >= budget or width <= resolution or top + 2 > _STACK:
            if low > 0.0:  # not as sharp as wanted, but proved
                if low < least:
                    least = low
                    copy_box(stack[top], where)
                continue
            copy_box(stack[top], where)
            return STUCK, 0.0, where, looked_at
        halve(stack, top)
        if low <= 0.0 and _is_lower(stack[top], stack[top + 1], world, table):
            # The last is looked at first: where a point that is not free may be.
            copy_box(stack[top], where)
            copy_box(stack[top + 1], stack[top])
            copy_box(where, stack[top + 1])
        top += 2
    return FREE, least, where, looked_at


@njit(cache=True, nogil=True)
def most_psi(world: World, gate: FloatArray, budget: int) -> tuple[float, int]:
    """Bounds psi over a half-disc in free space from above; and the boxes looked at.

    The bound is inf where the budget is too small to find one.
    """
    table = new_table(world)
    stack = np.empty((_STACK, 4))
    put_hull(gate, stack[0])
    slack = _SLACK * (world.kappa + world.exponents.sum())
    top = 1
    looked_at = 0
    reached = -math.inf
    most = -math.inf
    while top > 0:
        top -= 1
        x = (stack[top, 0], stack[top, 1])
        y = (stack[top, 2], stack[top, 3])
        if outside(x, y, gate):
            continue
        looked_at += 1
        px, py = _pulled_in(middle(x), middle(y), gate)
        if evaluate(point(px), point(py), world, table):
            here = _psi_under(point(px), point(py), world, table)
            if here < math.inf:  # only a guide: rounding does not matter
                reached = max(reached, here)
        high = math.inf
        if evaluate(x, y, world, table):
            high = _psi_under(x, y, world, table)
        if high <= reached + slack:
            most = max(most, high)
            continue
        if looked_at >= budget or top + 2 > _STACK:
            most = max(most, high)
            continue
        halve(stack, top)
        top += 2
    return most, looked_at


@njit(cache=True, nogil=True)
def put_hull(gate: FloatArray, out: FloatArray) -> None:
    """Writes a box that holds the half-disc's whole disc."""
    for k in range(2):
        out[2 * k] = below(gate[k] - gate[4])
        out[2 * k + 1] = above(gate[k] + gate[4])


@njit(cache=True, nogil=True)
def copy_box(box: FloatArray, out: FloatArray) -> None:
    """Copies a box: numba compiles an assignment to a slice for many seconds."""
    for k in range(4):
        out[k] = box[k]


@njit(cache=True, nogil=True)
def halve(stack: FloatArray, top: int) -> None:
    """Puts the halves of the box in row `top` into rows `top` and `top` + 1."""
    copy_box(stack[top], stack[top + 1])
    x = (stack[top, 0], stack[top, 1])
    y = (stack[top, 2], stack[top, 3])
    if x[1] - x[0] >= y[1] - y[0]:
        stack[top, 1] = middle(x)
        stack[top + 1, 0] = stack[top, 1]
    else:
        stack[top, 3] = middle(y)
        stack[top + 1, 2] = stack[top, 3]


@njit(cache=True, nogil=True)
def _pulled_in(x: float, y: float, gate: FloatArray) -> tuple[float, float]:
    """A point near (x, y), a little within the half-disc, in floats: a guess."""
    margin = 1e-9 * gate[4]
    x -= gate[0]
    y -= gate[1]
    ahead = x * gate[2] + y * gate[3]
    if ahead < margin:
        x += (margin - ahead) * gate[2]
        y += (margin - ahead) * gate[3]
    far = math.hypot(x, y)
    if far > gate[4] - margin:
        # Shrunk towards a point a little ahead, so that it stays ahead.
        share = (gate[4] - 2.0 * margin) / far
        x = share * x + margin * gate[2]
        y = share * y + margin * gate[3]
    return gate[0] + x, gate[1] + y


@njit(cache=True, nogil=True)
def _least(table: FloatArray, end: int) -> float:
    least = math.inf
    for j in range(table.shape[0]):
        least = min(least, table[j, BETA, end])
    return least


@njit(cache=True, nogil=True)
def _least_within(x: Interval, y: Interval, gate: FloatArray, t: FloatArray) -> float:
    """A lower bound of every beta_j over the half-disc's part of an evaluated box.

    By the tangent plane at the middle: an ellipse's beta lies above it, the rim's below
    by the second-order term at most. Beside a boundary that nearly touches the gate's
    own this spares most boxes.
    """
    rx = radius(x)
    ry = radius(y)
    least = math.inf
    for j in range(t.shape[0]):
        gx = get(t, j, MID_GX)
        gy = get(t, j, MID_GY)
        low = below(t[j, MID_BETA, 0] + _least_slope(x, y, gx, gy, rx, ry, gate))
        if j == 0:
            xx = above(magnitude(get(t, 0, HXX)) * above(rx * rx))
            yy = above(magnitude(get(t, 0, HYY)) * above(ry * ry))
            low = below(low - above(0.5 * above(xx + yy)))
        # What `evaluate` found holds too.
        least = min(least, max(low, t[j, BETA, 0]))
    return least


@njit(cache=True, nogil=True)
def _least_slope(
    x: Interval,
    y: Interval,
    gx: Interval,
    gy: Interval,
    rx: float,
    ry: float,
    gate: FloatArray,
) -> float:
    """A lower bound of g . (q - m) over the half-disc's part of a box about m.

    g is split into a vector h and the rest: h . (q - m) is bounded over the half-disc,
    the rest over the box. Any h will do: one across the half circle and one across the
    straight side are tried.
    """
    mx = middle(x)
    my = middle(y)
    dx = subtract(point(gate[0]), point(mx))
    dy = subtract(point(gate[1]), point(my))
    best = -math.inf
    for k in range(2):
        ux = gate[2] if k == 0 else mx - gate[0]
        uy = gate[3] if k == 0 else my - gate[1]
        share = (middle(gx) * ux + middle(gy) * uy) / max(ux * ux + uy * uy, 1e-300)
        hx = share * ux
        hy = share * uy
        over_gate = add(scale(hx, dx), scale(hy, dy))[0]
        over_gate = below(over_gate - _support(hx, hy, gate))
        rest_x = subtract(gx, point(hx))
        rest_y = subtract(gy, point(hy))
        best = max(best, below(over_gate - reach(rest_x, rx, rest_y, ry)))
    return best


@njit(cache=True, nogil=True)
def _support(hx: float, hy: float, gate: FloatArray) -> float:
    """An upper bound of -h . (q - c) over the half-disc."""
    # Along the straight side, should h point ahead; directions are units to 1e-12.
    ahead = add(scale(gate[2], point(hx)), scale(gate[3], point(hy)))
    length = above(above(math.hypot(hx, hy)))
    if ahead[0] > 0.0:
        across = subtract(scale(gate[2], point(hy)), scale(gate[3], point(hx)))
        length = min(length, above(magnitude(across) * (1.0 + 1e-11)))
    return above(length * gate[4])


@njit(cache=True, nogil=True)
def _is_lower(a: FloatArray, b: FloatArray, world: World, table: FloatArray) -> bool:
    """Whether the least beta_j is lower in the middle of a box than in another's."""
    value = np.empty(2)
    for k in range(2):
        box = a if k == 0 else b
        x = point(middle((box[0], box[1])))
        y = point(middle((box[2], box[3])))
        value[k] = -1.0
        if evaluate(x, y, world, table):
            value[k] = _least(table, 1)
    return bool(value[0] < value[1])


@njit(cache=True, nogil=True)
def _psi_under(x: Interval, y: Interval, world: World, table: FloatArray) -> float:
    """An upper bound of psi over an evaluated box; inf if it is not proved free."""
    px = subtract(x, point(world.goal[0]))
    py = subtract(y, point(world.goal[1]))
    gamma = max(add(square(px), square(py))[1], 1e-300)
    most = above(world.kappa * log_bounds(gamma)[1])
    for j in range(table.shape[0]):
        if not table[j, BETA, 0] > TINY:
            return math.inf
        low = log_bounds(table[j, BETA, 0])[0]
        most = above(most - below(world.exponents[j] * low))
    return most
