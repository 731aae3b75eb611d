"""Least ellipses around points and around each other."""

import cv2
import numpy as np
from numba import njit

from bath_drake.field.obstacles import ObstacleSet
from bath_drake.notation import FloatArray

# Khachiyan's steps; an unfinished ellipse is larger, never too small.
MAX_STEPS = 1000

# Corners of the polygon that stands for the margin's disc.
CORNERS = 16


def enclosing_ellipse(points: FloatArray, margin: float) -> FloatArray:
    """Returns the least ellipse around points (n, 2) with a margin around each.

    Args:
        points: At least one point, metres.
        margin: Positive, metres.

    Returns:
        (5,) centre x, y, semi-axes a >= b, angle.
    """
    turns = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
    # Corners outside the circle, so that the polygon's edges touch it.
    disc = np.column_stack([np.cos(turns), np.sin(turns)]) / np.cos(np.pi / CORNERS)
    spread = (points[:, None, :] + margin * disc).reshape(-1, 2)
    hull = cv2.convexHull(spread.astype(np.float32)).reshape(-1, 2).astype(np.float64)
    return least_ellipse(hull)


def least_ellipse(points: FloatArray, tolerance: float = 1e-2) -> FloatArray:
    """Returns the least ellipse (5,) around points (n, 2), not all on a line.

    Khachiyan's algorithm; the result is scaled to contain the points exactly.
    """
    u = _khachiyan_weights(np.ascontiguousarray(points), tolerance)
    centre = u @ points
    offsets = points - centre
    scatter = 2.0 * (offsets.T @ (offsets * u[:, None]))
    lengths, axes = np.linalg.eigh(scatter)
    inverse = np.linalg.inv(scatter)
    scale = np.einsum("ij,jk,ik->i", offsets, inverse, offsets).max()
    b, a = np.sqrt(lengths * scale)
    return np.array([*centre, a, b, np.arctan2(axes[1, 1], axes[0, 1])])


@njit(cache=True)
def _khachiyan_weights(points: FloatArray, tolerance: float) -> FloatArray:
    n = len(points)
    lifted = np.ones((n, 3))
    for i in range(n):
        lifted[i, 0], lifted[i, 1] = points[i, 0], points[i, 1]
    u = np.full(n, 1.0 / n)
    for _ in range(MAX_STEPS):
        inverse = np.linalg.inv(lifted.T @ (lifted * u.reshape(-1, 1)))
        distance = ((lifted @ inverse) * lifted).sum(axis=1)
        worst = np.argmax(distance)
        if distance[worst] / 3.0 - 1.0 < tolerance:
            break
        step = (distance[worst] - 3.0) / (3.0 * (distance[worst] - 1.0))
        u *= 1.0 - step
        u[worst] += step
    return u


def outline(ellipse: FloatArray) -> FloatArray:
    """Returns 64 points (64, 2) on an ellipse (5,)."""
    return np.asarray(ObstacleSet(ellipse[None]).boundary()[0])


def level(ellipse: FloatArray, points: FloatArray) -> FloatArray:
    """Returns (u/a)^2 + (v/b)^2 of points (n, 2): one on the ellipse (5,)."""
    x, y, a, b, angle = ellipse
    c, s = np.cos(angle), np.sin(angle)
    axes = np.array([[c, -s], [s, c]])
    local = (points - np.array([x, y])) @ axes / np.array([a, b])
    return np.asarray((local * local).sum(axis=1))


def meet(a: FloatArray, b: FloatArray) -> bool:
    """Whether two ellipses (5,) have a point in common, up to their 64 corners."""
    return bool(level(a, outline(b)).min() <= 1.0 or level(b, outline(a)).min() <= 1.0)
