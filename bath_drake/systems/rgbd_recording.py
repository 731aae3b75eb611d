"""Plays a recorded folder as if its camera were there."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, LeafSystem, ValueProducer
from pydrake.systems.sensors import ImageDepth32F, ImageRgba8U

from bath_drake.demonstrations.rgbd.folder import RgbdFolder, RgbdFrame
from bath_drake.systems._ports import set_vector

_OPAQUE = 255


class RgbdRecording(LeafSystem):
    """Shows each frame of a recording from its time until the next one's.

    .. pydrake_system::

        name: RgbdRecording
        output_ports:
        - colour_image
        - depth_image
        - frame_stamp

    Time 0 is that of the first frame; `frame_stamp` is when the frame was taken, s
    from then. The last frame stays. Images are read when they are asked for, and
    `DemonstrationError` is raised if they are damaged. Stateless.
    """

    def __init__(self, *, recording: RgbdFolder) -> None:
        """Declares the ports."""
        super().__init__()
        self._recording = recording
        times = np.array([files.t for files in recording.files])
        self._times = times - times[0]
        camera = recording.camera
        colour = Value(ImageRgba8U(camera.width, camera.height))
        depth = Value(ImageDepth32F(camera.width, camera.height))
        self._frame = self.DeclareCacheEntry(
            "frame",
            ValueProducer(Value[object], self._calc_frame),
            {self.time_ticket()},
        )
        for name, empty, calc in (
            ("colour_image", colour, self._calc_colour),
            ("depth_image", depth, self._calc_depth),
        ):
            self.DeclareAbstractOutputPort(
                name, empty.Clone, calc, {self._frame.ticket()}
            )
        self.DeclareVectorOutputPort(
            "frame_stamp", 1, self._calc_stamp, {self.time_ticket()}
        )

    def _index(self, context: Context) -> int:
        # Time stamps in steps of a period accumulate rounding.
        t = context.get_time() + 1e-9
        return max(int(np.searchsorted(self._times, t, side="right")) - 1, 0)

    def _calc_frame(self, context: Any, output: Any) -> None:
        output.set_value(self._recording.frame(self._index(context)))

    def _calc_colour(self, context: Any, output: Any) -> None:
        frame: Any = self._frame.Eval(context)
        assert isinstance(frame, RgbdFrame)
        camera = self._recording.camera
        image: Any = ImageRgba8U(camera.width, camera.height)
        image.mutable_data[..., :3] = frame.colour
        image.mutable_data[..., 3] = _OPAQUE
        output.set_value(image)

    def _calc_depth(self, context: Any, output: Any) -> None:
        frame: Any = self._frame.Eval(context)
        assert isinstance(frame, RgbdFrame)
        camera = self._recording.camera
        image: Any = ImageDepth32F(camera.width, camera.height)
        image.mutable_data[..., 0] = frame.depth
        output.set_value(image)

    def _calc_stamp(self, context: Context, output: BasicVector) -> None:
        set_vector(output, [self._times[self._index(context)]])
