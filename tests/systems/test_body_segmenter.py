import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.sensors import ImageDepth32F, ImageRgba8U

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.observation import observe_body
from bath_drake.perception.segmentation import SegmentationConfig
from bath_drake.perception.self_filter import robot_silhouette
from bath_drake.systems.body_segmenter import BodySegmenter

CAMERA = PinholeCamera()
# Level, looking along +y of W.
R_WC = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
P_WC = np.array([0.0, -1.3, 1.0])
CONFIG = SegmentationConfig(
    box_low_W=np.array([-0.6, -0.4, 0.5]), box_high_W=np.array([0.6, 0.4, 1.6])
)
PERIOD = 0.1


class Rod:
    """A robot of one link, 40 mm wide, that its first joint moves along x."""

    def hulls_in_world(self, q):
        corners = np.array(np.meshgrid([-0.02, 0.02], [-0.2, -0.1], [0.6, 1.0]))
        return [corners.reshape(3, -1).T + np.array([q[0], 0.0, 0.0])]


def _images():
    x, z = CAMERA.rays[..., 0] * 1.3, -CAMERA.rays[..., 1] * 1.3
    back = (np.abs(x) / 0.17) ** 6 + (np.abs(z) / 0.23) ** 6 <= 1.0
    colour = ImageRgba8U(CAMERA.width, CAMERA.height)
    colour.mutable_data[:] = (200, 198, 195, 255)
    colour.mutable_data[back] = (200, 150, 120, 255)
    depth = ImageDepth32F(CAMERA.width, CAMERA.height)
    depth.mutable_data[..., 0] = np.where(back, 1.3 + x**2, 2.6)
    return colour, depth


@pytest.fixture
def dut():
    return BodySegmenter(
        camera=CAMERA,
        X_WC=RigidTransform(RotationMatrix(R_WC), P_WC),
        robot=Rod(),
        config=CONFIG,
        period=PERIOD,
    )


def _fix(dut, context, q=0.0):
    colour, depth = _images()
    dut.GetInputPort("colour_image").FixValue(context, colour)
    dut.GetInputPort("depth_image").FixValue(context, depth)
    dut.GetInputPort("arm_position").FixValue(context, [q, 0, 0, 0, 0, 0, 0])


def _run(dut, until, q=0.0):
    simulator = Simulator(dut)
    _fix(dut, simulator.get_mutable_context(), q)
    simulator.Initialize()
    simulator.AdvanceTo(until)
    return simulator


def _seen(dut, simulator):
    return dut.GetOutputPort("body_observation").Eval(simulator.get_context())


def test_nothing_is_found_before_the_first_frame(dut):
    context = dut.CreateDefaultContext()
    assert not dut.GetOutputPort("body_observation").Eval(context).found


def test_the_observation_is_that_of_the_pure_function(dut):
    q = 0.03
    seen = _seen(dut, _run(dut, 0.5 * PERIOD, q))
    colour, depth = _images()
    robot_mask = robot_silhouette(Rod().hulls_in_world([q]), CAMERA, R_WC, P_WC)
    expected = observe_body(
        colour.data,
        depth.data[..., 0],
        robot_mask,
        camera=CAMERA,
        R_WC=R_WC,
        p_WC=P_WC,
        config=CONFIG,
        stamp=0.0,
    )
    assert seen.found
    for name in ("mask", "robot_mask", "points_W", "completed_points_W", "colours"):
        np.testing.assert_array_equal(getattr(seen, name), getattr(expected, name))
    assert seen.area == expected.area


def test_the_robots_silhouette_follows_its_joints(dut):
    left = _seen(dut, _run(dut, 0.5 * PERIOD, -0.1)).robot_mask
    right = _seen(dut, _run(dut, 0.5 * PERIOD, 0.1)).robot_mask
    assert np.nonzero(left)[1].mean() < np.nonzero(right)[1].mean()


def test_frames_are_taken_at_the_period_and_stamped(dut):
    simulator = _run(dut, 0.5 * PERIOD)
    assert _seen(dut, simulator).stamp == 0.0
    simulator.AdvanceTo(2.5 * PERIOD)
    assert _seen(dut, simulator).stamp == pytest.approx(2 * PERIOD)


def test_a_lost_body_keeps_its_completed_points(dut):
    simulator = _run(dut, 0.5 * PERIOD)
    before = _seen(dut, simulator)
    blank = ImageDepth32F(CAMERA.width, CAMERA.height)
    blank.mutable_data[:] = np.inf
    context = simulator.get_mutable_context()
    dut.GetInputPort("depth_image").FixValue(context, blank)
    simulator.AdvanceTo(1.5 * PERIOD)
    lost = _seen(dut, simulator)
    assert not lost.found
    np.testing.assert_array_equal(lost.completed_points_W, before.completed_points_W)


def test_an_unconnected_image_is_named():
    dut = BodySegmenter(
        camera=CAMERA, X_WC=RigidTransform(), robot=Rod(), config=CONFIG, period=PERIOD
    )
    simulator = Simulator(dut)
    with pytest.raises(RuntimeError, match="colour_image"):
        simulator.AdvanceTo(PERIOD)


@pytest.mark.parametrize(
    ("name", "value"),
    [("period", 0.0), ("period", float("nan")), ("dilation_px", -1)],
)
def test_bad_parameters_are_refused(name, value):
    good = {
        "camera": CAMERA,
        "X_WC": RigidTransform(),
        "robot": Rod(),
        "config": CONFIG,
        "period": PERIOD,
    }
    with pytest.raises(ValueError, match=name):
        BodySegmenter(**{**good, name: value})


def _stamped(dut, stamps):
    """The observation after each of its looks, its stamp port set before."""
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    _fix(dut, context)
    seen = []
    for index, stamp in enumerate(stamps):
        dut.GetInputPort("frame_stamp").FixValue(context, [stamp])
        if index == 0:
            simulator.Initialize()
        simulator.AdvanceTo(PERIOD * (index + 0.5))
        seen.append(_seen(dut, simulator))
    return seen


def test_an_observation_has_the_time_its_frame_was_taken_at(dut):
    late = [-0.05, 0.04, 0.15]
    assert [o.stamp for o in _stamped(dut, late)] == late


def test_a_frame_seen_before_or_older_is_no_new_frame(dut):
    first, same, older, newer = _stamped(dut, [0.0, 0.0, -0.1, 0.3])
    assert first.found
    assert same is first
    assert older is first
    assert newer.stamp == 0.3


def test_a_camera_of_which_no_frame_has_come_shows_nothing(dut):
    (before,) = _stamped(dut, [-np.inf])
    assert before.stamp == -np.inf
    assert not before.found


def test_without_a_robot_nothing_is_masked():
    dut = BodySegmenter(
        camera=CAMERA,
        X_WC=RigidTransform(RotationMatrix(R_WC), P_WC),
        robot=None,
        config=CONFIG,
        period=PERIOD,
    )
    assert not dut.HasInputPort("arm_position")
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    colour, depth = _images()
    dut.GetInputPort("colour_image").FixValue(context, colour)
    dut.GetInputPort("depth_image").FixValue(context, depth)
    simulator.Initialize()
    simulator.AdvanceTo(0.5 * PERIOD)
    observation = _seen(dut, simulator)
    assert observation.found
    assert not observation.robot_mask.any()
