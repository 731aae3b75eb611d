"""The colour camera's noise as a Drake system."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem
from pydrake.systems.sensors import ImageRgba8U

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.colour_noise import (
    ColourNoiseConfig,
    check_colour_noise,
    noisy_colour,
)
from bath_drake.systems._ports import eval_value


class ColourNoise(LeafSystem):
    """Makes of the renderer's perfect colour image what a real sensor reports.

    .. pydrake_system::

        name: ColourNoise
        input_ports:
        - colour_image
        output_ports:
        - noisy_colour_image

    Stateless: the frame's number, and so its noise, follows from the time and the
    camera's period.
    """

    def __init__(
        self,
        *,
        camera: PinholeCamera,
        config: ColourNoiseConfig,
        seed: int,
        period: float,
    ) -> None:
        """Declares the ports.

        Args:
            camera: Whose colour images they are.
            config: Noise, exposure and white balance.
            seed: Of the noise of all frames.
            period: Of the camera, s.

        Raises:
            ValueError: If the period is not positive and finite, the seed negative, or
                the configuration makes no camera.
        """
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        if seed < 0:
            raise ValueError(f"seed must be >= 0, got {seed}")
        check_colour_noise(config)
        self._camera, self._config = camera, config
        self._seed, self._period = seed, period
        image = Value(ImageRgba8U(camera.width, camera.height))
        self._colour = self.DeclareAbstractInputPort("colour_image", image)
        self.DeclareAbstractOutputPort(
            "noisy_colour_image",
            image.Clone,
            self._calc_noisy_colour_image,
            {self.time_ticket(), self._colour.ticket()},
        )

    def _calc_noisy_colour_image(self, context: Any, output: Any) -> None:
        colour: Any = eval_value(self._colour, context, ImageRgba8U)
        image: Any = ImageRgba8U(self._camera.width, self._camera.height)
        t = context.get_time()
        image.mutable_data[:] = noisy_colour(
            colour.data,
            self._config,
            seed=self._seed,
            frame=int(np.round(t / self._period)),
            t=t,
        )
        output.set_value(image)
