"""Other programs' files become demonstrations, or are refused by name."""

import numpy as np
import pytest
from foreign_files import (
    CORNERS,
    HAND,
    T,
    body_markers,
    mmm_frames,
    write_c3d,
    write_csv,
    write_mmm,
    write_model,
)
from scipy.spatial.transform import Rotation

from bath_drake.cli import main
from bath_drake.demonstrations.processing import canonical_demonstrations


def close(recording, t=T, points=HAND):
    # Six digits are written.
    np.testing.assert_allclose(recording.t, t - t[0], atol=1e-6)
    np.testing.assert_allclose(recording.points, points, atol=2e-6)


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize(
    "header",
    ["time,px,py,pz", "t_s,x_m,y_m,z_m", "Timestamp (s),Hand X,Hand Y,Hand Z"],
)
def test_a_table_is_read_by_its_names(header, delimiter, imported, tmp_path):
    file = write_csv(tmp_path / "a.csv", header, delimiter=delimiter)
    recording, said = imported(file)
    close(recording)
    assert "csv, columns" in said
    assert "a.csv" in recording.metadata.source


def test_columns_are_told_where_names_leave_a_choice(imported, tmp_path):
    rows = np.column_stack([T, HAND, HAND + 1.0])
    file = write_csv(tmp_path / "a.csv", "time,ax,ay,az,bx,by,bz", rows)
    recording, said = imported(file)
    assert recording is None
    assert "--x, --y and --z; there are: time, ax, ay, az, bx, by, bz" in said
    recording, _ = imported(file, "--x", "bx", "--y", "by", "--z", "bz")
    close(recording, points=HAND + 1.0)


def test_units_stand_in_names_or_are_told(imported, tmp_path):
    rows = np.column_stack([1e3 * T, 1e3 * HAND])
    file = write_csv(tmp_path / "a.csv", "t_ms,x_mm,y_mm,z_mm", rows)
    close(imported(file)[0])
    file = write_csv(tmp_path / "b.csv", "t,x,y,z", rows)
    recording, said = imported(file)
    assert recording is None
    assert "millimetres? then --units mm" in said
    close(imported(file, "--units", "mm", "--time-units", "ms")[0])


def test_arrays_of_an_npz_are_found(imported, tmp_path):
    file = tmp_path / "a.npz"
    np.savez(file, time=T, hand=HAND, force=np.zeros(len(T)))
    close(imported(file)[0])
    np.savez(file, stamp=1e9 * T, hand=HAND, other=HAND)
    recording, said = imported(file)
    assert recording is None
    assert "x, y and z by their names" in said
    close(imported(file, "--points", "hand", "--time-units", "ns")[0])


def test_planar_tables_are_planar_demonstrations(imported, tmp_path):
    file = write_csv(tmp_path / "a.csv", "t,x,y", np.column_stack([T, HAND[:, :2]]))
    close(imported(file)[0], points=HAND[:, :2])


def test_a_stretch_of_time_is_taken_out(imported, tmp_path):
    file = write_csv(tmp_path / "a.csv")
    recording, _ = imported(file, "--start", "0.5", "--end", "1.5")
    assert recording.t[-1] == pytest.approx(1.0, abs=1e-5)


def test_a_marker_of_a_c3d_is_read(imported, tmp_path):
    file = write_c3d(tmp_path / "a.c3d", {"HAND": 1e3 * HAND, "HEAD": 1e3 * HAND})
    recording, said = imported(file, "--marker", "HAND")
    # Single precision.
    np.testing.assert_allclose(recording.points, HAND, atol=2e-6)
    assert recording.metadata.body_box is None
    recording, said = imported(file)
    assert recording is None
    assert "--marker; there are: HAND, HEAD" in said
    assert "no marker 'FOOT'" in imported(file, "--marker", "FOOT")[1]


def test_the_subject_s_name_may_stand_before_a_marker_s(imported, tmp_path):
    file = write_c3d(tmp_path / "a.c3d", {"HAND": 1e3 * HAND}, prefix="Anna:")
    assert imported(file, "--marker", "HAND")[0] is not None


def test_on_a_moving_body_the_stroke_is_the_body_s(imported, tmp_path):
    count = len(T)
    turn = Rotation.from_euler(
        "xyz", np.column_stack([0.3 * T, 0.1 * T, 0.5 * np.sin(T)])
    ).as_matrix()
    move = np.column_stack([0.2 * T, -0.1 * T, 1.0 + 0.05 * T])
    on_back = np.column_stack(
        [np.linspace(-0.1, 0.1, count), 0.1 * np.sin(3 * T), np.full(count, 0.02)]
    )
    hand = np.einsum("nij,nj->ni", turn, on_back) + move
    markers = {"HAND": 1e3 * hand, **body_markers(turn, move)}
    recording, said = imported(
        write_c3d(tmp_path / "a.c3d", markers), "--marker", "HAND"
    )
    np.testing.assert_allclose(recording.points, on_back, atol=1e-5)
    box = recording.metadata.body_box
    assert box.extents.tolist() == pytest.approx([0.4, 0.5], abs=1e-5)
    assert "body:     40.0 x 50.0 cm" in said
    (demonstration,), frame = canonical_demonstrations([recording])
    assert frame.kind == "body_box"
    assert demonstration.points[0, 0] == pytest.approx(-0.5, abs=0.02)


def test_body_markers_of_other_names_are_told(imported, tmp_path):
    names = dict(zip(CORNERS, "ABCD", strict=True))
    own = {names[k]: v for k, v in body_markers().items()}
    # On the back, not beside it.
    hand = 500.0 * (HAND - [0.2, 0.0, 0.9])
    file = write_c3d(tmp_path / "a.c3d", {"HAND": hand, **own})
    recording, _ = imported(file, "--marker", "HAND", "--body-markers", "A,B,C,D")
    assert recording.metadata.body_box is not None
    said = imported(file, "--marker", "HAND", "--body-markers", "A,B,C")[1]
    assert "expected four names" in said


def test_short_gaps_are_filled_and_long_ones_told(imported, tmp_path):
    hand = 1e3 * HAND
    hand[10:14] = np.nan
    hand[30:40] = np.nan
    file = write_c3d(tmp_path / "a.c3d", {"HAND": hand})
    recording, said = imported(file, "--marker", "HAND")
    # Four samples of 1/30 s are filled, ten are not.
    assert len(recording.t) == len(T) - 10
    np.testing.assert_allclose(recording.points[:30], HAND[:30], atol=2e-4)
    assert recording.metadata.gaps == (
        (pytest.approx(29 / 30, abs=1e-5), pytest.approx(40 / 30, abs=1e-5)),
    )
    assert said.count("s: filled") == 1
    assert said.count("s: LEFT OPEN") == 1
    assert "missing:  14 samples" in said


def test_the_hand_of_an_mmm_motion_is_found_by_the_model(imported, tmp_path):
    angles = np.linspace(0.0, 1.5, 80)
    file = write_mmm(tmp_path / "a.xml", mmm_frames(angles, rpy=(0.0, 0.0, 0.5)))
    model = write_model(tmp_path / "model.xml")
    recording, _ = imported(file, "--model", model, "--segment", "hand")
    # 0.25 m and 0.3 m of a subject of 1 m, who is 1.8 m tall and turned by 0.5.
    turned = angles + 0.5
    expected = np.column_stack(
        [
            0.45 * np.cos(turned),
            0.45 * np.sin(turned),
            np.full(len(angles), 1.0 + 0.54),
        ]
    )
    np.testing.assert_allclose(recording.points, expected, atol=2e-6)
    np.testing.assert_allclose(recording.t, np.arange(80) / 100, atol=1e-6)


def test_the_second_version_of_mmm_is_read_too(imported, tmp_path):
    rows = [
        f'<Measurement timestep="{k / 50}"><RootPosition>{10 * k} 0 900</RootPosition>'
        f"<RootRotation>0 0 0</RootRotation></Measurement>"
        for k in range(40)
    ]
    file = tmp_path / "a.xml"
    file.write_text(
        "<MMM version='2.0'><Motion><Sensors><Sensor type='ModelPose'><Data>"
        f"{''.join(rows)}</Data></Sensor></Sensors></Motion></MMM>"
    )
    recording, _ = imported(file, "--segment", "root")
    np.testing.assert_allclose(recording.points[:, 0], 0.01 * np.arange(40), atol=1e-6)


def test_without_a_model_an_mmm_motion_tells_the_root_alone(imported, tmp_path):
    file = write_mmm(tmp_path / "a.xml", mmm_frames(np.linspace(0, 1, 50)))
    assert "takes the kinematics" in imported(file, "--segment", "hand")[1]
    assert "--segment root" in imported(file)[1]
    model = write_model(tmp_path / "model.xml")
    said = imported(file, "--model", model, "--segment", "foot")[1]
    assert "found 'foot'; allowed: root, arm, hand" in said


BOMB = '<!DOCTYPE b [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]>'


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda text: BOMB + text, "declares entities or a document type"),
        (lambda text: text[: len(text) // 2], "not XML"),
        (lambda text: text.replace("<Height>1.8</Height>", ""), "tells no Height"),
        (lambda text: text.replace("name='arm'", "name='leg'"), "no angles of joint"),
        (lambda text: text.replace("</Timestep>", "x</Timestep>"), "Timestep: found"),
        (lambda text: text.replace("<RootPosition>0.0", "<RootPosition>nan"), "finite"),
        (lambda text: text.replace("0.0 0.0 1000.0", "0.0 1000.0"), "found 2 numbers"),
        (lambda text: text.replace("MotionFrames", "Frames"), "no MMM file"),
        (lambda text: text.replace("0.010<", "0.000<"), "comes twice"),
    ],
)
def test_damaged_mmm_is_refused_by_name(change, complaint, imported, tmp_path):
    file = write_mmm(tmp_path / "a.xml", mmm_frames(np.linspace(0, 1, 50)))
    file.write_text(change(file.read_text()))
    model = write_model(tmp_path / "model.xml")
    recording, said = imported(file, "--model", model, "--segment", "hand")
    assert recording is None
    assert complaint in said
    assert "a.xml" in said


def rows_with(change):
    rows = np.column_stack([T, HAND])
    change(rows)
    return rows


def set_to(k, column, value):
    def change(rows):
        rows[k, column] = value

    return change


@pytest.mark.parametrize(
    ("rows", "complaint"),
    [
        (rows_with(set_to(7, 0, T[6])), "line 9: time 0.2 s comes twice"),
        (rows_with(set_to(7, 0, 0.1)), "line 9: time 0.1 s follows 0.2 s"),
        (rows_with(set_to(7, 0, np.nan)), "line 9: found time nan"),
        (np.column_stack([T, HAND])[:1], "found 1 points, at least 5"),
        (np.column_stack([T, 0.0 * HAND]), "the path has no length"),
        (np.column_stack([T, 1000.0 * HAND]), "millimetres? then --units mm"),
        (np.column_stack([1e-3 * T, HAND]), "m/s are allowed"),
        (np.column_stack([T, np.nan * HAND]), "found 0 points"),
    ],
)
def test_damaged_tables_are_refused_by_name(rows, complaint, imported, tmp_path):
    recording, said = imported(write_csv(tmp_path / "a.csv", rows=rows))
    assert recording is None
    assert complaint in said


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", "found 0 lines"),
        (b"t,x,y\n0,1\n", "line 2: found 2 values, expected 3"),
        (b"t,x,y\n0,1,one\n", "line 2: found 'one'"),
        (b"t,x,x\n0,1,2\n", "'x' is there twice"),
        (b"a,x,y\n0,1,2\n", "no column that are the time"),
        (b"t,x\xff,y\n0,1,2\n", "not UTF-8"),
        (b"t,x,y\n0,1\x00,2\n", "binary data"),
    ],
)
def test_what_is_no_table_is_refused_by_name(content, complaint, imported, tmp_path):
    file = tmp_path / "a.csv"
    file.write_bytes(content)
    assert complaint in imported(file)[1]


def test_a_damaged_npz_is_refused_by_name(imported, tmp_path):
    file = tmp_path / "a.npz"
    np.savez(file, t=T, x=HAND[:, 0], y=HAND[:-1, 1])
    assert "arrays of unlike lengths: t 60, x 60, y 59" in imported(file)[1]
    file.write_bytes(file.read_bytes()[:200])
    assert "not a readable .npz" in imported(file)[1]
    np.savez(file, t=np.array(["a"], dtype=object), allow_pickle=True)
    assert "not a readable .npz" in imported(file)[1]


def test_a_damaged_c3d_is_refused_by_name(imported, tmp_path):
    file = write_c3d(tmp_path / "a.c3d", {"HAND": 1e3 * HAND})
    content = file.read_bytes()
    file.write_bytes(content[: len(content) - 600])
    assert "truncated: 60 frames of 1 markers" in imported(file, "--marker", "HAND")[1]
    for damage in (b"", b"no such thing", content[:700], b"\x02\x50" + bytes(2000)):
        file.write_bytes(damage)
        recording, said = imported(file, "--marker", "HAND")
        assert recording is None
        assert "a.c3d" in said
    metres = write_c3d(tmp_path / "b.c3d", {"HAND": 1e3 * HAND}, unit="m")
    assert "millimetres?" in imported(metres, "--marker", "HAND")[1]
    furlongs = write_c3d(tmp_path / "c.c3d", {"HAND": 1e3 * HAND}, unit="furlong")
    assert "found the unit 'furlong'" in imported(furlongs, "--marker", "HAND")[1]


def test_what_is_not_there_or_of_no_kind_is_refused(imported, tmp_path):
    assert "no such file" in imported(tmp_path / "none.csv")[1]
    odd = tmp_path / "a.odd"
    odd.write_text("")
    assert "say which with --format: csv, npz, c3d, mmm, bag" in imported(odd)[1]


def test_an_import_does_not_write_over_its_source(tmp_path, capsys):
    file = write_csv(tmp_path / "a.csv")
    before = file.read_bytes()
    assert main(["import", str(file), "-o", str(file)]) == 2
    assert "is the file that is imported" in capsys.readouterr().err
    assert file.read_bytes() == before
