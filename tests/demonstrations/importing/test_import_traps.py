"""Files that would be read wrongly, or stop the reader, without a word."""

import os

import numpy as np
import pytest
from foreign_files import (
    HAND,
    MODEL,
    T,
    body_markers,
    mmm_frames,
    write_c3d,
    write_csv,
    write_mmm,
    write_model,
)

ROWS = np.column_stack([T, HAND])


def test_each_column_has_a_unit_of_its_own(imported, tmp_path):
    rows = ROWS * [1.0, 1e3, 1e2, 1.0]
    recording, _ = imported(write_csv(tmp_path / "a.csv", "t_s,x_mm,y_cm,z_m", rows))
    # Six digits are written, and six are read.
    np.testing.assert_allclose(recording.points, HAND, atol=2e-6)


@pytest.mark.parametrize(
    ("header", "complaint"),
    [
        ("t_m,x,y,z", "column 't_m' is t and in m by its name, allowed: s, ms, us, ns"),
        ("t,x_s,y_s,z_s", "column 'x_s' is x and in s by its name, allowed: m, cm, mm"),
    ],
)
def test_a_unit_that_does_not_fit_is_refused(header, complaint, imported, tmp_path):
    assert complaint in imported(write_csv(tmp_path / "a.csv", header))[1]


def test_a_third_coordinate_with_two_names_is_not_dropped(imported, tmp_path):
    rows = np.column_stack([ROWS, T])
    file = write_csv(tmp_path / "a.csv", "t,px,py,pz,p_z", rows)
    assert "found 2 sets of columns" in imported(file)[1]
    assert "'px' is told twice" in imported(file, "--x", "px", "--y", "px")[1]


@pytest.mark.parametrize(
    "words", [("--marker", "HAND"), ("--topic", "/x"), ("--points", "p")]
)
def test_what_says_nothing_of_the_format_is_refused(words, imported, tmp_path):
    said = imported(write_csv(tmp_path / "a.csv"), *words)[1]
    assert f"{words[0]} says nothing of this format (csv), allowed: --units" in said


def test_a_cut_is_a_number(imported, tmp_path):
    assert (
        "--start: found nan"
        in imported(write_csv(tmp_path / "a.csv"), "--start", "nan")[1]
    )


@pytest.mark.parametrize(
    ("t", "points", "complaint"),
    [
        (T, HAND + np.array([5e6, 0.0, 0.0]), "m from the origin, at most 1e+06 m"),
        # The file's microseconds would make these times equal.
        (1e-5 * T, 1e-5 * HAND, "follows after 3.33e-07 s"),
        (np.arange(250_000) / 100, None, "has 250000 samples, at most 200000"),
    ],
)
def test_what_is_written_could_be_read(t, points, complaint, imported, tmp_path):
    if points is None:
        points = np.column_stack([np.sin(t), np.cos(t)])
    np.savez(tmp_path / "a.npz", t=t, p=points)
    assert complaint in imported(tmp_path / "a.npz")[1]


def test_what_looks_like_another_unit_is_noted(imported, tmp_path):
    file = write_csv(tmp_path / "a.csv", rows=ROWS * [1e3, 1.0, 1.0, 1.0])
    assert "milliseconds? then --time-units ms" in imported(file)[1]
    metres = write_c3d(tmp_path / "a.c3d", {"HAND": HAND})
    _, said = imported(metres, "--marker", "HAND")
    assert "metres? then --units m" in said
    assert "note" not in imported(metres, "--marker", "HAND", "--units", "m")[1]


@pytest.mark.parametrize("suffix", ["csv", "npz", "c3d", "xml", "bag", "mcap", "db3"])
def test_a_pipe_is_not_waited_for(suffix, imported, tmp_path):
    os.mkfifo(tmp_path / f"a.{suffix}")
    assert "found not a file" in imported(tmp_path / f"a.{suffix}")[1]


def test_a_folder_is_no_c3d_file(imported, tmp_path):
    assert "found a directory" in imported(tmp_path, "--format", "c3d")[1]


def test_names_in_files_break_no_line(imported, tmp_path):
    file = write_c3d(tmp_path / "a.c3d", {"A\nB": HAND, "\x1b[31m": HAND})
    # The fixture checks that this is one line.
    assert "\x1b" not in imported(file)[1]


def test_the_c3d_reader_runs_nothing_of_the_folder(imported, tmp_path, monkeypatch):
    file = write_c3d(tmp_path / "a.c3d", {"HAND": 1e3 * HAND})
    (tmp_path / "ezc3d.py").write_text("raise SystemExit(3)")
    monkeypatch.chdir(tmp_path)
    assert imported(file, "--marker", "HAND")[0] is not None


def test_markers_beyond_the_first_255_have_names(imported, tmp_path):
    markers = {f"M{k}": 1e3 * HAND[::-1] for k in range(520)}
    file = write_c3d(tmp_path / "a.c3d", {**markers, "HAND": 1e3 * HAND})
    recording, _ = imported(file, "--marker", "HAND")
    np.testing.assert_allclose(recording.points, HAND, atol=2e-6)


def test_the_back_s_markers_may_have_the_subject_s_name(imported, tmp_path):
    hand = 500.0 * (HAND - [0.2, 0.0, 0.9])
    markers = {"HAND": hand, **body_markers()}
    file = write_c3d(tmp_path / "a.c3d", markers, prefix="Anna:")
    assert imported(file, "--marker", "HAND")[0].metadata.body_box is not None
    recording, _ = imported(file, "--marker", "HAND", "--body-markers", "none")
    assert recording.metadata.body_box is None


def test_of_two_backs_one_is_told(imported, tmp_path):
    hand = 500.0 * (HAND - [0.2, 0.0, 0.9])
    backs = {f"{who}:{k}": v for who in "ab" for k, v in body_markers().items()}
    file = write_c3d(tmp_path / "a.c3d", {"HAND": hand, **backs})
    said = imported(file, "--marker", "HAND")[1]
    assert "found 2 markers 'RSHO'; say which with --body-markers" in said
    told = ",".join(f"b:{name}" for name in body_markers())
    recording, _ = imported(file, "--marker", "HAND", "--body-markers", told)
    assert recording.metadata.body_box is not None


ANGLES = np.linspace(0.0, 1.5, 80)
AT_MODEL = ("--segment", "hand", "--model")


def test_units_are_those_of_an_mmm_motion_s_root(imported, tmp_path):
    file = write_mmm(tmp_path / "a.xml", mmm_frames(ANGLES, root=(0.0, 0.0, 1.0)))
    model = write_model(tmp_path / "model.xml")
    recording, _ = imported(file, *AT_MODEL, model, "--units", "m")
    assert recording.points[0, 2] == pytest.approx(1.54, abs=1e-6)


def test_the_person_s_motion_is_found_among_those_of_objects(imported, tmp_path):
    file = write_mmm(tmp_path / "a.xml", mmm_frames(ANGLES))
    model = write_model(tmp_path / "model.xml")
    alone, _ = imported(file, *AT_MODEL, model)
    sponge = "<Motion name='sponge'><MotionFrames/></Motion>"
    file.write_text(file.read_text().replace("</MMM>", f"{sponge}</MMM>"))
    recording, _ = imported(file, *AT_MODEL, model)
    np.testing.assert_array_equal(recording.points, alone.points)
    said = imported(file, *AT_MODEL, model, "--motion", "cup")[1]
    assert "say which with --motion; there are: subject, sponge" in said
    file.write_text(
        file.read_text().replace("sponge'>", "b'><JointOrder><Joint/></JointOrder>")
    )
    assert "found 2 motions; say which" in imported(file, *AT_MODEL, model)[1]
    recording, _ = imported(file, *AT_MODEL, model, "--motion", "subject")
    np.testing.assert_array_equal(recording.points, alone.points)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        # As in VirtualRobot, the case of names does not matter.
        ("<Axis x=", "<axis X="),
        ('type="revolute"', 'Type="Revolute"'),
        ("<Child ", "<child "),
    ],
)
def test_the_case_of_a_model_s_tags_does_not_matter(old, new, imported, tmp_path):
    file = write_mmm(tmp_path / "a.xml", mmm_frames(ANGLES))
    model = write_model(tmp_path / "model.xml")
    expected, _ = imported(file, *AT_MODEL, model)
    assert old in MODEL
    model.write_text(MODEL.replace(old, new))
    recording, _ = imported(file, *AT_MODEL, model)
    np.testing.assert_array_equal(recording.points, expected.points)


def test_a_joint_s_offset_turns_it(imported, tmp_path):
    model = write_model(tmp_path / "model.xml")
    file = write_mmm(tmp_path / "a.xml", mmm_frames(ANGLES + 0.4))
    expected, _ = imported(file, *AT_MODEL, model)
    model.write_text(MODEL.replace('"revolute"', '"revolute" offset="0.4"'))
    file = write_mmm(tmp_path / "b.xml", mmm_frames(ANGLES))
    recording, _ = imported(file, *AT_MODEL, model)
    np.testing.assert_allclose(recording.points, expected.points, atol=2e-6)


def test_a_sliding_joint_slides_by_millimetres_whoever_it_is(imported, tmp_path):
    model = tmp_path / "model.xml"
    model.write_text(MODEL.replace("revolute", "prismatic"))
    file = write_mmm(tmp_path / "a.xml", mmm_frames(400.0 * ANGLES))
    model.write_text(model.read_text().replace("Axis x", "TranslationDirection x"))
    recording, _ = imported(file, *AT_MODEL, model)
    np.testing.assert_allclose(recording.points[:, 2], 1.54 + 0.4 * ANGLES, atol=2e-6)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("</Robot>", "<ChildFromRobot/></Robot>", "found childfromrobot"),
        ('<RobotNode name="arm">', '<RobotNode name="hand">', "of one name"),
        ('<Child name="hand"/>', '<Child name="root"/>', "two parents or a loop"),
        ('"revolute"', '"spherical"', "allowed: revolute, prismatic, fixed"),
        ('z="1"/></Joint>', 'z="0"/></Joint>', "the joint's axis is zero"),
        ("<Transform>", "<Transform><DH/>", "found 'dh', allowed: Translation"),
        ("</Robot>", "", "not XML"),
    ],
)
def test_a_model_that_would_mislead_is_refused(old, new, complaint, imported, tmp_path):
    model = tmp_path / "model.xml"
    assert old in MODEL
    model.write_text(MODEL.replace(old, new))
    said = imported(write_mmm(tmp_path / "a.xml", mmm_frames(ANGLES)), *AT_MODEL, model)
    assert complaint in said[1]
    assert "model.xml" in said[1]


@pytest.mark.parametrize("angles", [ANGLES[:1], 0.0 * ANGLES])
def test_mmm_without_a_stroke_is_refused(angles, imported, tmp_path):
    file = write_mmm(tmp_path / "a.xml", mmm_frames(angles))
    model = write_model(tmp_path / "model.xml")
    said = imported(file, *AT_MODEL, model)[1]
    assert "found 1 points" in said or "has no length" in said


def test_millions_of_tags_are_refused_before_they_fill_the_memory(imported, tmp_path):
    (tmp_path / "a.xml").write_bytes(b"<a/>" * 4_000_001)
    assert "tags, allowed: 4000000" in imported(tmp_path / "a.xml")[1]


def test_angles_of_the_second_version_end_with_their_sensor(imported, tmp_path):
    pose = [
        f'<Measurement timestep="{k / 50}"><RootPosition>0 0 1000</RootPosition>'
        "<RootRotation>0 0 0</RootRotation></Measurement>"
        for k in range(60)
    ]
    joints = [
        f'<Measurement timestep="{k / 100}"><JointPosition>{k / 50}</JointPosition>'
        "</Measurement>"
        for k in range(81)
    ]

    def text(times):
        return (
            "<MMM><Motion><ModelProcessorConfig><Height>1.8</Height>"
            "</ModelProcessorConfig><Sensors><Sensor type='ModelPose'><Data>"
            f"{''.join(pose)}</Data></Sensor><Sensor type='Kinematic'><Configuration>"
            "<Joint name='arm'/></Configuration><Data>"
            f"{''.join(times)}</Data></Sensor></Sensors></Motion></MMM>"
        )

    model = write_model(tmp_path / "model.xml")
    (tmp_path / "a.xml").write_text(text(joints))
    recording, said = imported(tmp_path / "a.xml", *AT_MODEL, model)
    # Angles until 0.8 s, poses until 1.18 s: 19 poses have no hand.
    assert recording.t[-1] == pytest.approx(0.8)
    assert "missing:  19 samples" in said
    np.testing.assert_allclose(
        recording.points[:, 0], 0.45 * np.cos(recording.t * 2.0), atol=2e-6
    )
    (tmp_path / "a.xml").write_text(text(joints[::-1]))
    assert (
        "must be finite and increase"
        in imported(tmp_path / "a.xml", *AT_MODEL, model)[1]
    )


@pytest.mark.parametrize(
    ("place", "value"),
    [
        # Of the zip's central directory: version, encryption flag, compression.
        (6, 200),
        (8, 1),
        (10, 99),
    ],
)
def test_an_archive_of_another_kind_is_refused(place, value, imported, tmp_path):
    file = tmp_path / "a.npz"
    np.savez(file, t=T, p=HAND)
    content = bytearray(file.read_bytes())
    content[content.index(b"PK\x01\x02") + place] = value
    file.write_bytes(content)
    assert "not a readable .npz" in imported(file)[1]


def test_a_damaged_stream_is_refused(imported, tmp_path):
    file = tmp_path / "a.npz"
    np.savez_compressed(file, t=T, p=HAND)
    content = bytearray(file.read_bytes())
    content[60:200] = bytes(range(140))
    file.write_bytes(content)
    assert "not a readable .npz" in imported(file)[1]


def test_a_marker_that_is_named_alone_is_not_there(imported, tmp_path):
    file = write_c3d(tmp_path / "a.c3d", {"HAND": 1e3 * HAND, "ELBO": 1e3 * HAND})
    content = bytearray(file.read_bytes())
    # One marker instead of two: in the header, and in the parameter POINT:USED (its
    # name, two bytes to the next, a type, no dimensions, the number).
    content[2] = 1
    content[content.index(b"USED") + 8] = 1
    file.write_bytes(content)
    assert "found no marker 'ELBO'" in imported(file, "--marker", "ELBO")[1]
