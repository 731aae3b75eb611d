"""Where points stand, and the sublevel set that holds them."""

import math
from typing import Literal

import numpy as np
from numba import njit

from bath_drake.certificate.evaluation import BETA, evaluate, new_table
from bath_drake.certificate.isolation import psi_at
from bath_drake.certificate.world import World
from bath_drake.notation import FloatArray

Standing = Literal["free", "outside", "edge"]


def standing(world: World, q: FloatArray) -> tuple[Standing, int]:
    """Whether a point (2,) is in free space, and what is nearest to say so.

    Returns:
        'free' if every beta_j is proved positive, 'outside' if one is proved
        negative, else 'edge'; and the index j of the smallest, 0 for the rim.
    """
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


def level_of(world: World, points: FloatArray) -> float:
    """An upper bound of psi over points (n, 2), all of them in free space."""
    return float(_level(world, np.ascontiguousarray(points)))


@njit(cache=True, nogil=True)
def _level(world: World, points: FloatArray) -> float:
    table = new_table(world)
    most = -math.inf
    for i in range(points.shape[0]):
        most = max(most, psi_at(points[i, 0], points[i, 1], world, table))
    return most
