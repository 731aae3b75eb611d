"""What goes wrong between the camera and those who use its frames."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
    State,
    ValueProducer,
)
from pydrake.systems.sensors import ImageDepth32F, ImageRgba8U

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.faults import FaultsConfig, check_faults
from bath_drake.perception.frame_delivery import (
    Delivery,
    Frame,
    frame_fate,
    next_delivery,
)
from bath_drake.perception.lens_faults import with_lens_faults
from bath_drake.systems._ports import eval_value, eval_vector, set_vector

_JOINTS = 7


class CameraFaults(LeafSystem):
    """Loses, delays and freezes frames; lays glare and water over them.

    .. pydrake_system::

        name: CameraFaults
        input_ports:
        - colour_image
        - depth_image
        - arm_position
        output_ports:
        - colour_image
        - depth_image
        - arm_position
        - frame_stamp

    The outputs are those of the newest frame that has come: its images, the arm's
    joint positions when it was taken, and that time, s; -inf before the first, with
    images that show nothing. A lost frame changes none of them. The state is a
    `bath_drake.perception.frame_delivery.Delivery`, renewed every `period` when the
    camera takes a frame; at that very instant the outputs already know of it.
    """

    def __init__(
        self,
        *,
        camera: PinholeCamera,
        config: FaultsConfig,
        seed: int,
        period: float,
    ) -> None:
        """Declares ports and state.

        Args:
            camera: Whose images they are.
            config: The faults.
            seed: Of what happens by chance.
            period: Of the camera, s.

        Raises:
            ValueError: If the period is not positive and finite, the seed negative, or
                the configuration makes no faults.
        """
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        if seed < 0:
            raise ValueError(f"seed must be >= 0, got {seed}")
        check_faults(config)
        self._camera, self._config = camera, config
        self._seed, self._period = seed, period
        colour = Value(ImageRgba8U(camera.width, camera.height))
        depth = Value(ImageDepth32F(camera.width, camera.height))
        self._colour = self.DeclareAbstractInputPort("colour_image", colour)
        self._depth = self.DeclareAbstractInputPort("depth_image", depth)
        self._q = self.DeclareVectorInputPort("arm_position", _JOINTS)
        self._state = self.DeclareAbstractState(Value[object](Delivery()))
        self._delivery = self.DeclareCacheEntry(
            "delivery",
            ValueProducer(Value[object], self._calc_delivery),
            {
                self.time_ticket(),
                self.abstract_state_ticket(self._state),
                *(p.ticket() for p in (self._colour, self._depth, self._q)),
            },
        )
        come = {self._delivery.ticket()}
        self.DeclareAbstractOutputPort(
            "colour_image", colour.Clone, self._calc_colour, come
        )
        self.DeclareAbstractOutputPort(
            "depth_image", depth.Clone, self._calc_depth, come
        )
        self.DeclareVectorOutputPort("arm_position", _JOINTS, self._calc_position, come)
        self.DeclareVectorOutputPort("frame_stamp", 1, self._calc_stamp, come)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._take)

    def _calc_delivery(self, context: Any, output: Any) -> None:
        state: Any = context.get_abstract_state(int(self._state))
        before: Delivery = state.get_value()
        t = context.get_time()
        # Time stamps in steps of a period accumulate rounding.
        index = int(np.floor(t / self._period + 1e-6))
        if index <= before.index:
            output.set_value(before)
            return
        fate = frame_fate(self._config, seed=self._seed, index=index, t=t)
        output.set_value(
            next_delivery(before, index, self._frame(context, index), fate)
        )

    def _frame(self, context: Any, index: int) -> Frame:
        t = context.get_time()
        colour: Any = eval_value(self._colour, context, ImageRgba8U)
        depth: Any = eval_value(self._depth, context, ImageDepth32F)
        images = with_lens_faults(
            colour.data,
            depth.data[..., 0],
            self._config,
            seed=self._seed,
            frame=index,
            t=t,
        )
        return Frame(t, *images, eval_vector(self._q, context))

    def _newest(self, context: Any) -> Frame:
        delivery: Any = self._delivery.Eval(context)
        if delivery.newest is not None:
            newest: Frame = delivery.newest
            return newest
        return Frame(
            -np.inf,
            np.zeros((*self._camera.shape, 4), dtype=np.uint8),
            np.zeros(self._camera.shape, dtype=np.float32),
            np.zeros(_JOINTS),
        )

    def _take(self, context: Context, state: State) -> EventStatus:
        delivery = self._delivery.Eval(context)
        state.get_mutable_abstract_state(int(self._state)).set_value(delivery)
        return EventStatus.Succeeded()

    def _calc_colour(self, context: Any, output: Any) -> None:
        image: Any = ImageRgba8U(self._camera.width, self._camera.height)
        image.mutable_data[:] = self._newest(context).colour
        output.set_value(image)

    def _calc_depth(self, context: Any, output: Any) -> None:
        image: Any = ImageDepth32F(self._camera.width, self._camera.height)
        image.mutable_data[..., 0] = self._newest(context).depth
        output.set_value(image)

    def _calc_position(self, context: Any, output: BasicVector) -> None:
        set_vector(output, self._newest(context).arm_position)

    def _calc_stamp(self, context: Any, output: BasicVector) -> None:
        set_vector(output, [self._newest(context).stamp])
