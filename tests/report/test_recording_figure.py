"""`bath-drake show`: one picture and a few lines for any number of demonstrations."""

import numpy as np
import pytest

from bath_drake.cli import main
from bath_drake.demonstrations.hand_motion import hand_motion
from bath_drake.demonstrations.recording import read_recording
from bath_drake.resources import models_folder

FOLDER = models_folder() / "demonstrations"


def test_what_files_hold_is_told_and_drawn(tmp_path, capsys):
    files = [str(FOLDER / f"scrubbing_{k}.csv") for k in (1, 2)]
    picture = tmp_path / "demos.png"
    assert main(["show", *files, "-o", str(picture)]) == 0
    said = capsys.readouterr().out
    assert "841 points in 14.00 s" in said
    assert "periodic: 12.5 cycles of 1.12 s" in said
    assert "body box 40.0 x 50.0 cm" in said
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_gaps_outliers_and_ways_are_told(tmp_path, capsys):
    t = np.arange(60) / 20.0
    rows = np.column_stack([t, 0.1 * t, 0.02 * np.sin(t)])
    rows[30, 1:] += [0.1, 0.1]
    for name, table in (("there", rows), ("back", rows * [1.0, -1.0, 1.0])):
        lines = [",".join(map(str, row)) for row in table]
        (tmp_path / f"{name}.csv").write_text("\n".join(["t,x,y", *lines]))
    (tmp_path / "there.yaml").write_text("gaps: [[1.0, 1.3]]\n")
    files = [str(tmp_path / "there.csv"), str(tmp_path / "back.csv")]
    assert main(["show", *files, "-o", str(tmp_path / "p.svg")]) == 0
    said = capsys.readouterr().out
    assert "1 outliers, left out (at 1.50 s)" in said
    assert "gap from 1.00 to 1.30 s" in said
    assert "ways:    2: there; back" in said


def test_bad_input_is_refused_and_nothing_is_written(tmp_path, capsys):
    file = str(FOLDER / "scrubbing_1.csv")
    assert main(["show", file, "-o", str(tmp_path / "p.txt")]) == 2
    assert "expected a name that ends in .png, .svg, .pdf" in capsys.readouterr().err
    assert main(["show", "none.csv", "-o", str(tmp_path / "p.png")]) == 2
    assert list(tmp_path.iterdir()) == []


def test_the_speed_of_an_even_line_is_even(tmp_path):
    path = tmp_path / "line.csv"
    lines = [f"{k / 20},{k / 100},0" for k in range(50)]
    path.write_text("\n".join(["t,x,y", *lines]))
    motion = hand_motion(read_recording(path))
    # The spline's solver leaves rounding.
    np.testing.assert_allclose(motion.speed, 0.2, rtol=1e-6)
    assert motion.length == pytest.approx(0.49, rel=1e-6)


@pytest.mark.parametrize("radius", [0.0, 0.03])
def test_noise_makes_no_stroke_longer_or_faster(radius, tmp_path):
    t = np.arange(240) / 30.0
    turn = radius * np.column_stack([np.cos(6.0 * t), np.sin(6.0 * t)])
    hand = np.column_stack([0.15 * np.sin(0.6 * t), 0.2 - 0.05 * t]) + turn
    noisy = hand + np.random.default_rng(5).normal(0.0, 0.002, hand.shape)
    path = tmp_path / "noisy.csv"
    lines = [",".join(map(str, row)) for row in np.column_stack([t, noisy])]
    path.write_text("\n".join(["t,x,y", *lines]))
    motion = hand_motion(read_recording(path))
    truth = np.linalg.norm(np.diff(hand, axis=0), axis=1).sum()
    # A tenth: with noise alone it is 1.3 to 1.9 times as long.
    assert motion.length == pytest.approx(truth, rel=0.1)
    speed = np.linalg.norm(np.gradient(hand, t, axis=0), axis=1)
    assert np.median(motion.speed) == pytest.approx(np.median(speed), rel=0.1)
