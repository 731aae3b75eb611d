import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.sensors import ImageDepth32F, ImageRgba8U

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.faults import (
    DropletsFault,
    FaultsConfig,
    FrameFault,
    LateFault,
)
from bath_drake.perception.lens_faults import with_lens_faults
from bath_drake.systems.camera_faults import CameraFaults

CAMERA = PinholeCamera(16, 12, 20.0, 20.0, 8.0, 6.0)
PERIOD = 0.1


class Clock(LeafSystem):
    """A camera and an arm that show the time."""

    def __init__(self):
        super().__init__()
        colour = ImageRgba8U(CAMERA.width, CAMERA.height)
        depth = ImageDepth32F(CAMERA.width, CAMERA.height)
        self.DeclareAbstractOutputPort(
            "colour_image", lambda: Value(colour), self._colour
        )
        self.DeclareAbstractOutputPort("depth_image", lambda: Value(depth), self._depth)
        self.DeclareVectorOutputPort("arm_position", 7, self._position)

    def _colour(self, context, output):
        image = ImageRgba8U(CAMERA.width, CAMERA.height)
        image.mutable_data[:] = round(100 * context.get_time())
        output.set_value(image)

    def _depth(self, context, output):
        image = ImageDepth32F(CAMERA.width, CAMERA.height)
        image.mutable_data[:] = 1.0 + context.get_time()
        output.set_value(image)

    def _position(self, context, output):
        output.SetFromVector(np.full(7, context.get_time()))


def simulated(config, seed=0):
    builder = DiagramBuilder()
    clock = builder.AddSystem(Clock())
    faults = builder.AddSystem(
        CameraFaults(camera=CAMERA, config=config, seed=seed, period=PERIOD)
    )
    for name in ("colour_image", "depth_image", "arm_position"):
        builder.Connect(clock.GetOutputPort(name), faults.GetInputPort(name))
    simulator = Simulator(builder.Build())
    simulator.Initialize()
    return faults, simulator


def outputs(faults, simulator):
    context = faults.GetMyContextFromRoot(simulator.get_context())
    names = ("frame_stamp", "colour_image", "depth_image", "arm_position")
    stamp, colour, depth, q = (faults.GetOutputPort(n).Eval(context) for n in names)
    return stamp[0], colour.data.copy(), depth.data[..., 0].copy(), q


def stamps(config, times):
    faults, simulator = simulated(config)
    found = []
    for t in times:
        simulator.AdvanceTo(t)
        stamp, colour, depth, q = outputs(faults, simulator)
        found.append(round(stamp, 9))
        if np.isfinite(stamp):
            # Images and arm are those of the stamp.
            assert colour[0, 0, 0] == round(100 * stamp)
            np.testing.assert_allclose(depth, 1.0 + stamp, rtol=1e-6)  # float32
            np.testing.assert_array_equal(q, stamp)
    return found


def test_between_frames_the_last_one_stays():
    never = FaultsConfig(loss=FrameFault(begin=50.0, end=60.0))
    assert stamps(never, [0.0, 0.05, 0.15, 0.31]) == [0.0, 0.0, 0.1, 0.3]


def test_a_lost_frame_changes_nothing():
    config = FaultsConfig(loss=FrameFault(begin=0.2, end=0.4))
    assert stamps(config, [0.15, 0.25, 0.35, 0.45]) == [0.1, 0.1, 0.1, 0.4]


def test_before_any_frame_has_come_there_is_nothing_to_see():
    faults, simulator = simulated(FaultsConfig(loss=FrameFault(end=0.2)))
    simulator.AdvanceTo(0.15)
    stamp, colour, depth, _ = outputs(faults, simulator)
    assert stamp == -np.inf
    assert not colour.any()
    assert not depth.any()


def test_a_late_frame_has_the_time_it_was_taken_at():
    config = FaultsConfig(late=LateFault(delay=0.2))
    assert stamps(config, [0.25, 0.35, 0.45]) == [0.0, 0.1, 0.2]


def test_a_frame_is_known_at_the_very_instant_it_is_taken():
    """Or all that look at the camera's rate would be a frame behind."""
    faults, _ = simulated(FaultsConfig(late=LateFault(begin=9.0)))
    context = faults.CreateDefaultContext()
    image = ImageRgba8U(CAMERA.width, CAMERA.height)
    image.mutable_data[:] = 42
    faults.GetInputPort("colour_image").FixValue(context, image)
    depth = ImageDepth32F(CAMERA.width, CAMERA.height)
    faults.GetInputPort("depth_image").FixValue(context, depth)
    faults.GetInputPort("arm_position").FixValue(context, np.ones(7))
    seen = faults.GetOutputPort("colour_image").Eval(context)
    assert (seen.data == 42).all()
    assert faults.GetOutputPort("frame_stamp").Eval(context)[0] == 0.0


def test_water_is_laid_over_the_images_as_the_pure_function_does():
    config = FaultsConfig(droplets=DropletsFault(count=3, radius=0.3))
    faults, simulator = simulated(config, seed=5)
    simulator.AdvanceTo(0.25)
    _, colour, depth, _ = outputs(faults, simulator)
    expected = with_lens_faults(
        np.full((*CAMERA.shape, 4), 20, dtype=np.uint8),
        np.full(CAMERA.shape, 1.2, dtype=np.float32),
        config,
        seed=5,
        frame=2,
        t=0.2,
    )
    np.testing.assert_array_equal(colour, expected[0])
    np.testing.assert_allclose(depth, expected[1], rtol=1e-6)  # the clock's rounding


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"period": float("inf")}, "period must be positive"),
        ({"seed": -1}, "seed must be >= 0"),
        ({"config": FaultsConfig(late=LateFault(delay=9.0))}, "late.delay: found"),
    ],
)
def test_bad_parameters_are_refused(arguments, message):
    good = {"camera": CAMERA, "config": FaultsConfig(), "seed": 0, "period": PERIOD}
    with pytest.raises(ValueError, match=message):
        CameraFaults(**(good | arguments))
