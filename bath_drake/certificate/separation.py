"""Which part of a sublevel set can be reached: a flood fill that cannot leak.

{psi <= c} may have several components, and a trap in another one than the start's is
none for it. On a grid of closed cells, those where psi > c is proved are walls. The
cells connected with the start's through others that are no walls hold all of its
component, and perhaps more: what meets none of them cannot be reached.
"""

from typing import Final

import numpy as np
from numba import njit
from scipy.ndimage import label

from bath_drake.certificate.evaluation import evaluate, new_table
from bath_drake.certificate.intervals import above, add, below, point, square, subtract
from bath_drake.certificate.isolation import MINIMUM, tighten
from bath_drake.certificate.levels import is_above, is_under
from bath_drake.certificate.world import World
from bath_drake.notation import BoolArray, FloatArray

# Cells a side, a power of two: a box is halved until it is a cell.
_CELLS: Final = 256


def within_reach(
    world: World, level: float, starts: FloatArray, roots: FloatArray, left: FloatArray
) -> tuple[FloatArray, FloatArray, bool]:
    """Leaves out what no motion from the starts can come to.

    Args:
        world: The field.
        level: c, at least psi at every start.
        starts: Points (n, 2) of free space.
        roots: Critical points, rows (m, 9) of `isolation.critical_point_near`.
        left: Open boxes, rows (k, 4) of x low, x high, y low, y high.

    Returns:
        The roots and boxes that may meet the components of {psi <= c} that hold the
        starts, and whether a minimum or a box was left out.
    """
    minima = roots[:, 4] == MINIMUM
    if not (minima.any() or len(left)):
        return roots, left, False
    table = new_table(world)
    # An enclosure may be wide; of the others the point found will do for a list.
    tight = [
        tighten(row, world, table) if minimum else row[[0, 0, 1, 1]]
        for row, minimum in zip(roots, minima, strict=True)
    ]
    boxes = np.concatenate([np.reshape(tight, (-1, 4)), left])
    reached = _can_be_reached(world, level, starts, boxes)
    keep, stay = reached[: len(roots)], reached[len(roots) :]
    apart = not (keep[minima].all() and stay.all())
    return roots[keep], left[stay], apart


def _can_be_reached(
    world: World, level: float, starts: FloatArray, boxes: FloatArray
) -> BoolArray:
    """False (m,) only where a box (m, 4) is proved to meet none of the components."""
    walls = np.zeros((_CELLS, _CELLS), dtype=np.bool_)
    _build_walls(world, level, walls)
    # Closed cells touch at corners too.
    parts, _ = label(~walls, structure=np.ones((3, 3)))
    around = [parts[_cells(world.rim, q[[0, 0, 1, 1]])].ravel() for q in starts]
    entered = np.setdiff1d(np.concatenate(around), [0])
    return np.array(
        [np.isin(parts[_cells(world.rim, box)], entered).any() for box in boxes],
        dtype=np.bool_,
    )


def _cells(rim: FloatArray, box: FloatArray) -> tuple[slice, slice]:
    """The cells that meet a box, and a ring of one more for rounding."""
    share = (box.reshape(2, 2) - rim[:2, None]) / rim[2:4, None]
    cell = np.floor((share + 1.0) / 2.0 * _CELLS).astype(int)
    first = np.clip(cell[:, 0] - 1, 0, _CELLS - 1)
    last = np.clip(cell[:, 1] + 2, 1, _CELLS)
    return slice(first[0], last[0]), slice(first[1], last[1])


@njit(cache=True, nogil=True)
def _build_walls(world: World, level: float, walls: BoolArray) -> None:
    table = new_table(world)
    rim = world.rim
    # Blocks of cells: first row, first column, side.
    stack = np.empty((64, 3), dtype=np.int64)
    stack[0] = 0
    stack[0, 2] = _CELLS
    top = 1
    while top > 0:
        top -= 1
        i, j, n = stack[top]
        x = (_edge(rim[0], rim[2], i, -1.0), _edge(rim[0], rim[2], i + n, 1.0))
        y = (_edge(rim[1], rim[3], j, -1.0), _edge(rim[1], rim[3], j + n, 1.0))
        wall = True
        if evaluate(x, y, world, table):
            px = subtract(x, point(world.goal[0]))
            py = subtract(y, point(world.goal[1]))
            gamma = add(square(px), square(py))
            wall = is_above(gamma, world, level, table)
            if not wall and n > 1 and not is_under(gamma, world, level, table):
                h = n // 2
                for k in range(4):
                    stack[top, 0] = i + h * (k % 2)
                    stack[top, 1] = j + h * (k // 2)
                    stack[top, 2] = h
                    top += 1
                continue
        if wall:
            walls[i : i + n, j : j + n] = True


@njit(cache=True, nogil=True)
def _edge(centre: float, half: float, i: int, side: float) -> float:
    """A cell's edge, moved out a little so that neighbours overlap."""
    edge = centre + half * (2.0 * i / _CELLS - 1.0)
    slack = 1e-14 * (abs(centre) + half)
    return below(edge - slack) if side < 0.0 else above(edge + slack)
