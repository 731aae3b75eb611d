"""Writes the camera's frames to a recording, one a period."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import Value
from pydrake.systems.framework import Context, EventStatus, LeafSystem
from pydrake.systems.sensors import ImageDepth32F, ImageRgba8U

from bath_drake.notation import ByteArray
from bath_drake.systems._ports import eval_value

# Takes a frame: time, s; colour (H, W, 3) RGB; depth (H, W), m.
WriteFrame = Callable[[float, ByteArray, NDArray[np.float32]], None]


class FrameRecorder(LeafSystem):
    """Hands each frame of the depth camera to whoever writes it.

    .. pydrake_system::

        name: FrameRecorder
        input_ports:
        - colour_image
        - depth_image

    A frame is taken every `period` seconds by a publish event, so it is the same
    image that the perception's update sees an instant later, rendered once.
    """

    def __init__(
        self, *, width: int, height: int, period: float, write: WriteFrame
    ) -> None:
        """Declares ports and event.

        Args:
            width: Columns of the images, pixels.
            height: Rows of the images, pixels.
            period: Of the camera, s.
            write: Called once a frame.

        Raises:
            ValueError: If the period is not positive and finite.
        """
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._write = write
        self._colour = self.DeclareAbstractInputPort(
            "colour_image", Value(ImageRgba8U(width, height))
        )
        self._depth = self.DeclareAbstractInputPort(
            "depth_image", Value(ImageDepth32F(width, height))
        )
        self.DeclarePeriodicPublishEvent(period, 0.0, self._record)

    def _record(self, context: Context) -> EventStatus:
        colour: Any = eval_value(self._colour, context, ImageRgba8U)
        depth: Any = eval_value(self._depth, context, ImageDepth32F)
        self._write(
            context.get_time(), colour.data[..., :3].copy(), depth.data[..., 0].copy()
        )
        return EventStatus.Succeeded()
