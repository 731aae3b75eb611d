"""The point of the skin under the marker."""

import numpy as np
from scipy.spatial import cKDTree

from bath_drake.notation import FloatArray

# A quadric is laid through the skin within this of the point nearest to the marker,
# m; fewer points hold none.
RADIUS, MIN_POINTS = 0.025, 12
# The foot is found step by half step, for the skin bends by a third at most in it.
STEPS, STRIDE = 12, 0.5


class Skin:
    """Points of skin, not smoothed: that would bend it inwards at the edge."""

    def __init__(self, points: FloatArray) -> None:
        """Takes points (n, 3) of the skin in the frame of a camera, m."""
        self._points = points
        self._tree = cKDTree(points)

    def under(self, p: FloatArray) -> tuple[FloatArray, float] | None:
        """Finds the foot (3,) of the perpendicular from p (3,), and its length, m.

        Around the foot the skin is a quadric h(a, b) over the tangent plane of the
        nearest points, so that a foot at the edge of what is seen has a slope of its
        own. None if there is too little skin.
        """
        _, nearest = self._tree.query(p)
        origin = self._points[nearest]
        around = self._points[self._tree.query_ball_point(origin, RADIUS)]
        if len(around) < MIN_POINTS:
            return None
        offsets = around - around.mean(axis=0)
        axes = np.linalg.eigh(offsets.T @ offsets)[1][:, ::-1]
        # Outwards is where the camera is.
        axes[:, 2] *= -np.sign(axes[:, 2] @ origin)
        points = (around - origin) @ axes / RADIUS
        u, v, w = (p - origin) @ axes / RADIUS
        c = np.linalg.lstsq(_terms(*points[:, :2].T), points[:, 2], rcond=None)[0]
        a, b = u, v
        for _ in range(STEPS):
            above = w - float(_terms(a, b) @ c)
            slope_a = c[1] + 2.0 * c[3] * a + c[4] * b
            slope_b = c[2] + c[4] * a + 2.0 * c[5] * b
            a += STRIDE * (u + above * slope_a - a)
            b += STRIDE * (v + above * slope_b - b)
        foot = np.array([a, b, float(_terms(a, b) @ c)])
        towards = np.array([u, v, w]) - foot
        height = RADIUS * float(np.linalg.norm(towards) * np.sign(towards[2]))
        return origin + RADIUS * axes @ foot, height


def _terms(a: FloatArray, b: FloatArray) -> FloatArray:
    """The six terms (..., 6) of a quadric at places a, b (...)."""
    return np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=-1)
