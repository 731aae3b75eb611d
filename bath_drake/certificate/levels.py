"""Bounds of psi itself: at a point, and over a box against a level."""

import math

from numba import njit

from bath_drake.certificate.evaluation import BETA, TINY, evaluate
from bath_drake.certificate.intervals import (
    Interval,
    above,
    add,
    below,
    point,
    square,
    subtract,
)
from bath_drake.certificate.world import World, log_bounds
from bath_drake.notation import FloatArray


@njit(cache=True, nogil=True)
def psi_at(x: float, y: float, world: World, table: FloatArray) -> Interval:
    """Bounds of psi at a point of free space."""
    evaluate(point(x), point(y), world, table)
    px = subtract(point(x), point(world.goal[0]))
    py = subtract(point(y), point(world.goal[1]))
    gamma = add(square(px), square(py))
    # At the goal itself psi is -inf.
    low = -math.inf
    if gamma[0] > 0.0:
        low = below(world.kappa * log_bounds(gamma[0])[0])
    high = above(world.kappa * log_bounds(max(gamma[1], 1e-300))[1])
    for j in range(table.shape[0]):
        w = world.exponents[j]
        low = below(low - above(w * log_bounds(table[j, BETA, 1])[1]))
        high = above(high - below(w * log_bounds(table[j, BETA, 0])[0]))
    return low, high


@njit(cache=True, nogil=True)
def is_above(gamma: Interval, world: World, level: float, table: FloatArray) -> bool:
    """Whether psi > level is proved for the free part of an evaluated box."""
    if not gamma[0] > TINY:
        return False
    least = below(world.kappa * log_bounds(gamma[0])[0])
    for j in range(table.shape[0]):
        high = log_bounds(table[j, BETA, 1])[1]
        least = below(least - above(world.exponents[j] * high))
    return least > level


@njit(cache=True, nogil=True)
def is_under(gamma: Interval, world: World, level: float, table: FloatArray) -> bool:
    """Whether an evaluated box is proved to be free and psi <= level all over it."""
    most = above(world.kappa * log_bounds(gamma[1])[1])
    for j in range(table.shape[0]):
        if not table[j, BETA, 0] > TINY:
            return False
        low = log_bounds(table[j, BETA, 0])[0]
        most = above(most - below(world.exponents[j] * low))
    return most <= level
