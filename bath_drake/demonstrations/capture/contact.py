"""The point of the skin under the marker."""

import numpy as np
from scipy.spatial import cKDTree

from bath_drake.demonstrations.capture.rigid_tracking import RigidSurface
from bath_drake.notation import FloatArray

# So many points of the skin (a disc of some 2 cm) give its plane under the marker.
NEIGHBOURS = 40


class Skin:
    """Skin whose tangent plane under a point is that of the points around."""

    def __init__(self, surface: RigidSurface) -> None:
        """Takes at least one point of the skin."""
        self._surface = surface
        self._tree = cKDTree(surface.points)
        self._count = min(NEIGHBOURS, len(surface.points))

    def under(self, p: FloatArray) -> tuple[FloatArray, float]:
        """Returns the foot (3,) of the perpendicular from p (3,), its length, m."""
        _, near = self._tree.query(p, k=self._count)
        near = np.atleast_1d(near)
        normal = self._surface.normals[near].mean(axis=0)
        normal /= np.linalg.norm(normal)
        height = float((p - self._surface.points[near].mean(axis=0)) @ normal)
        return p - height * normal, height
