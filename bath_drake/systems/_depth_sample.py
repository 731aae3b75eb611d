"""A few pixels of a depth image, for who looks at all of it but not closely."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydrake.systems.framework import Context, InputPort
from pydrake.systems.sensors import ImageDepth32F

from bath_drake.notation import FloatArray
from bath_drake.shared import Shared
from bath_drake.systems._ports import eval_value

# Every fourth pixel along both axes: a hand is still some twenty, an arm a thousand.
STRIDE = 4


@dataclass(frozen=True, eq=False)
class DepthSample(Shared):
    """Every few pixels of the newest depth image, m; of nothing before the first."""

    depth: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))


def sampled(port: InputPort, context: Context) -> DepthSample:
    """Returns the sample of a port's image as it is now."""
    image: Any = eval_value(port, context, ImageDepth32F)
    return DepthSample(image.data[::STRIDE, ::STRIDE, 0].astype(np.float64))
