"""A depth camera drawn by our own rasteriser, in the place of Drake's RgbdSensor."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.geometry import GeometryId, QueryObject
from pydrake.systems.framework import (
    Context,
    InputPort,
    LeafSystem,
    OutputPort,
    ValueProducer,
)
from pydrake.systems.sensors import ImageDepth32F, ImageLabel16I, ImageRgba8U

from bath_drake.perception.camera import PinholeCamera
from bath_drake.rendering.rasteriser import Picture, Rasteriser
from bath_drake.systems._ports import eval_value


class RasterisedCamera(LeafSystem):
    """Films a SceneGraph: colour, depth and labels of one instant.

    .. pydrake_system::

        name: RasterisedCamera
        input_ports:
        - geometry_query
        output_ports:
        - color_image
        - depth_image_32f
        - label_image

    Ports and images are those of Drake's RgbdSensor. All three are of one picture,
    drawn once. Stateless.
    """

    def __init__(
        self,
        *,
        rasteriser: Rasteriser,
        camera: PinholeCamera,
        geometries: Sequence[GeometryId],
        bending: Mapping[GeometryId, int] | None = None,
    ) -> None:
        """Declares the ports.

        Args:
            rasteriser: Draws; its moving surfaces are `geometries`.
            camera: The rasteriser's.
            geometries: In the SceneGraph, in the rasteriser's order.
            bending: Those that are deformable: how many of their vertices, the first,
                are the surface's.
        """
        super().__init__()
        self._rasteriser = rasteriser
        self._geometries, self._bending = tuple(geometries), dict(bending or {})
        self._query = self.DeclareAbstractInputPort(
            "geometry_query", AbstractValue.Make(QueryObject())
        )
        size = camera.width, camera.height
        self._picture = self.DeclareCacheEntry(
            "picture",
            ValueProducer(Value[object], self._calc_picture),
            {self._query.ticket()},
        )
        drawn = {self._picture.ticket()}
        self._ports = {
            name: self.DeclareAbstractOutputPort(
                name, Value(kind(*size)).Clone, calc, drawn
            )
            for name, kind, calc in (
                ("color_image", ImageRgba8U, self._calc_colour),
                ("depth_image_32f", ImageDepth32F, self._calc_depth),
                ("label_image", ImageLabel16I, self._calc_label),
            )
        }

    def query_object_input_port(self) -> InputPort:
        """Takes the SceneGraph's query port, as RgbdSensor's does."""
        return self._query

    def color_image_output_port(self) -> OutputPort:
        """The colour image, as RgbdSensor's."""
        return self._ports["color_image"]

    def depth_image_32F_output_port(self) -> OutputPort:
        """The depth image, as RgbdSensor's."""
        return self._ports["depth_image_32f"]

    def label_image_output_port(self) -> OutputPort:
        """The label image, as RgbdSensor's."""
        return self._ports["label_image"]

    def _calc_picture(self, context: Any, output: Any) -> None:
        query: Any = eval_value(self._query, context, QueryObject)
        X_WG = np.empty((len(self._geometries), 3, 4))
        bent = {}
        for k, geometry in enumerate(self._geometries):
            if geometry in self._bending:
                X_WG[k] = np.eye(4)[:3]
                points = np.asarray(query.GetConfigurationsInWorld(geometry))
                bent[k] = points.reshape(-1, 3)[: self._bending[geometry]]
            else:
                X_WG[k] = query.GetPoseInWorld(geometry).GetAsMatrix34()
        output.set_value(self._rasteriser.picture(X_WG, bent))

    def _drawn(self, context: Context) -> Picture:
        picture: Any = self._picture.Eval(context)
        assert isinstance(picture, Picture)
        return picture

    def _calc_colour(self, context: Any, output: Any) -> None:
        output.get_mutable_value().mutable_data[:] = self._drawn(context).colour

    def _calc_depth(self, context: Any, output: Any) -> None:
        output.get_mutable_value().mutable_data[..., 0] = self._drawn(context).depth

    def _calc_label(self, context: Any, output: Any) -> None:
        output.get_mutable_value().mutable_data[..., 0] = self._drawn(context).label
