import numpy as np
import pytest
from pydrake.systems.sensors import ImageDepth32F

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.depth_noise import noisy_depth
from bath_drake.perception.depth_sensor import REALSENSE_D435
from bath_drake.systems.depth_noise import DepthNoise

CAMERA = PinholeCamera(64, 48, 60.0, 60.0, 32.0, 24.0)
PERIOD = 1.0 / 30.0


def image(value):
    depth = ImageDepth32F(CAMERA.width, CAMERA.height)
    depth.mutable_data[:] = value
    return depth


@pytest.fixture
def dut():
    return DepthNoise(camera=CAMERA, sensor=REALSENSE_D435, seed=7, period=PERIOD)


@pytest.mark.parametrize("frame", [0, 1, 44])
def test_a_frame_has_the_pure_functions_noise(dut, frame):
    context = dut.CreateDefaultContext()
    dut.GetInputPort("depth_image").FixValue(context, image(1.2))
    context.SetTime(frame * PERIOD)
    found = dut.GetOutputPort("noisy_depth_image").Eval(context).data[..., 0]
    depth = np.full(CAMERA.shape, 1.2, dtype=np.float32)
    np.testing.assert_array_equal(
        found,
        noisy_depth(depth, CAMERA, seed=7, frame=frame, sensor=REALSENSE_D435),
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [({"period": 0.0}, "period must be positive"), ({"seed": -1}, "seed must be >= 0")],
)
def test_bad_parameters_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        DepthNoise(
            **(
                {
                    "camera": CAMERA,
                    "sensor": REALSENSE_D435,
                    "seed": 0,
                    "period": PERIOD,
                }
                | arguments
            )
        )
