"""The skin's heights over a plane, gathered from many frames: what a body is known by.

A frame's points are noisy by millimetres; their mean over a centimetre of skin and a
second of frames is not. The field is a plain grid, so that asking it for ten thousand
places costs little.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numba import njit
from scipy.ndimage import binary_erosion, gaussian_filter

from bath_drake.notation import BoolArray, FloatArray

# Of a cell, m, and how many there are along each side: 0.8 m hold every back.
CELL = 0.01
CELLS = 80

# Smoothed over about so many cells to either side.
BLUR = 1.0

# A cell with fewer points is no skin. So near to one, in cells, slopes are the edge's;
# and a cell next to one may be covered in part, its points' mean not its middle's.
LEAST_POINTS = 3
RIM, BESIDE = 2, 1


def _grid() -> FloatArray:
    return np.zeros((CELLS, CELLS))


@dataclass(frozen=True, eq=False)
class HeightField:
    """Heights over the xy plane of a frame B, and their slopes; x is the first index.

    Attributes:
        counts: (CELLS, CELLS) points gathered in each cell.
        sums: (CELLS, CELLS) of their heights, m.
        surface: (CELLS, CELLS, 3) height, m, and its slopes along x and y.
        known: (CELLS, CELLS) where `surface` says anything.
    """

    counts: FloatArray = field(default_factory=_grid)
    sums: FloatArray = field(default_factory=_grid)
    surface: FloatArray = field(default_factory=lambda: np.zeros((CELLS, CELLS, 3)))
    known: BoolArray = field(
        default_factory=lambda: np.zeros((CELLS, CELLS), dtype=bool)
    )

    def with_points(self, p_B: FloatArray) -> "HeightField":
        """Returns the field with another frame's points (n, 3), m, gathered in."""
        counts, sums = self.counts.copy(), self.sums.copy()
        _gather(np.ascontiguousarray(p_B, dtype=np.float64), counts, sums)
        weight = gaussian_filter(counts, BLUR)
        height = gaussian_filter(sums, BLUR) / np.maximum(weight, 1e-9)
        along_x, along_y = np.gradient(height, CELL)
        known = binary_erosion(counts >= LEAST_POINTS, iterations=RIM)
        surface = np.stack([height, along_x, along_y], axis=-1)
        return HeightField(counts, sums, surface, known)

    @cached_property
    def whole_cells(self) -> tuple[BoolArray, FloatArray]:
        """Which cells (CELLS, CELLS) are covered by points, and their mean heights, m.

        They go a cell farther to the rim than `known`, and are not smoothed over those
        beside them, which has the skin's slope shift them there.
        """
        whole = binary_erosion(self.counts >= LEAST_POINTS, iterations=BESIDE)
        return whole, self.sums / np.maximum(self.counts, 1.0)


def counted(p_B: FloatArray) -> FloatArray:
    """Returns how many of points (n, 3), m, lie over each cell (CELLS, CELLS)."""
    counts, sums = _grid(), _grid()
    _gather(np.ascontiguousarray(p_B, dtype=np.float64), counts, sums)
    return counts


@njit(cache=True)
def _gather(p_B: FloatArray, counts: FloatArray, sums: FloatArray) -> None:
    for n in range(len(p_B)):
        i = int(np.floor(p_B[n, 0] / CELL)) + CELLS // 2
        j = int(np.floor(p_B[n, 1] / CELL)) + CELLS // 2
        if 0 <= i < CELLS and 0 <= j < CELLS:
            counts[i, j] += 1.0
            sums[i, j] += p_B[n, 2]


@njit(cache=True)
def look_up(
    surface: FloatArray, known: BoolArray, x: float, y: float, out: FloatArray
) -> bool:
    """Interpolates between cells; whether all four around the place are known.

    Args:
        surface: (CELLS, CELLS, 3) of a `HeightField`.
        known: (CELLS, CELLS) likewise.
        x: m.
        y: m.
        out: (3,) takes height, m, and slopes.
    """
    # A cell's value is that of its middle.
    u = x / CELL + CELLS // 2 - 0.5
    v = y / CELL + CELLS // 2 - 0.5
    i, j = int(np.floor(u)), int(np.floor(v))
    if not (0 <= i < CELLS - 1 and 0 <= j < CELLS - 1):
        return False
    if not (known[i, j] and known[i + 1, j] and known[i, j + 1]):
        return False
    if not known[i + 1, j + 1]:
        return False
    a, b = u - i, v - j
    for k in range(3):
        near = surface[i, j, k] * (1.0 - b) + surface[i, j + 1, k] * b
        far = surface[i + 1, j, k] * (1.0 - b) + surface[i + 1, j + 1, k] * b
        out[k] = near * (1.0 - a) + far * a
    return True
