"""`bath-drake capture` on drawn recordings: right, or one line and no file."""

import json
import shutil

import numpy as np
import pytest
from made_up_carer import FRAMES, GREEN, RATE, contact, stroke_place, write_recording

from bath_drake import cli
from bath_drake.demonstrations.capture.marker_search import marker_colour
from bath_drake.demonstrations.capture.options import CaptureOptions
from bath_drake.demonstrations.processing import canonical_demonstrations
from bath_drake.demonstrations.recording import read_recording
from bath_drake.demonstrations.rgbd.folder import open_rgbd
from bath_drake.learning.frechet import discrete_frechet

HIDDEN = (8, 16, 17, 18, 19)


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """A recording with a gap of a frame and one of four."""
    return write_recording(tmp_path_factory.mktemp("filmed"), HIDDEN)


def run(capsys, *words):
    try:
        code = cli.main([str(word) for word in words])
    except SystemExit as stop:
        code = stop.code
    return code, *capsys.readouterr()


@pytest.fixture(scope="module")
def captured(filmed, tmp_path_factory):
    path = tmp_path_factory.mktemp("captured") / "demo.csv"
    assert cli.main(["capture", str(filmed), "-o", str(path)]) == 0
    return path


def test_the_stroke_is_the_markers_path_on_the_back(captured):
    recording = read_recording(captured)
    box = recording.metadata.body_box
    truth = np.array([contact(*stroke_place(k))[0] for k in range(FRAMES)])
    shown = np.array([k not in HIDDEN[1:] for k in range(FRAMES)])
    np.testing.assert_allclose(recording.t, np.arange(FRAMES)[shown] / RATE, atol=1e-6)
    # The back's frame: y to the head, z towards the camera; its origin is the box's.
    found = recording.points[:, :2] * [1.0, -1.0]
    offset = np.mean(found - truth[shown, :2], axis=0)
    # A barrel has no shoulders: where its back ends below is a matter of taste.
    assert abs(offset[0]) < 0.01
    assert abs(offset[1]) < 0.04
    # A pixel is 7 mm, and the plane of a barrel is held to some degrees: 7 to 10 mm, by
    # where its lower end is found.
    assert discrete_frechet(found - offset, truth[:, :2][shown]) < 11e-3
    # 36 by 44 cm, 1 % left out at either end, and pixels of 7 mm.
    np.testing.assert_allclose(box.extents, [0.36, 0.42], atol=0.03)


def test_the_long_gap_is_in_the_file_and_the_short_one_filled(captured):
    ((start, end),) = read_recording(captured).metadata.gaps
    assert (start, end) == pytest.approx((15 / RATE, 20 / RATE), abs=1e-6)


def test_a_demonstration_with_a_gap_is_learned_from_with_a_word(captured, caplog):
    (learned,), frame = canonical_demonstrations([read_recording(captured)])
    assert frame.kind == "body_box"
    assert np.abs(learned.points).max() < 1.0
    assert "1 gaps, 0.42 s" in caplog.text


def test_the_gaps_are_named_and_the_overview_is_a_picture(filmed, tmp_path, capsys):
    path = tmp_path / "demo.csv"
    green = ("--marker-colour", "20,190,40")
    code, out, _ = run(capsys, "capture", filmed, "-o", path, *green)
    assert code == 0
    assert "0.58 to 0.75 s, marker hidden: filled" in out
    assert "1.25 to 1.67 s, marker hidden: LEFT OPEN" in out
    assert path.with_suffix(".png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "said", [{"marker_at": (81, 80)}, {"marker_box": (77, 76, 85, 84)}]
)
def test_a_click_or_a_box_in_the_first_frame_shows_the_marker(filmed, said):
    found = marker_colour(open_rgbd(filmed), CaptureOptions(**said), {})
    assert found.rgb == GREEN


def refused(capsys, tmp_path, folder, *words):
    """The message of a capture that must fail, on one line, with no file left."""
    target = tmp_path / "out"
    target.mkdir()
    code, out, err = run(capsys, "capture", folder, "-o", target / "demo.csv", *words)
    assert code == cli.BAD_INPUT
    assert out == ""
    assert err.count("\n") == 1
    assert list(target.iterdir()) == []
    return err


def test_a_recording_without_the_marker_is_refused(filmed, tmp_path, capsys):
    err = refused(capsys, tmp_path, filmed, "--marker-colour", "220,30,200")
    assert "220,30,200 is nowhere" in err


def test_nothing_vivid_is_no_marker(tmp_path, capsys):
    folder = write_recording(tmp_path / "bare", range(6), frames=6)
    assert "no vivid blob" in refused(capsys, tmp_path, folder)


def test_a_marker_before_no_body_is_refused(tmp_path, capsys):
    folder = write_recording(tmp_path / "empty", frames=6, body=False)
    assert "no back found" in refused(capsys, tmp_path, folder)


def test_one_frame_is_no_stroke(tmp_path, capsys):
    folder = write_recording(tmp_path / "one", frames=1)
    assert "found 1 frame, at least 5" in refused(capsys, tmp_path, folder)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--marker-colour", "200,200,205"), "too pale"),
        (("--marker-colour", "20,190"), "R,G,B"),
        (("--marker-colour", "20,190,400"), "255"),
        (("--marker-at", "500,3"), "columns 0 to 191"),
        (("--marker-box", "20,20,10,30"), "--marker-box"),
        (("--marker-at", "3,3", "--marker-colour", "1,2,3"), "not allowed with"),
    ],
)
def test_what_is_said_of_the_marker_is_checked(
    filmed, tmp_path, capsys, words, message
):
    assert message in refused(capsys, tmp_path, filmed, *words)


def test_damaged_recordings_are_refused_with_the_file(filmed, tmp_path, capsys):
    folder = tmp_path / "damaged"
    shutil.copytree(filmed, folder)
    image = folder / "depth/000012.png"
    image.write_bytes(image.read_bytes()[:-40])
    assert "000012.png" in refused(capsys, tmp_path, folder)
    shutil.rmtree(tmp_path / "out")
    image.unlink()
    assert "000012" in refused(capsys, tmp_path, folder)


@pytest.mark.parametrize("wrong", [{"depth_scale": 100.0}, {"fx": 420.0, "fy": 420.0}])
def test_another_cameras_intrinsics_are_refused(filmed, tmp_path, capsys, wrong):
    folder = tmp_path / "wrong"
    shutil.copytree(filmed, folder)
    path = folder / "intrinsics.json"
    numbers = json.loads(path.read_text()) | wrong
    path.write_text(json.dumps(numbers))
    err = refused(capsys, tmp_path, folder, "--marker-colour", "20,190,40")
    assert "depth_scale" in err


@pytest.mark.parametrize(
    ("name", "message"),
    [("demo.txt", "ends in .csv"), ("none/demo.csv", "does not exist")],
)
def test_the_output_is_checked_before_the_work(filmed, tmp_path, capsys, name, message):
    code, _, err = run(capsys, "capture", filmed, "-o", tmp_path / name)
    assert code == cli.BAD_INPUT
    assert message in err


def test_a_recordings_own_table_is_never_overwritten(filmed, capsys):
    before = (filmed / "timestamps.csv").read_bytes()
    code, _, err = run(capsys, "capture", filmed, "-o", filmed / "timestamps.csv")
    assert code == cli.BAD_INPUT
    assert "file of the recording" in err
    assert (filmed / "timestamps.csv").read_bytes() == before
