"""The back behind the robot: a guess for axes and extents, never for washing.

A person changes little from frame to frame, so the best guess is the back as it
was seen when nothing hid it, moved along with the body. Before that has been seen
once, a smooth fit stands in.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from bath_drake.notation import BoolArray, FloatArray, IntArray
from bath_drake.perception import morphology
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.offsets import less

# Projected points within this many pixels of each other leave no hole between.
POINT_GAP = 1.5

# The inverse depth of the back is fitted by all products of column and row up to
# this total degree; more would run away beside the pixels it was fitted to.
DEGREE = 2

# At most about this many pixels enter the fit: more change nothing.
MAX_SAMPLES = 4000


@dataclass(frozen=True, eq=False)
class BackTemplate:
    """A back seen whole.

    Attributes:
        points_P: (n, 3) its points in the frame P of its own canonical map.
        areas: (n,) surface each stands for, m^2.
        seen_at: When it was, s.
    """

    points_P: FloatArray
    areas: FloatArray
    seen_at: float

    def points_in_world(self, canonical_map: CanonicalMap) -> FloatArray:
        """Returns the points (n, 3) in W where the back is now."""
        return less(self.points_P @ canonical_map.R_WP.T, -canonical_map.p_WP)


@dataclass(frozen=True, eq=False)
class Expectation:
    """Where the back should be, by the frame before.

    Attributes:
        mask: (H, W) pixels it should cover.
        R_WP: (3, 3) its axes.
        span: Its lowest and highest position along the y axis from W's origin.
    """

    mask: BoolArray
    R_WP: FloatArray
    span: tuple[float, float]


def pixel_indices(
    points_W: FloatArray, camera: PinholeCamera, R_WC: FloatArray, p_WC: FloatArray
) -> IntArray:
    """Returns the (n, 2) rows and columns that show points (n, 3); -1 if none."""
    p_C = np.ascontiguousarray(less(points_W, p_WC) @ R_WC)
    lens = camera.fx, camera.fy, camera.cx, camera.cy
    return _indices(p_C, lens, camera.width, camera.height)


@njit(cache=True)
def _indices(
    p_C: FloatArray, lens: tuple[float, float, float, float], width: int, height: int
) -> IntArray:
    fx, fy, cx, cy = lens
    indices = np.full((len(p_C), 2), -1, dtype=np.int64)
    for i in range(len(p_C)):
        x, y, z = p_C[i]
        if z > 0.0:
            u, v = fx * x / z + cx, fy * y / z + cy
            if 0.0 <= u < width and 0.0 <= v < height:
                indices[i, 0], indices[i, 1] = int(v), int(u)
    return indices


def covered_pixels(indices: IntArray, shape: tuple[int, int]) -> BoolArray:
    """Returns the mask of pixels (n, 2) as of `pixel_indices`, gaps closed."""
    mask = np.zeros(shape, dtype=bool)
    top, bottom, left, right = _mark(indices, mask)
    if top <= bottom:
        window = slice(max(top - 2, 0), bottom + 3), slice(max(left - 2, 0), right + 3)
        mask[window] = morphology.closed(mask[window], POINT_GAP)
    return mask


@njit(cache=True)
def _mark(indices: IntArray, mask: BoolArray) -> tuple[int, int, int, int]:
    """Sets pixels (n, 2) in a mask; their first and last row and column."""
    rows, columns = mask.shape
    top, bottom, left, right = rows, -1, columns, -1
    for i in range(len(indices)):
        v, u = indices[i, 0], indices[i, 1]
        if v >= 0:
            mask[v, u] = True
            top, bottom = min(top, v), max(bottom, v)
            left, right = min(left, u), max(right, u)
    return top, bottom, left, right


def complete_depth(
    depth: FloatArray, visible: BoolArray, completed: BoolArray
) -> FloatArray:
    """Extrapolates the depth of the visible back to its hidden pixels.

    Args:
        depth: (H, W), metres.
        visible: (H, W) pixels whose depth is the back's.
        completed: (H, W) pixels the back is taken to cover, `visible` among them.

    Returns:
        (H, W) depth: measured where visible, that of a smooth fit over the whole
        visible back where hidden, NaN elsewhere. The fit is kept within the range
        of the depths measured.
    """
    filled = np.full(depth.shape, np.nan)
    filled[visible] = depth[visible]
    hidden = completed & ~visible
    if not hidden.any() or not visible.any():
        return filled
    rows, columns = np.nonzero(visible)
    stride = max(1, len(rows) // MAX_SAMPLES)
    rows, columns = rows[::stride], columns[::stride]
    middle = np.array([rows.mean(), columns.mean()])
    scale = max(float(np.ptp(rows)), float(np.ptp(columns)), 1.0)
    inverse = 1.0 / depth[rows, columns]
    # A plane's inverse depth is linear in the pixel: perspective costs no degree.
    basis = _basis((rows - middle[0]) / scale, (columns - middle[1]) / scale)
    coefficients = np.linalg.lstsq(basis, inverse, rcond=None)[0]
    rows, columns = np.nonzero(hidden)
    basis = _basis((rows - middle[0]) / scale, (columns - middle[1]) / scale)
    guess = np.clip(basis @ coefficients, inverse.min(), inverse.max())
    filled[hidden] = 1.0 / guess
    return filled


def _basis(y: FloatArray, x: FloatArray) -> FloatArray:
    powers = [(i, n - i) for n in range(DEGREE + 1) for i in range(n + 1)]
    return np.column_stack([x**i * y**j for i, j in powers])
