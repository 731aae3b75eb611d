import numpy as np
import pytest

from bath_drake.demonstrations import strokes
from bath_drake.demonstrations.processing import canonical_demonstrations
from bath_drake.demonstrations.recording import read_recording
from bath_drake.demonstrations.strokes import STROKES, main, make_take, write_strokes
from bath_drake.resources import models_folder

SHIPPED = models_folder() / "demonstrations" / "strokes"


def test_the_shipped_strokes_are_made_again_bit_by_bit(tmp_path, capsys):
    assert main([str(tmp_path)]) == 0
    made = sorted(path.name for path in tmp_path.iterdir())
    assert made == sorted(p.name for p in SHIPPED.iterdir() if p.name != "README.md")
    assert len(made) == 2 * sum(stroke.takes for stroke in STROKES)
    for name in made:
        assert (tmp_path / name).read_bytes() == (SHIPPED / name).read_bytes()
    assert str(tmp_path) in capsys.readouterr().out


def test_another_seed_makes_other_strokes(tmp_path):
    for path in write_strokes(tmp_path, seed=1):
        assert path.read_bytes() != (SHIPPED / path.name).read_bytes()


@pytest.mark.parametrize("arguments", [[], ["absent_folder"], [".", "."]])
def test_anything_but_one_folder_is_a_wrong_call(arguments, capsys):
    assert main(arguments) == 2
    assert "usage" in capsys.readouterr().err


def test_there_are_two_dozen_strokes_of_three_to_seven_takes():
    assert len({stroke.name for stroke in STROKES}) == len(STROKES) >= 24
    assert all(3 <= stroke.takes <= 7 for stroke in STROKES)


@pytest.mark.parametrize("stroke", STROKES, ids=lambda stroke: stroke.name)
def test_takes_of_a_stroke_are_alike_and_of_the_size_of_a_back(stroke):
    paths = sorted(SHIPPED.glob(f"{stroke.name}_[0-9].csv"))
    recordings = [read_recording(path) for path in paths]
    assert len(recordings) == stroke.takes
    for recording in recordings:
        assert recording.metadata.synthetic
        assert recording.metadata.who == "nobody: synthetic"
        assert recording.metadata.licence == "CC0-1.0"
        assert recording.metadata.seed == strokes.SEED
        assert 100 <= len(recording.t) <= 150
        # Meant sizes are 0.36..0.46 m, a take's own is stretched by 5 %, twice
        # that at times.
        assert 0.3 <= np.ptp(recording.points, axis=0).max() <= 0.55
    demonstrations, frame = canonical_demonstrations(recordings)
    mean = np.mean([d.points for d in demonstrations], axis=0)
    for demonstration in demonstrations:
        apart = np.linalg.norm(demonstration.points - mean, axis=1) * frame.scales[0]
        # A carer repeats a stroke to a few centimetres, and never exactly.
        assert 0.001 < apart.max() < 0.08


def test_a_hand_starts_and_ends_at_rest_and_slows_in_bends():
    stroke = next(s for s in STROKES if s.name == "chevron")
    t, points = make_take(stroke, np.random.default_rng(0))
    speed = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(t)
    smooth = np.convolve(speed, np.full(7, 1 / 7), mode="valid")
    quarter, bend = len(smooth) // 4, len(smooth) // 2
    around_bend = smooth[bend - 15 : bend + 15].min()
    fastest = smooth[quarter : 3 * quarter].max()
    # The noise of the sensor alone moves at a few centimetres a second.
    assert smooth[0] < 0.3 * fastest
    assert smooth[-1] < 0.3 * fastest
    assert around_bend < 0.8 * fastest


def test_the_meant_figure_eight_crosses_itself_once():
    stroke = next(s for s in STROKES if s.name == "figure_eight")
    points, _ = strokes.meant_curve(stroke)
    a, step = points[:-1:20], np.diff(points[::20], axis=0)
    offset = a[None] - a[:, None]

    def cross(u, v):
        return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]

    with np.errstate(divide="ignore", invalid="ignore"):
        along = cross(offset, step[None]) / cross(step[:, None], step[None])
        other = cross(offset, step[:, None]) / cross(step[:, None], step[None])
    hits = (along >= 0) & (along < 1) & (other >= 0) & (other < 1)
    assert np.triu(hits, 2).sum() == 1
