"""The depth camera's noise as a Drake system."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem
from pydrake.systems.sensors import ImageDepth32F

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.depth_noise import noisy_depth
from bath_drake.perception.depth_sensor import DepthSensor
from bath_drake.systems._ports import eval_value


class DepthNoise(LeafSystem):
    """Makes of the renderer's perfect depth image what a real sensor reports.

    .. pydrake_system::

        name: DepthNoise
        input_ports:
        - depth_image
        output_ports:
        - noisy_depth_image

    Stateless: the frame's number, and so its noise, follows from the time and the
    camera's period. A pixel without a measurement is 0, which is not a depth.
    """

    def __init__(
        self, *, camera: PinholeCamera, sensor: DepthSensor, seed: int, period: float
    ) -> None:
        """Declares the ports.

        Args:
            camera: Whose depth images they are.
            sensor: How it errs.
            seed: Of the noise of all frames.
            period: Of the camera, s.

        Raises:
            ValueError: If the period is not positive and finite, or the seed negative.
        """
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        if seed < 0:
            raise ValueError(f"seed must be >= 0, got {seed}")
        self._camera, self._sensor = camera, sensor
        self._seed, self._period = seed, period
        image = Value(ImageDepth32F(camera.width, camera.height))
        self._depth = self.DeclareAbstractInputPort("depth_image", image)
        self.DeclareAbstractOutputPort(
            "noisy_depth_image",
            image.Clone,
            self._calc_noisy_depth_image,
            {self.time_ticket(), self._depth.ticket()},
        )

    def _calc_noisy_depth_image(self, context: Any, output: Any) -> None:
        depth: Any = eval_value(self._depth, context, ImageDepth32F)
        image: Any = ImageDepth32F(self._camera.width, self._camera.height)
        image.mutable_data[..., 0] = noisy_depth(
            depth.data[..., 0],
            self._camera,
            seed=self._seed,
            frame=int(np.round(context.get_time() / self._period)),
            sensor=self._sensor,
        )
        output.set_value(image)
