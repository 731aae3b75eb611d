import numpy as np
import pytest

from bath_drake.demonstrations.processing import (
    arc_length_mean,
    canonical_demonstrations,
)
from bath_drake.demonstrations.recording import read_recording
from bath_drake.demonstrations.synthetic import TAKES, main, write_demonstrations
from bath_drake.resources import models_folder

SHIPPED = models_folder() / "demonstrations"


def test_the_shipped_strokes_are_made_again_bit_by_bit(tmp_path, capsys):
    assert main([str(tmp_path)]) == 0
    made = sorted(path.name for path in tmp_path.iterdir())
    assert made == sorted(path.name for path in SHIPPED.glob("back_sinusoid_*"))
    assert len(made) == 2 * len(TAKES)
    for name in made:
        assert (tmp_path / name).read_bytes() == (SHIPPED / name).read_bytes()
    assert len(capsys.readouterr().out.splitlines()) == len(TAKES)


def test_another_seed_makes_other_strokes(tmp_path):
    for path in write_demonstrations(tmp_path, seed=1):
        assert path.read_bytes() != (SHIPPED / path.name).read_bytes()


@pytest.mark.parametrize("arguments", [[], ["absent_folder"], [".", "."]])
def test_anything_but_one_folder_is_a_wrong_call(arguments, capsys):
    assert main(arguments) == 2
    assert "usage" in capsys.readouterr().err


def test_the_shipped_strokes_say_that_they_are_synthetic():
    for path in SHIPPED.glob("back_sinusoid_*.csv"):
        metadata = read_recording(path).metadata
        assert metadata.synthetic
        assert metadata.seed is not None
        assert "bath_drake.demonstrations.synthetic" in metadata.generator
        assert metadata.licence == "CC0-1.0"


def test_the_strokes_lie_well_on_the_back_and_near_each_other():
    paths = sorted(SHIPPED.glob("back_sinusoid_*.csv"))
    demonstrations, frame = canonical_demonstrations([read_recording(p) for p in paths])
    assert frame.kind == "body_box"
    for d in demonstrations:
        assert np.all(np.max(np.abs(d.points), axis=0) <= [0.72, 0.38])
    # Ends are scattered by 4 mm in each direction, so 6 mm; the tremor adds 1 mm.
    starts_m = (
        np.array([d.points[0] + d.goal_offset for d in demonstrations]) * frame.scales
    )
    assert 1e-3 < np.max(np.linalg.norm(starts_m - starts_m[0], axis=1)) < 0.013
    mean = arc_length_mean(demonstrations)
    turns = np.diff(np.sign(np.diff(mean[:, 1])))
    # 1.5 periods: up, down, up, down again, with three turning points.
    assert np.count_nonzero(turns) == 3
