import numpy as np
import pytest

from bath_drake.demonstrations.rgbd.folder import open_rgbd
from bath_drake.demonstrations.rgbd.writer import RgbdWriter
from bath_drake.errors import DemonstrationError
from bath_drake.perception.camera import PinholeCamera
from bath_drake.systems.rgbd_recording import RgbdRecording

CAMERA = PinholeCamera(8, 6, 10.0, 10.0, 4.0, 3.0)
# Not in step, and on a clock of its own.
TIMES = (5.0, 5.1, 5.35)


def picture(k):
    return np.full((*CAMERA.shape, 3), 10 * (k + 1), dtype=np.uint8)


@pytest.fixture
def recording(tmp_path):
    writer = RgbdWriter(tmp_path / "film", CAMERA, np.eye(4))
    for k, t in enumerate(TIMES):
        depth = np.full(CAMERA.shape, 1.0 + k, dtype=np.float32)
        writer.write(t, picture(k), depth)
    return open_rgbd(tmp_path / "film")


@pytest.mark.parametrize(
    ("t", "frame"),
    [(0.0, 0), (0.099, 0), (0.1, 1), (0.3, 1), (0.35, 2), (99.0, 2)],
)
def test_each_frame_is_shown_from_its_time_until_the_next(recording, t, frame):
    dut = RgbdRecording(recording=recording)
    context = dut.CreateDefaultContext()
    context.SetTime(t)
    colour, depth, stamp = (
        dut.GetOutputPort(name).Eval(context)
        for name in ("colour_image", "depth_image", "frame_stamp")
    )
    expected = recording.frame(frame)
    np.testing.assert_array_equal(colour.data[..., :3], expected.colour)
    assert (colour.data[..., 3] == 255).all()
    np.testing.assert_allclose(depth.data[..., 0], expected.depth, rtol=1e-6)  # float32
    assert stamp[0] == pytest.approx(TIMES[frame] - TIMES[0], abs=1e-9)


def test_the_stamp_is_told_without_reading_the_images(recording):
    dut = RgbdRecording(recording=recording)
    context = dut.CreateDefaultContext()
    (recording.path / "color" / "000000.png").write_bytes(b"no image")
    assert dut.GetOutputPort("frame_stamp").Eval(context)[0] == 0.0
    with pytest.raises(DemonstrationError, match=r"000000\.png"):
        dut.GetOutputPort("colour_image").Eval(context)
