"""Branch and bound: a box that no test settles is halved until one does."""

from typing import Final

import numpy as np
from numba import njit

from bath_drake.certificate.box_test import CONVEX, OPEN, SADDLE, box_test
from bath_drake.certificate.evaluation import middle, new_table
from bath_drake.certificate.half_disc import copy_box
from bath_drake.certificate.intervals import Interval, above, below
from bath_drake.certificate.isolation import (
    MINIMUM,
    NONE,
    critical_point_near,
)
from bath_drake.certificate.levels import psi_at
from bath_drake.certificate.world import World
from bath_drake.notation import FloatArray

# Tiles a side to begin with.
_TILES: Final = 12
_STACK: Final = 4096
# From this share of the workspace's size on, boxes are searched for minima.
_SEARCH: Final = 0.05
# Kept of each kind; more open boxes are counted but not listed.
_KEPT: Final = 2000
_ROOTS: Final = 256


@njit(cache=True, nogil=True)
def subdivide(
    world: World, level: Interval, resolution: float, budget: int
) -> tuple[FloatArray, FloatArray, int, int]:
    """Settles the workspace's bounding box.

    Newton's method is cheap: it starts in every box that may hold a minimum or
    a saddle.
    What it finds is enclosed, and boxes within the enclosure are settled by it.

    Args:
        world: The field.
        level: Bounds of c, if only {psi <= c} is asked for; inf for all free space.
        resolution: Boxes not wider than this are left open, units of N.
        budget: How many boxes are looked at; the rest is left open.

    Returns:
        Critical points, rows (n, 9) of `critical_point_near`; boxes left open, rows
        (m, 4) of x low, x high, y low, y high, only the first ones; the true number
        of open boxes; and how many boxes were looked at. A proof needs zero open
        boxes and no minimum among the critical points.
    """
    table = new_table(world)
    roots = np.empty((_ROOTS, 9))
    left = np.empty((_KEPT, 4))
    stack = np.empty((_STACK, 4))
    n_roots = 0
    n_left = 0
    looked_at = 0
    search = _SEARCH * max(world.rim[2], world.rim[3])
    for tile in range(_TILES * _TILES):
        _put_tile(tile, world.rim, stack[0])
        top = 1
        while top > 0:
            top -= 1
            x = (stack[top, 0], stack[top, 1])
            y = (stack[top, 2], stack[top, 3])
            if _within(x, y, roots[:n_roots]):
                continue
            width = max(x[1] - x[0], y[1] - y[0])
            exhausted = looked_at >= budget
            found = OPEN
            if not exhausted:
                looked_at += 1
                found = box_test(x, y, world, level[1], table)
            if (found == SADDLE or (found == CONVEX and width < search)) and (
                n_roots < _ROOTS
                and critical_point_near(x, y, world, table, roots[n_roots])
                and _is_new(roots[n_roots], roots[:n_roots], search)
                and _counts(roots[n_roots], level[0], world, table)
            ):
                n_roots += 1
                if _within(x, y, roots[:n_roots]):
                    continue
            if found != OPEN and found != CONVEX:
                continue
            if exhausted or width <= resolution or top + 2 > _STACK:
                if n_left < _KEPT:
                    copy_box(stack[top], left[n_left])
                n_left += 1
                continue
            copy_box(stack[top], stack[top + 1])
            if x[1] - x[0] >= y[1] - y[0]:
                stack[top, 1] = middle(x)
                stack[top + 1, 0] = stack[top, 1]
            else:
                stack[top, 3] = middle(y)
                stack[top + 1, 2] = stack[top, 3]
            top += 2
    return roots[:n_roots], left[: min(n_left, _KEPT)], n_left, looked_at


@njit(cache=True, nogil=True)
def _within(x: Interval, y: Interval, roots: FloatArray) -> bool:
    """Whether a box lies in one proved to hold a critical point and no other."""
    for k in range(roots.shape[0]):
        if (
            roots[k, 4] != NONE
            and x[0] >= roots[k, 5]
            and x[1] <= roots[k, 6]
            and y[0] >= roots[k, 7]
            and y[1] <= roots[k, 8]
        ):
            return True
    return False


@njit(cache=True, nogil=True)
def _is_new(root: FloatArray, roots: FloatArray, search: float) -> bool:
    near = 1e-7 * search
    for k in range(roots.shape[0]):
        if abs(root[0] - roots[k, 0]) <= near and abs(root[1] - roots[k, 1]) <= near:
            return False
    return True


@njit(cache=True, nogil=True)
def _counts(root: FloatArray, level: float, world: World, table: FloatArray) -> bool:
    """Whether a critical point may settle boxes of {psi <= c} for every c >= level.

    psi is convex in a minimum's box, so that the minimum is no higher than psi is at
    the point found. One that may lie above the level is left to the tests.
    """
    if root[4] != MINIMUM or level == np.inf:
        return True
    return psi_at(root[0], root[1], world, table)[1] <= level


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
