"""A mask's connected parts: runs of pixels in its rows, joined where they touch."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from bath_drake.notation import BoolArray, IntArray


@dataclass(frozen=True, eq=False)
class Components:
    """The 4-connected components of a mask, in the order of their first pixels.

    Attributes:
        shape: (H, W) of the mask.
        runs: (r, 4) row, first column, column after the last, component.
        sizes: (m,) pixels of each component.
        at_edge: (m,) whether it touches the mask's edge.
    """

    shape: tuple[int, int]
    runs: IntArray
    sizes: IntArray
    at_edge: BoolArray

    def painted(self, chosen: BoolArray) -> BoolArray:
        """Returns a mask (H, W) of the components (m,) that are chosen."""
        mask = np.zeros(self.shape, dtype=np.bool_)
        _paint(self.runs, chosen, mask)
        return mask

    def counted(self, mask: BoolArray) -> IntArray:
        """Returns how many pixels (m,) of each are in a mask (H, W)."""
        counts = np.zeros(len(self.sizes), dtype=np.int64)
        _count(self.runs, np.ascontiguousarray(mask), counts)
        return counts


def components(mask: BoolArray) -> Components:
    """Returns the 4-connected components of a mask (H, W)."""
    rows, columns = mask.shape
    runs = _runs(np.ascontiguousarray(mask))
    sizes, at_edge = _join(runs, rows, columns)
    return Components((rows, columns), runs, sizes, at_edge)


@njit(cache=True)
def _runs(mask: BoolArray) -> IntArray:
    rows, columns = mask.shape
    count = 0
    for v in range(rows):
        before = False
        for u in range(columns):
            count += mask[v, u] and not before
            before = mask[v, u]
    runs = np.empty((count, 4), dtype=np.int64)
    n = 0
    for v in range(rows):
        before = False
        for u in range(columns):
            here = mask[v, u]
            if here and not before:
                runs[n, 0], runs[n, 1], runs[n, 3] = v, u, n
            elif before and not here:
                runs[n, 2] = u
                n += 1
            before = here
        if before:
            runs[n, 2] = columns
            n += 1
    return runs


@njit(cache=True)
def _join(runs: IntArray, rows: int, columns: int) -> tuple[IntArray, BoolArray]:
    """Numbers the components of runs in place; their sizes and which touch the edge."""
    above = 0
    for n in range(len(runs)):
        row, first, end = runs[n, 0], runs[n, 1], runs[n, 2]
        # All before it are of rows further up, or end left of this one.
        while above < n and (
            runs[above, 0] < row - 1
            or (runs[above, 0] == row - 1 and runs[above, 2] <= first)
        ):
            above += 1
        k = above
        while k < n and runs[k, 0] == row - 1 and runs[k, 1] < end:
            a, b = _root(runs, k), _root(runs, n)
            runs[max(a, b), 3] = min(a, b)
            k += 1
    count = 0
    # A root is the first of its component: its number is known before the others'.
    for n in range(len(runs)):
        if runs[n, 3] == n:
            runs[n, 3] = count
            count += 1
        else:
            runs[n, 3] = runs[runs[n, 3], 3]
    sizes, at_edge = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.bool_)
    for n in range(len(runs)):
        row, first, end, k = runs[n, 0], runs[n, 1], runs[n, 2], runs[n, 3]
        sizes[k] += end - first
        if row == 0 or row == rows - 1 or first == 0 or end == columns:
            at_edge[k] = True
    return sizes, at_edge


@njit(cache=True)
def _root(runs: IntArray, n: int) -> int:
    while runs[n, 3] != n:
        n = runs[n, 3]
    return n


@njit(cache=True)
def _paint(runs: IntArray, chosen: BoolArray, mask: BoolArray) -> None:
    for n in range(len(runs)):
        if chosen[runs[n, 3]]:
            for u in range(runs[n, 1], runs[n, 2]):
                mask[runs[n, 0], u] = True


@njit(cache=True)
def _count(runs: IntArray, mask: BoolArray, counts: IntArray) -> None:
    for n in range(len(runs)):
        for u in range(runs[n, 1], runs[n, 2]):
            counts[runs[n, 3]] += mask[runs[n, 0], u]
