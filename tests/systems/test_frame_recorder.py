import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.sensors import ImageDepth32F, ImageRgba8U

from bath_drake.systems.frame_recorder import FrameRecorder

WIDTH, HEIGHT, PERIOD = 6, 4, 0.1


class Clock(LeafSystem):
    """A camera that shows the time."""

    def __init__(self):
        super().__init__()
        colour, depth = ImageRgba8U(WIDTH, HEIGHT), ImageDepth32F(WIDTH, HEIGHT)
        self.DeclareAbstractOutputPort(
            "colour_image", lambda: Value(colour), self._colour
        )
        self.DeclareAbstractOutputPort("depth_image", lambda: Value(depth), self._depth)

    def _colour(self, context, output):
        image = ImageRgba8U(WIDTH, HEIGHT)
        image.mutable_data[:] = round(100 * context.get_time())
        output.set_value(image)

    def _depth(self, context, output):
        image = ImageDepth32F(WIDTH, HEIGHT)
        image.mutable_data[:] = context.get_time()
        output.set_value(image)


def test_one_frame_a_period_each_of_its_own_time():
    frames = []
    builder = DiagramBuilder()
    camera = builder.AddSystem(Clock())
    recorder = builder.AddSystem(
        FrameRecorder(
            width=WIDTH,
            height=HEIGHT,
            period=PERIOD,
            write=lambda *frame: frames.append(frame),
        )
    )
    for port in ("colour_image", "depth_image"):
        builder.Connect(camera.GetOutputPort(port), recorder.GetInputPort(port))
    Simulator(builder.Build()).AdvanceTo(0.55)
    np.testing.assert_allclose([f[0] for f in frames], np.arange(6) * PERIOD)
    for t, colour, depth in frames:
        assert colour.shape == (HEIGHT, WIDTH, 3)
        assert (colour == round(100 * t)).all()
        np.testing.assert_array_equal(depth, np.full((HEIGHT, WIDTH), np.float32(t)))


def test_a_period_must_be_positive():
    with pytest.raises(ValueError, match="period must be positive"):
        FrameRecorder(width=4, height=4, period=0.0, write=lambda *_: None)
