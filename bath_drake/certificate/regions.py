"""Where points stand, and the sublevel set that holds them."""

import math
from typing import Final, Literal

import numpy as np
from numba import njit

from bath_drake.certificate.evaluation import BETA, evaluate, new_table
from bath_drake.certificate.intervals import Interval
from bath_drake.certificate.levels import psi_at
from bath_drake.certificate.world import World
from bath_drake.notation import FloatArray

Standing = Literal["free", "outside", "edge"]


def standing(world: World, q: FloatArray) -> tuple[Standing, int]:
    """Whether a point (2,) is in free space, and what is nearest to say so.

    Returns:
        'free' if every beta_j is proved positive, 'outside' if one is proved
        negative, else 'edge'; and the index j of the smallest, 0 for the rim.
    """
    # Far away the numbers would overflow; nothing is free there.
    if (np.abs(q - world.rim[:2]) > 2.0 * world.rim[2:4]).any():
        return "outside", 0
    table = new_table(world)
    if not evaluate((q[0], q[0]), (q[1], q[1]), world, table):
        return "outside", _first_outside(world, q)
    low = table[:, BETA, 0]
    j = int(np.argmin(low))
    return ("free" if low[j] > 0.0 else "edge"), j


def _first_outside(world: World, q: FloatArray) -> int:
    """The boundary on whose wrong side a point lies, each looked at by itself."""
    for i in range(len(world.obstacles)):
        alone = world._replace(
            obstacles=world.obstacles[i : i + 1].copy(), exponents=np.ones(2)
        )
        table = new_table(alone)
        inside_rim = world.rim.copy()
        inside_rim[:2] = q  # so that only the obstacle can say no
        alone = alone._replace(rim=inside_rim)
        if not evaluate((q[0], q[0]), (q[1], q[1]), alone, table):
            return i + 1
    return 0


WHOLE: Final = (math.inf, math.inf)
"""The level of all free space."""


def level_of(world: World, points: FloatArray) -> Interval:
    """Bounds of the greatest psi of points (n, 2), all of them in free space.

    With uncertain obstacles each realisation has a level of its own, all within.
    """
    low, high = _level(world, np.ascontiguousarray(points))
    return float(low), float(high)


@njit(cache=True, nogil=True)
def _level(world: World, points: FloatArray) -> Interval:
    table = new_table(world)
    low = -math.inf
    high = -math.inf
    for i in range(points.shape[0]):
        psi = psi_at(points[i, 0], points[i, 1], world, table)
        low = max(low, psi[0])
        high = max(high, psi[1])
    return low, high
