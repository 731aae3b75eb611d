from math import nan

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.sensors import ImageDepth32F

from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.frame_check import FrameCheck, with_frame
from bath_drake.systems.frame_monitor import FrameMonitor

CAMERA = PinholeCamera()
PERIOD = 0.1


def image(seed):
    out = ImageDepth32F(CAMERA.width, CAMERA.height)
    values = np.random.default_rng(seed).uniform(-0.1, 2.0, CAMERA.shape)
    out.mutable_data[..., 0] = values
    return out


def advance(simulator, k, seed, stamp=None):
    """To just before frame k + 1 with the image of `seed` and the stamp."""
    dut, context = simulator.get_system(), simulator.get_mutable_context()
    dut.GetInputPort("depth_image").FixValue(context, image(seed))
    if stamp is not None:
        dut.GetInputPort("frame_stamp").FixValue(context, [stamp])
    simulator.AdvanceTo((k + 0.5) * PERIOD)
    return dut.GetOutputPort("frame_status").Eval(context)


def test_nothing_is_seen_before_the_first_frame():
    dut = FrameMonitor(camera=CAMERA, period=PERIOD)
    status = dut.GetOutputPort("frame_status").Eval(dut.CreateDefaultContext())
    np.testing.assert_array_equal(status, [1.0, 0.0, 0.0])


def test_the_status_is_that_of_the_pure_function():
    simulator = Simulator(FrameMonitor(camera=CAMERA, period=PERIOD))
    expected = FrameCheck()
    for k, seed in enumerate([0, 1, 1, 1, 1, 2]):
        expected = with_frame(expected, image(seed).data[..., 0], k * PERIOD)
        status = advance(simulator, k, seed)
        np.testing.assert_array_equal(status, expected.status())
        assert status[1] == (k in (3, 4))


def test_without_noise_frozen_frames_may_go_unwatched():
    dut = FrameMonitor(camera=CAMERA, period=PERIOD, watch_frozen=False)
    assert advance(Simulator(dut), 9, 0)[1] == 0.0


def test_a_frame_that_did_not_come_is_no_frozen_one():
    simulator = Simulator(FrameMonitor(camera=CAMERA, period=PERIOD))
    for k in range(9):
        assert advance(simulator, k, 0, stamp=0.0)[1] == 0.0


@pytest.mark.parametrize("bad", [0.05, nan, 9.0])
def test_a_bad_stamp_is_told_until_a_new_frame_comes(bad):
    simulator = Simulator(FrameMonitor(camera=CAMERA, period=PERIOD))
    assert advance(simulator, 1, 0, stamp=0.1)[2] == 0.0
    assert advance(simulator, 2, 1, stamp=bad)[2] == 1.0
    assert advance(simulator, 3, 2, stamp=0.3)[2] == 0.0


@pytest.mark.parametrize("period", [0.0, -1.0, nan])
def test_a_period_that_is_none_is_refused(period):
    with pytest.raises(ValueError, match="period"):
        FrameMonitor(camera=CAMERA, period=period)
