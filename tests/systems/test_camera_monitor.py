"""The camera monitor as a system; `perception.arm_sight` decides."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.sensors import ImageDepth32F

from bath_drake.perception.arm_sight import arm_core, rim_width, seen_through
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.safety.self_distance import capsule_ends
from bath_drake.scene.arm import base_pose, home_position
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.scene.config import ArmConfig, CameraConfig
from bath_drake.systems.camera_monitor import CameraMonitor

PERIOD = 0.1
SHOT, ARM = CameraConfig(), ArmConfig()
CAMERA, R_WC, p_WC = SHOT.pinhole(), np.array(SHOT.rotation()), np.array(SHOT.eye)
X_WC = RigidTransform(RotationMatrix(R_WC), p_WC)
CHAIN, X_WB = arm_chain(ARM), base_pose(ARM)
HOME = home_position(ARM)


@pytest.fixture
def monitor():
    return CameraMonitor(camera=CAMERA, X_WC=X_WC, arm=CHAIN, X_WB=X_WB, period=PERIOD)


@pytest.fixture
def frame(rng):
    """Depths all over the room, and a silhouette over most of the image."""
    depth = rng.uniform(0.4, 3.0, (*CAMERA.shape, 1)).astype(np.float32)
    depth[rng.uniform(size=depth.shape) < 0.1] = np.nan
    mask = np.zeros(CAMERA.shape, dtype=bool)
    mask[40:400, 50:480] = True
    return depth, mask


def expected(depth, mask, q):
    ends = capsule_ends(q, CHAIN) @ X_WB.rotation().matrix().T + X_WB.translation()
    small = depth[::4, ::4, 0].astype(np.float64)
    rim = rim_width(small, mask[::4, ::4], CAMERA.fx)
    return seen_through(
        small,
        np.ascontiguousarray(CAMERA.rays[::4, ::4]),
        arm_core(mask, rim)[::4, ::4],
        R_WC,
        p_WC,
        np.column_stack([ends.reshape(-1, 6), CHAIN.capsules[:, 7]]),
    )


def statuses(monitor, depth, mask, q, stamps):
    """What it says after each frame."""
    simulator = Simulator(monitor)
    context = simulator.get_mutable_context()
    image = ImageDepth32F(CAMERA.width, CAMERA.height)
    image.mutable_data[:] = depth
    monitor.GetInputPort("depth_image").FixValue(context, Value(image))
    monitor.GetInputPort("arm_position").FixValue(context, q)
    told = []
    for k, stamp in enumerate(stamps):
        seen = replace(BodyObservation(), stamp=stamp, robot_mask=mask)
        monitor.GetInputPort("body_observation").FixValue(context, Value(seen))
        simulator.AdvanceTo((k + 0.5) * PERIOD)
        told.append(float(monitor.GetOutputPort("camera_status").Eval(context)[0]))
    return told


def test_it_tells_the_share_that_three_frames_agree_on(monitor, frame):
    share = expected(*frame, HOME)
    assert 0.0 < share < 1.0
    told = statuses(monitor, *frame, HOME, PERIOD * np.arange(4))
    assert told == [0.0, 0.0, share, share]


def test_the_arm_is_looked_for_where_its_joints_say_it_is(monitor, frame):
    q = HOME + 0.3
    assert expected(*frame, q) != expected(*frame, HOME)
    assert statuses(monitor, *frame, q, PERIOD * np.arange(3))[-1] == expected(
        *frame, q
    )


def test_a_frame_that_is_not_new_counts_once(monitor, frame):
    stamps = [-np.inf, 0.1, 0.1, 0.1, 0.2, 0.3]
    told = statuses(monitor, *frame, HOME, stamps)
    assert told == [0.0] * 5 + [expected(*frame, HOME)]


def test_a_period_that_is_none_is_refused():
    with pytest.raises(ValueError, match="period must be positive"):
        CameraMonitor(camera=CAMERA, X_WC=X_WC, arm=CHAIN, X_WB=X_WB, period=0.0)
