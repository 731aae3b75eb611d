"""Directions in which the force may point all over a box, guessed with floats.

Nothing here needs to be right: `box_test` proves what it uses.
"""

import math
from typing import Final

from numba import njit

from bath_drake.certificate.evaluation import (
    BETA,
    HXX,
    HXY,
    HYY,
    MID_BETA,
    MID_GX,
    MID_GY,
    WEIGHT,
    middle,
    radius,
)
from bath_drake.certificate.intervals import Interval
from bath_drake.certificate.world import World
from bath_drake.notation import FloatArray

# A boundary is near if beta falls below this share of its value at the middle: its
# quotient is then too wide to be weighed against others.
_NEAR: Final = 0.6


@njit(cache=True, nogil=True)
def _attraction(x: Interval, y: Interval, world: World) -> tuple[float, float]:
    px = middle(x) - world.goal[0]
    py = middle(y) - world.goal[1]
    k = -2.0 * world.kappa / (px * px + py * py)
    return k * px, k * py


@njit(cache=True, nogil=True)
def _is_near(t: FloatArray, j: int) -> bool:
    return bool(t[j, BETA, 0] < _NEAR * t[j, MID_BETA, 0])


@njit(cache=True, nogil=True)
def force_direction(
    x: Interval, y: Interval, world: World, t: FloatArray
) -> tuple[bool, float, float]:
    """The unit force -F at the middle, or out of the boundaries that cut the box."""
    fx, fy = _attraction(x, y, world)
    sx = 0.0
    sy = 0.0
    cut = False
    for j in range(t.shape[0]):
        gx = t[j, MID_GX, 0]
        gy = t[j, MID_GY, 0]
        if t[j, BETA, 0] <= 0.0:
            cut = True
            n = math.hypot(gx, gy)
            if n > 0.0:
                sx += gx / n
                sy += gy / n
        else:
            fx += t[j, WEIGHT, 0] * gx
            fy += t[j, WEIGHT, 0] * gy
    if cut:
        fx = sx
        fy = sy
    n = math.hypot(fx, fy)
    if not n > 0.0:
        return False, 0.0, 0.0
    return True, fx / n, fy / n


@njit(cache=True, nogil=True)
def escape_direction(
    x: Interval, y: Interval, world: World, t: FloatArray
) -> tuple[bool, float, float]:
    """A direction out of every near boundary, as much along the other forces as can be.

    Out of boundary j means within 90 degrees of its gradient all over the box, which
    is an arc of directions; the arcs are intersected. Behind an obstacle this finds
    the way along its side, where the force itself may point anywhere: boxes need then
    not be as thin as the layer in which the repulsion grows.
    """
    fx, fy = _attraction(x, y, world)
    rx = radius(x)
    ry = radius(y)
    base = 0.0
    low = 0.0
    high = 0.0
    none = True
    for j in range(t.shape[0]):
        gx = t[j, MID_GX, 0]
        gy = t[j, MID_GY, 0]
        if not _is_near(t, j):
            fx += t[j, WEIGHT, 0] * gx
            fy += t[j, WEIGHT, 0] * gy
            continue
        g = math.hypot(gx, gy)
        hxx = max(abs(t[j, HXX, 0]), abs(t[j, HXX, 1]))
        hxy = max(abs(t[j, HXY, 0]), abs(t[j, HXY, 1]))
        hyy = max(abs(t[j, HYY, 0]), abs(t[j, HYY, 1]))
        spread = math.hypot(hxx * rx + hxy * ry, hxy * rx + hyy * ry)
        if not spread < 0.99 * g:
            return False, 0.0, 0.0
        half = 0.5 * math.pi - 1.01 * math.asin(spread / g)
        angle = math.atan2(gy, gx)
        if none:
            base = angle
            low = -half
            high = half
            none = False
            continue
        angle = _wrap(angle - base)
        low = max(low, angle - half)
        high = min(high, angle + half)
    if none or low > high:
        return False, 0.0, 0.0
    angle = _wrap(math.atan2(fy, fx) - base)
    if not low <= angle <= high:
        to_low = abs(_wrap(angle - low))
        to_high = abs(_wrap(angle - high))
        angle = low if to_low < to_high else high
    return True, math.cos(base + angle), math.sin(base + angle)


@njit(cache=True, nogil=True)
def _wrap(angle: float) -> float:
    """The same angle in [-pi, pi], for one within three half turns."""
    if angle > math.pi:
        return angle - 2.0 * math.pi
    if angle < -math.pi:
        return angle + 2.0 * math.pi
    return angle
