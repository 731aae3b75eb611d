"""Branch and bound: a box that no test settles is halved until one does."""

from typing import Final

import numpy as np
from numba import njit

from bath_drake.certificate.box_test import CUT, OPEN, SADDLE, box_test
from bath_drake.certificate.evaluation import COLUMNS, middle
from bath_drake.certificate.intervals import Interval, above, below
from bath_drake.certificate.isolation import minimum_near
from bath_drake.certificate.world import World
from bath_drake.notation import FloatArray

# Tiles a side to begin with.
_TILES: Final = 12
_STACK: Final = 4096
# From this share of the workspace's size on a minimum is looked for in open boxes.
_SEARCH: Final = 0.05
# Kept of each kind of box; more are counted but not listed.
KEPT: Final = 2000
_TRAPS: Final = 64


@njit(cache=True, nogil=True)
def subdivide(
    world: World, level: float, resolution: float, budget: int
) -> tuple[FloatArray, FloatArray, FloatArray, int, int]:
    """Settles the workspace's bounding box.

    Args:
        world: The field.
        level: c, if only {psi <= c} is asked for; inf for all free space.
        resolution: Boxes not wider than this are left open, units of N.
        budget: How many boxes are looked at; the rest is left open.

    Returns:
        Boxes as rows x low, x high, y low, y high: those settled as SADDLE (n, 4),
        those left open (m, 4), those proved to hold just a minimum (k, 4), of each
        only the first ones; the true number of open boxes, on which alone a proof
        may rest; and how many boxes were looked at.
    """
    table = np.empty((world.exponents.shape[0], COLUMNS, 2))
    saddles = np.empty((KEPT, 4))
    left = np.empty((KEPT, 4))
    traps = np.empty((_TRAPS, 4))
    stack = np.empty((_STACK, 4))
    n_saddles = 0
    n_left = 0
    n_traps = 0
    looked_at = 0
    search = _SEARCH * max(world.rim[2], world.rim[3])
    for tile in range(_TILES * _TILES):
        _put_tile(tile, world.rim, stack[0])
        top = 1
        while top > 0:
            top -= 1
            x = (stack[top, 0], stack[top, 1])
            y = (stack[top, 2], stack[top, 3])
            if _within(x, y, traps, n_traps):
                continue
            found = OPEN
            exhausted = looked_at >= budget
            if not exhausted:
                looked_at += 1
                found = box_test(x, y, world, level, table)
            if found == SADDLE:
                if n_saddles < KEPT:
                    saddles[n_saddles] = stack[top]
                    n_saddles += 1
            if found not in (OPEN, CUT):
                continue
            width = max(x[1] - x[0], y[1] - y[0])
            # Newton's method is cheap, and one minimum decides the verdict.
            if (
                found == OPEN
                and not exhausted
                and width < search
                and n_traps < _TRAPS
                and minimum_near(
                    middle(x), middle(y), width, world, level, table, traps[n_traps]
                )
                and not _known(traps, n_traps)
            ):
                n_traps += 1
                if _within(x, y, traps, n_traps):
                    continue
            if exhausted or width <= resolution or top + 2 > _STACK:
                if n_left < KEPT:
                    left[n_left] = stack[top]
                n_left += 1
                continue
            stack[top + 1] = stack[top]
            if x[1] - x[0] >= y[1] - y[0]:
                stack[top, 1] = middle(x)
                stack[top + 1, 0] = stack[top, 1]
            else:
                stack[top, 3] = middle(y)
                stack[top + 1, 2] = stack[top, 3]
            top += 2
    return (
        saddles[:n_saddles],
        left[: min(n_left, KEPT)],
        traps[:n_traps],
        n_left,
        looked_at,
    )


@njit(cache=True, nogil=True)
def _put_tile(tile: int, rim: FloatArray, out: FloatArray) -> None:
    i = tile // _TILES
    j = tile % _TILES
    out[0] = _edge(rim[0], rim[2], i)
    out[1] = _edge(rim[0], rim[2], i + 1)
    out[2] = _edge(rim[1], rim[3], j)
    out[3] = _edge(rim[1], rim[3], j + 1)


@njit(cache=True, nogil=True)
def _edge(centre: float, half: float, i: int) -> float:
    """Edge i of the tiles along an axis; the outermost lie on or beyond the rim."""
    if i == 0:
        return below(below(centre - half))
    if i == _TILES:
        return above(above(centre + half))
    return centre + half * (2.0 * i / _TILES - 1.0)


@njit(cache=True, nogil=True)
def _within(x: Interval, y: Interval, traps: FloatArray, count: int) -> bool:
    """Whether a box lies in one that is known to hold a minimum and nothing else."""
    for k in range(count):
        if (
            x[0] >= traps[k, 0]
            and x[1] <= traps[k, 1]
            and y[0] >= traps[k, 2]
            and y[1] <= traps[k, 3]
        ):
            return True
    return False


@njit(cache=True, nogil=True)
def _known(traps: FloatArray, count: int) -> bool:
    """Whether the middle of row `count` lies in an earlier row."""
    x = 0.5 * (traps[count, 0] + traps[count, 1])
    y = 0.5 * (traps[count, 2] + traps[count, 3])
    return _within((x, x), (y, y), traps, count)
