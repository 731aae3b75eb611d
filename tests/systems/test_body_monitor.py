"""The body monitor as a system; `perception.body_check` decides."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.sensors import ImageDepth32F

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.systems.body_monitor import BodyMonitor

CAMERA = PinholeCamera()
PERIOD = 0.1
MAP = CanonicalMap(np.eye(3), np.zeros(3), np.ones(2))


class Frames(LeafSystem):
    """A camera that renders whenever it is asked, and what is made of its frames."""

    def __init__(self, asked):
        super().__init__()
        self._asked = asked
        size = CAMERA.width, CAMERA.height
        self.DeclareAbstractOutputPort(
            "depth_image",
            lambda: Value(ImageDepth32F(*size)),
            self._render,
            {self.time_ticket()},
        )
        self.DeclareAbstractOutputPort(
            "body_observation",
            lambda: Value(BodyObservation()),
            self._observe,
            {self.time_ticket()},
        )

    def _render(self, context, output):
        self._asked.append(context.get_time())
        image = ImageDepth32F(CAMERA.width, CAMERA.height)
        # Nothing but a plate in the box, 0.4 m wide, that comes with the third frame.
        image.mutable_data[:] = np.inf
        if context.get_time() > 1.5 * PERIOD:
            image.mutable_data[150:270, 190:310, 0] = 1.2
        output.set_value(image)

    def _observe(self, context, output):
        stamp = PERIOD * np.floor(context.get_time() / PERIOD + 1e-6)
        none = np.zeros((*CAMERA.shape,), dtype=bool)
        output.set_value(
            BodyObservation(stamp=stamp, found=True, area=0.1, robot_mask=none)
        )


@pytest.fixture
def run():
    asked, builder = [], DiagramBuilder()
    frames = builder.AddSystem(Frames(asked))
    monitor = builder.AddSystem(
        BodyMonitor(
            camera=CAMERA,
            X_WC=RigidTransform(),
            low_W=np.array([-0.8, -0.8, 0.5]),
            high_W=np.array([0.8, 0.8, 1.8]),
            period=PERIOD,
        )
    )
    for port in ("depth_image", "body_observation"):
        builder.Connect(frames.GetOutputPort(port), monitor.GetInputPort(port))
    simulator = Simulator(builder.Build())
    context = monitor.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    monitor.GetInputPort("canonical_map").FixValue(context, Value[object](MAP))
    monitor.GetInputPort("map_status").FixValue(context, [1.0])

    def status(t):
        simulator.AdvanceTo(t)
        return monitor.GetOutputPort("body_status").Eval(context)

    return asked, status


def test_an_image_is_asked_for_with_its_frame_and_never_between(run):
    asked, status = run
    status(3.5 * PERIOD)
    np.testing.assert_allclose(asked, PERIOD * np.arange(4), atol=1e-9)


def test_what_comes_into_the_box_is_told_with_the_frame_that_shows_it(run):
    _, status = run
    assert status(1.9 * PERIOD)[1] == 1.0
    np.testing.assert_array_equal(status(2.5 * PERIOD), [0.0, 2.0])
