"""The folder that holds a recording, as others read it."""

import json

import cv2
import numpy as np
import pytest

from bath_drake.demonstrations.rgbd.writer import (
    RgbdWriter,
    check_recording_output,
    millimetres,
)
from bath_drake.errors import DemonstrationError
from bath_drake.perception.camera import PinholeCamera

CAMERA = PinholeCamera(8, 6, 7.0, 7.5, 4.0, 3.0)
POSE = np.array([[0, 0, 1, 0.2], [-1, 0, 0, 0], [0, -1, 0, 1.9], [0, 0, 0, 1.0]])


@pytest.fixture
def frame(rng):
    colour = rng.integers(0, 256, (*CAMERA.shape, 3), dtype=np.uint8)
    depth = np.round(rng.uniform(0.5, 4.5, CAMERA.shape), 3).astype(np.float32)
    return colour, depth


def names(folder):
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


def test_what_was_written_is_read_back_exactly(tmp_path, frame):
    colour, depth = frame
    writer = RgbdWriter(tmp_path / "new" / "folder", CAMERA, POSE)
    writer.write(0.0, colour, depth)
    writer.write(0.1, colour[::-1], depth)
    folder = writer.folder
    seen = cv2.imread(str(folder / "color/000000.png"), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(seen[..., ::-1], colour)
    seen = cv2.imread(str(folder / "depth/000001.png"), cv2.IMREAD_UNCHANGED)
    assert seen.dtype == np.uint16
    np.testing.assert_array_equal(seen, np.round(depth * 1000.0))
    assert (folder / "timestamps.csv").read_text() == (
        "frame,t_s\n000000,0.000000\n000001,0.100000\n"
    )
    assert names(folder) == [
        "color/000000.png",
        "color/000001.png",
        "depth/000000.png",
        "depth/000001.png",
        "intrinsics.json",
        "timestamps.csv",
    ]


def test_the_intrinsics_count_pixel_centres_as_integers(tmp_path):
    RgbdWriter(tmp_path, CAMERA, POSE)
    found = json.loads((tmp_path / "intrinsics.json").read_text())
    assert found.pop("X_WC") == POSE.tolist()
    expected = dict(width=8, height=6, fx=7.0, fy=7.5, cx=3.5, cy=2.5, depth_scale=1000)
    assert found == expected


def test_an_unknown_pose_is_left_out(tmp_path):
    RgbdWriter(tmp_path, CAMERA)
    assert "X_WC" not in json.loads((tmp_path / "intrinsics.json").read_text())


def test_nothing_measured_is_zero_millimetres():
    depth = np.array([[0.0, -1.0, np.nan, np.inf, 65.6, 4e-4, 1.2346, 65.535]])
    np.testing.assert_array_equal(
        millimetres(depth.astype(np.float32)), [[0, 0, 0, 0, 0, 0, 1235, 65535]]
    )


def test_a_recording_without_an_end_is_whole_up_to_its_last_frame(
    tmp_path, frame, monkeypatch
):
    writer = RgbdWriter(tmp_path, CAMERA)
    writer.write(0.0, *frame)
    monkeypatch.setattr(cv2, "imencode", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        writer.write(0.1, *frame)
    assert (tmp_path / "timestamps.csv").read_text() == "frame,t_s\n000000,0.000000\n"
    assert not [name for name in names(tmp_path) if name.startswith(".")]


@pytest.mark.parametrize(
    "name", ["color", "depth", "intrinsics.json", "timestamps.csv", "truth.npz"]
)
def test_an_earlier_recording_is_never_written_into(tmp_path, name):
    (tmp_path / name).mkdir()
    with pytest.raises(DemonstrationError, match=f"holds {name} of an earlier"):
        RgbdWriter(tmp_path, CAMERA)
    assert [p.name for p in tmp_path.iterdir()] == [name]


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "file").touch()
    for path in (tmp_path / "file", tmp_path / "a\0b"):
        with pytest.raises(DemonstrationError, match="not a folder to record into"):
            check_recording_output(path)
    with pytest.raises(DemonstrationError, match="cannot be written to"):
        check_recording_output(tmp_path / "file" / "below")


def test_the_truth_stands_beside_the_frames(tmp_path):
    writer = RgbdWriter(tmp_path, CAMERA)
    writer.write_truth({"t": np.arange(3.0)})
    with np.load(tmp_path / "truth.npz", allow_pickle=False) as truth:
        np.testing.assert_array_equal(truth["t"], np.arange(3.0))


def test_frames_of_another_size_or_order_are_refused(tmp_path, frame):
    colour, depth = frame
    writer = RgbdWriter(tmp_path, CAMERA)
    with pytest.raises(ValueError, match="images must be"):
        writer.write(0.0, colour[1:], depth)
    writer.write(0.0, colour, depth)
    for t in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match="does not increase"):
            writer.write(t, colour, depth)
    with pytest.raises(ValueError, match="X_WC must be"):
        RgbdWriter(tmp_path / "other", CAMERA, np.eye(3))
