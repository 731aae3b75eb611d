"""A bending skin in Meshcat, as a Drake system."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import GeometryConfigurationVector, GeometryId, Meshcat, Rgba
from pydrake.systems.framework import Context, EventStatus, LeafSystem

from bath_drake.notation import FloatArray, IntArray
from bath_drake.systems._ports import eval_value

# Where Meshcat has the skin.
ROOT = "/person"


@dataclass(frozen=True, eq=False)
class DrawnPart:
    """One part of a skin, as Meshcat wants it.

    Attributes:
        name: Below `ROOT`.
        geometry: Its SceneGraph geometry: the vertices outside, then as many inside.
        triangles: (m, 3) of the outside.
        rgba: (4,) 0 to 1.
    """

    name: str
    geometry: GeometryId
    triangles: IntArray
    rgba: FloatArray


class SkinView(LeafSystem):
    """Shows a bending skin in Meshcat.

    .. pydrake_system::

        name: SkinView
        input_ports:
        - skin_configuration

    Stateless; publishes at a fixed rate. Drake's own visualizer draws deformable
    bodies only in versions newer than this project has to run with.
    """

    def __init__(
        self, *, meshcat: Meshcat, parts: Sequence[DrawnPart], period: float
    ) -> None:
        """Declares the port.

        Args:
            meshcat: Shows it.
            parts: Of the skin.
            period: Between two views, s.
        """
        super().__init__()
        self._meshcat = meshcat
        self._parts = tuple(parts)
        self._skin = self.DeclareAbstractInputPort(
            "skin_configuration", Value(GeometryConfigurationVector())
        )
        self.DeclarePeriodicPublishEvent(period, 0.0, self._show)

    def _show(self, context: Context) -> EventStatus:
        skin = eval_value(self._skin, context, GeometryConfigurationVector)
        for part in self._parts:
            points_W = np.asarray(skin.value(part.geometry)).reshape(-1, 3)
            path = f"{ROOT}/{part.name}"
            show_part(self._meshcat, path, points_W, part.triangles, part.rgba)
        return EventStatus.Succeeded()


def show_part(
    meshcat: Meshcat,
    path: str,
    points_W: FloatArray,
    triangles: IntArray,
    rgba: FloatArray,
) -> None:
    """Draws a part at a path, its points (2 n, 3) outside and inside, m."""
    outside: Any = np.asfortranarray(points_W[: len(points_W) // 2].T)
    faces: Any = np.asfortranarray(triangles.T.astype(np.int32))
    meshcat.SetTriangleMesh(path, outside, faces, Rgba(*rgba))
