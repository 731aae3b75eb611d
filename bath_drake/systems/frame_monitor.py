"""Checks the camera's frames, whatever they show."""

from typing import Any

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
from bath_drake.perception.frame_check import FrameCheck, check_frame
from bath_drake.systems._ports import eval_scalar, eval_value, set_vector


class FrameMonitor(LeafSystem):
    """Says of the newest frame what a guard must know.

    .. pydrake_system::

        name: FrameMonitor
        input_ports:
        - depth_image
        - frame_stamp (optional)
        output_ports:
        - frame_status

    `frame_status` (3) is the share of pixels that say nothing, 1 if the camera gives
    one image again and again, and 1 if the frame's stamp went back. An unconnected
    `frame_stamp` means that the images are of this very moment. The state is a
    `bath_drake.perception.frame_check.FrameCheck`.
    """

    def __init__(
        self, *, camera: PinholeCamera, period: float, sees_frozen: bool = True
    ) -> None:
        """Declares ports and state.

        Args:
            camera: Whose images they are.
            period: Of the camera, s.
            sees_frozen: False for a camera without noise: of what does not move it
                gives one image again and again, and is well.

        Raises:
            ValueError: If the period is not positive and finite.
        """
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._sees_frozen = sees_frozen
        self._depth = self.DeclareAbstractInputPort(
            "depth_image", Value(ImageDepth32F(camera.width, camera.height))
        )
        self._stamp = self.DeclareVectorInputPort("frame_stamp", 1)
        self._state = self.DeclareAbstractState(Value[object](FrameCheck()))
        self.DeclareVectorOutputPort(
            "frame_status", 3, self._calc, {self.abstract_state_ticket(self._state)}
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._check)

    def _last(self, context: Any) -> FrameCheck:
        state: Any = context.get_abstract_state(int(self._state))
        check: FrameCheck = state.get_value()
        return check

    def _check(self, context: Context, state: State) -> EventStatus:
        stamp = context.get_time()
        if self._stamp.HasValue(context):
            stamp = eval_scalar(self._stamp, context)
        depth: Any = eval_value(self._depth, context, ImageDepth32F)
        found = check_frame(self._last(context), stamp, depth.data[..., 0])
        state.get_mutable_abstract_state(int(self._state)).set_value(found)
        return EventStatus.Succeeded()

    def _calc(self, context: Any, output: BasicVector) -> None:
        check = self._last(context)
        frozen = check.frozen and self._sees_frozen
        set_vector(output, [check.invalid_share, float(frozen), float(check.went_back)])
