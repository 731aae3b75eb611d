import numpy as np
import pytest
from pydrake.systems.sensors import ImageRgba8U

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.colour_noise import ColourNoiseConfig, noisy_colour
from bath_drake.systems.colour_noise import ColourNoise

CAMERA = PinholeCamera(64, 48, 60.0, 60.0, 32.0, 24.0)
PERIOD = 1.0 / 30.0
CONFIG = ColourNoiseConfig(exposure=1.3)


@pytest.mark.parametrize("frame", [0, 1, 44])
def test_a_frame_has_the_pure_functions_noise(frame):
    dut = ColourNoise(camera=CAMERA, config=CONFIG, seed=7, period=PERIOD)
    context = dut.CreateDefaultContext()
    image = ImageRgba8U(CAMERA.width, CAMERA.height)
    image.mutable_data[:] = (120, 90, 60, 255)
    dut.GetInputPort("colour_image").FixValue(context, image)
    t = frame * PERIOD
    context.SetTime(t)
    found = dut.GetOutputPort("noisy_colour_image").Eval(context).data
    expected = noisy_colour(image.data, CONFIG, seed=7, frame=frame, t=t)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"period": 0.0}, "period must be positive"),
        ({"seed": -1}, "seed must be >= 0"),
        ({"config": ColourNoiseConfig(exposure=0.0)}, "exposure: found"),
    ],
)
def test_bad_parameters_are_refused(arguments, message):
    good = {"camera": CAMERA, "config": CONFIG, "seed": 0, "period": PERIOD}
    with pytest.raises(ValueError, match=message):
        ColourNoise(**(good | arguments))
