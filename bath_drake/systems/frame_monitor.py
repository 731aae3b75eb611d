"""Whether the camera's frames can be believed, once a frame."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
    State,
)
from pydrake.systems.sensors import ImageDepth32F

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.frame_check import (
    FrameCheck,
    stamp_is_new,
    with_frame,
    without_new_frame,
)
from bath_drake.systems._ports import eval_scalar, eval_value, set_vector


class FrameMonitor(LeafSystem):
    """Counts pixels without depth; tells frozen frames and stamps that go back.

    .. pydrake_system::

        name: FrameMonitor
        input_ports:
        - depth_image
        - frame_stamp (optional)
        output_ports:
        - frame_status

    `frame_status` (3) is what the guards take: the share of the newest frame's pixels
    that say nothing, 1 if frames are frozen, 1 if the last stamp went back, is of the
    future or no number. Before the first frame it is 1, 0, 0.

    A look is taken every `period` seconds, at the instants of `BodySegmenter`, whose
    frame it therefore is, and the image is evaluated only if the stamp is new. An
    unconnected `frame_stamp` means that images are of this very moment. The state is a
    `bath_drake.perception.frame_check.FrameCheck`.
    """

    def __init__(
        self, *, camera: PinholeCamera, period: float, watch_frozen: bool = True
    ) -> None:
        """Declares ports and state.

        Args:
            camera: Whose images they are.
            period: Between looks, s.
            watch_frozen: Off for a camera without noise: of a still scene it gives one
                frame again and again.

        Raises:
            ValueError: If the period is not positive and finite.
        """
        super().__init__()
        if not (np.isfinite(period) and period > 0.0):
            raise ValueError(f"period must be positive, got {period}")
        self._watch_frozen = watch_frozen
        self._depth = self.DeclareAbstractInputPort(
            "depth_image", Value(ImageDepth32F(camera.width, camera.height))
        )
        self._stamp = self.DeclareVectorInputPort("frame_stamp", 1)
        self._state = self.DeclareAbstractState(Value[object](FrameCheck()))
        self.DeclareVectorOutputPort(
            "frame_status",
            3,
            self._calc_frame_status,
            {self.abstract_state_ticket(self._state)},
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._look)

    def _look(self, context: Context, state: State) -> EventStatus:
        now = context.get_time()
        stamp = now
        if self._stamp.HasValue(context):
            stamp = eval_scalar(self._stamp, context)
        check = self._known(context)
        if stamp_is_new(check, stamp, now):
            depth: Any = eval_value(self._depth, context, ImageDepth32F)
            check = with_frame(check, depth.data[..., 0], stamp)
        else:
            check = without_new_frame(check, stamp)
        state.get_mutable_abstract_state(int(self._state)).set_value(check)
        return EventStatus.Succeeded()

    def _known(self, context: Any) -> FrameCheck:
        check: FrameCheck = context.get_abstract_state(int(self._state)).get_value()
        return check

    def _calc_frame_status(self, context: Context, output: BasicVector) -> None:
        status = self._known(context).status(watch_frozen=self._watch_frozen)
        set_vector(output, status)
