import hashlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bath_drake.demonstrations.metadata import (
    BodyBox,
    RecordingMetadata,
    metadata_block,
)
from bath_drake.demonstrations.recording import MAX_BYTES, read_recording
from bath_drake.demonstrations.recording_text import recording_text
from bath_drake.errors import DemonstrationError
from bath_drake.resources import models_folder
from bath_drake.yaml_io import dump_yaml

ROWS = [f"{0.1 * i:.1f},{0.01 * i:.2f},{0.02 * i:.2f}" for i in range(6)]
GOOD = "t,x,y\n" + "\n".join(ROWS) + "\n"
BOX = """
body_box:
  centre: [0, 0, 1]
  axes: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
  extents: [0.4, 0.5]
"""


def write(folder, text, metadata=None, name="stroke.csv"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    if metadata is not None:
        path.with_suffix(".yaml").write_text(metadata)
    return path


def three_d(text=GOOD):
    lines = text.splitlines()
    return "\n".join(["t,x,y,z", *(f"{line},0.5" for line in lines[1:])])


def test_a_planar_recording_is_read_as_it_stands(tmp_path):
    path = write(tmp_path, GOOD)
    recording = read_recording(path)
    np.testing.assert_array_equal(recording.t, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    assert recording.points.shape == (6, 2)
    np.testing.assert_array_equal(recording.points[3], [0.03, 0.06])
    assert recording.metadata == RecordingMetadata()
    assert recording.name == "stroke"
    assert recording.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize(
    ("header", "time_factor", "factor"),
    [
        ("# t_s,x_m,y_m,z_m (derived by FK, iiwa14 DH, q7=0)", 1.0, 1.0),
        ("t_ms,x_mm,y_mm,z_mm", 1e-3, 1e-3),
        ("t (us), x [cm], y (cm), Z_cm", 1e-6, 1e-2),
        ("#t,x,y,z", 1.0, 1.0),
        ("﻿t,x,y,z", 1.0, 1.0),
    ],
)
def test_units_in_the_header_are_converted(tmp_path, header, time_factor, factor):
    recording = read_recording(write(tmp_path, three_d().replace("t,x,y,z", header)))
    np.testing.assert_array_equal(
        recording.t, np.array([0, 1, 2, 3, 4, 5]) / 10 * time_factor
    )
    np.testing.assert_array_equal(recording.points[:, 2], np.full(6, 0.5) * factor)


def test_columns_are_taken_by_name_not_by_place(tmp_path):
    text = "y,t,x\n" + "\n".join(f"{0.5 - 0.1 * i},{i},{0.2 * i}" for i in range(5))
    recording = read_recording(write(tmp_path, text))
    np.testing.assert_array_equal(recording.t, np.arange(5.0))
    assert recording.points[1].tolist() == [0.2, 0.4]


def test_windows_line_ends_and_trailing_blank_lines_are_no_matter(tmp_path):
    plain = read_recording(write(tmp_path, GOOD))
    other = read_recording(write(tmp_path, GOOD.replace("\n", "\r\n") + "\r\n\r\n"))
    np.testing.assert_array_equal(plain.points, other.points)


def edited(line, text):
    lines = GOOD.splitlines()
    lines[line - 1] = text
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"", "the file is empty"),
        (b"\n\n", "the file is empty"),
        (b"\x89PNG\r\n\x1a\n\x00\xff\xfe", "not UTF-8 text"),
        (GOOD.replace("0", "\0"), "binary data"),
        ("\n".join(ROWS), "line 1: no header"),
        (edited(1, "time,px,py"), "line 1: unknown column 'time'"),
        (edited(1, "t,x,y,w"), "line 1: unknown column 'w'"),
        (edited(1, "t,x,x"), "line 1: column x is there twice"),
        (edited(1, "t,x"), "line 1: column y is missing"),
        (edited(1, "t,x,z"), "line 1: column y is missing"),
        (edited(1, "t,x_in,y_in"), "line 1: unknown unit 'in' of column x"),
        (edited(1, "t_min,x,y"), "line 1: unknown unit 'min' of column t"),
        (edited(1, "t,x (derived),y"), "line 1: unknown unit 'derived'"),
        (edited(1, "goal: [1, 2]"), "line 1: unknown column"),
        (edited(4, "0.2,0.02"), "line 4: found 2 values, expected 3"),
        (edited(4, "0.2,0.02,0.04,1"), "line 4: found 4 values, expected 3"),
        (edited(4, ""), "line 4: found 0 values, expected 3"),
        (edited(4, "0.2;0.02;0.04"), "line 4: found 1 values"),
        (edited(3, "0.1,abc,0.02"), "line 3: found 'abc', expected a finite number"),
        (edited(3, "0.1,,0.02"), "line 3: found '', expected a finite number"),
        (edited(3, "0.1,nan,0.02"), "line 3: found 'nan'"),
        (edited(3, "0.1,0.01,-inf"), "line 3: found '-inf'"),
        (edited(3, "0.1,1e999,0.02"), "line 3: found '1e999'"),
        (edited(3, "0.1,1_0,0.02"), "line 3: found '1_0'"),
        (edited(3, "0.1,٣,0.02"), "line 3: found '٣'"),
        (
            edited(5, "0.2,0.03,0.06"),
            "line 5: time 0.2 s does not increase after 0.2 s",
        ),
        (edited(5, "0.1,0.03,0.06"), "line 5: time 0.1 s does not increase"),
        ("t,x,y", "0 points, at least 5"),
        ("t,x,y\n0,0,0", "1 points, at least 5"),
        ("t,x,y\n" + "\n".join(ROWS[:4]), "4 points, at least 5"),
        ("t,x,y\n" + "\n".join(f"{i},0.5,0.5" for i in range(9)), "has no length"),
        ("t,x,y\n" + "\n".join(f"{i},{20 * i},0" for i in range(9)), "millimetres"),
        ("t,x,y\n" + "\n".join(f"{i},1e9,{i}" for i in range(9)), "millimetres"),
    ],
)
def test_a_bad_file_is_refused_by_name_and_line(tmp_path, text, message):
    path = write(tmp_path, text)
    with pytest.raises(DemonstrationError, match=message) as caught:
        read_recording(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_what_is_no_readable_file_is_refused(tmp_path):
    with pytest.raises(
        DemonstrationError, match=r"absent.csv: cannot be read: No such"
    ):
        read_recording(tmp_path / "absent.csv")
    with pytest.raises(DemonstrationError, match="found a directory"):
        read_recording(tmp_path)
    big = tmp_path / "big.csv"
    with big.open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    with pytest.raises(DemonstrationError, match="bytes are allowed"):
        read_recording(big)


# Reading a file takes longer than 200 ms now and then on a busy machine. One
# folder serves all examples: each overwrites the file of the last.
@settings(deadline=None, max_examples=100)
@given(st.lists(st.text("txyz_ms,()#0123456789.-e na", max_size=25), max_size=9))
def test_any_table_is_read_or_refused_on_one_line(tmp_path_factory, lines):
    path = write(tmp_path_factory.getbasetemp(), "\n".join(lines), name="any.csv")
    message = ""
    try:
        recording = read_recording(path)
        assert np.all(np.isfinite(recording.points))
    except DemonstrationError as error:
        message = str(error)
    assert "\n" not in message


def test_metadata_beside_the_file_are_read(tmp_path):
    text = "frame: back\nwho: a carer\nlicence: CC0-1.0\nseed: 3\nsynthetic: true" + BOX
    metadata = read_recording(write(tmp_path, three_d(), text)).metadata
    assert (metadata.frame, metadata.who, metadata.licence) == (
        "back",
        "a carer",
        "CC0-1.0",
    )
    assert metadata.synthetic
    assert metadata.seed == 3
    assert metadata.body_box == BodyBox(
        np.array([0, 0, 1]), np.eye(3), np.array([0.4, 0.5])
    )


@pytest.mark.parametrize(
    ("metadata", "message"),
    [
        ("", "found nothing"),
        ("frame: [", "line 1"),
        ("frame: 3", "frame: found 3, expected text"),
        ("colour: red", "colour: unknown key, allowed: frame, who"),
        ("frame: a\nframe: b", "line 2: duplicate key"),
        ("body_box: {centre: [0, 0, 0]}", "body_box.axes: is missing"),
        (BOX.replace("[0, 0, 1]\n", "[0, 0]\n", 1), "body_box.centre: found 2 items"),
        (BOX.replace("[0, 1, 0]", "[0, 1]"), r"body_box.axes\[1\]: found 2 items"),
        (BOX.replace("[0, 1, 0]", "[0, 1, a]"), r"body_box.axes\[1\]\[2\]: found 'a'"),
        (BOX.replace("[0, 1, 0]", "[0, 2, 0]"), "body_box: axes must be 3 orthonormal"),
        (BOX.replace("[1, 0, 0]", "[-1, 0, 0]"), "body_box: axes .*right-handed"),
        (BOX.replace("[0.4, 0.5]", "[0.4]"), "body_box: extents must be"),
        (BOX.replace("[0.4, 0.5]", "[0.4, 0]"), "body_box: extents must be"),
        (BOX.replace("[0.4, 0.5]", "[400, 500]"), "body_box: extents must be"),
        (BOX.replace("extents", "extent"), "body_box.extents: is missing"),
    ],
)
def test_bad_metadata_are_refused_by_key(tmp_path, metadata, message):
    path = write(tmp_path, three_d(), metadata)
    with pytest.raises(DemonstrationError, match=message) as caught:
        read_recording(path)
    assert str(caught.value).startswith(f"{path.with_suffix('.yaml')}: ")


def test_a_body_box_needs_points_in_space(tmp_path):
    with pytest.raises(DemonstrationError, match="body_box: needs 3-D points"):
        read_recording(write(tmp_path, GOOD, BOX))


def test_metadata_that_cannot_be_read_are_not_passed_over(tmp_path):
    path = write(tmp_path, GOOD)
    path.with_suffix(".yaml").symlink_to(tmp_path / "gone")
    with pytest.raises(DemonstrationError, match=r"stroke.yaml: cannot be read"):
        read_recording(path)


@pytest.mark.parametrize(
    "path",
    sorted((models_folder() / "demonstrations").glob("*.csv")),
    ids=lambda p: p.stem,
)
def test_every_shipped_demonstration_reads_and_names_its_licence(path):
    recording = read_recording(path)
    assert recording.points.shape[1] == 3
    assert recording.metadata.licence


def test_what_is_written_about_a_recording_is_read_back(tmp_path):
    box = BodyBox(np.zeros(3), np.eye(3), np.array([0.3, 0.5]))
    said = RecordingMetadata(
        frame="back", body_box=box, who="A", seed=3, gaps=((1.0, 1.5), (2.0, 2.25))
    )
    t, points = np.arange(6) / 10.0, np.outer(np.arange(6), [0.01, -0.02, 0.0])
    path = tmp_path / "demo.csv"
    path.write_text(recording_text(t, points))
    path.with_suffix(".yaml").write_text(dump_yaml(metadata_block(said)))
    read = read_recording(path)
    assert read.metadata == said
    np.testing.assert_allclose(read.t, t, atol=1e-12)
    np.testing.assert_allclose(read.points, points, atol=1e-12)


@pytest.mark.parametrize("gaps", ["[[2.0, 1.0]]", "[[1.0]]", "1.0"])
def test_gaps_that_are_none_are_refused(tmp_path, gaps):
    path = tmp_path / "demo.csv"
    path.write_text(recording_text(np.arange(6.0), np.eye(6)[:, :3]))
    path.with_suffix(".yaml").write_text(f"gaps: {gaps}\n")
    with pytest.raises(DemonstrationError, match="gaps"):
        read_recording(path)
