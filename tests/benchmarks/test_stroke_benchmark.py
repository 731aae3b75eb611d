import json
import sys

import numpy as np
import pytest
from scipy.io import savemat

from bath_drake import cli
from bath_drake.benchmarks import strokes
from bath_drake.benchmarks.figures import Settings
from bath_drake.benchmarks.methods import mean_demonstration
from bath_drake.benchmarks.peers import peers
from bath_drake.benchmarks.shape_files import stroke_shapes
from bath_drake.demonstrations.strokes import STROKES
from bath_drake.errors import BathDrakeError
from bath_drake.resources import models_folder

SUMMARY = (
    "frechet_median",
    "frechet_mean",
    "frechet_max",
    "goal_share",
    "proved_share",
    "obstacles_median",
    "fit_seconds_median",
    "roll_out_seconds_median",
)


def silent(what, share):
    assert 0.0 <= share <= 1.0


@pytest.fixture
def fast(monkeypatch):
    """Instead of the learner, something that takes no time."""
    monkeypatch.setattr(strokes, "learner", lambda config: mean_demonstration)


@pytest.fixture(scope="module")
def shipped():
    """The shapes of all shipped strokes, which take seconds to read and denoise."""
    return stroke_shapes(models_folder() / "demonstrations" / "strokes")


@pytest.fixture
def lasa_folder(tmp_path):
    share = np.linspace(0.0, 1.0, 50)
    for name, bend in (("Bent", 8.0), ("Flat", 1.0)):
        cells = np.empty((1, 2), dtype=object)
        for i in range(2):
            pos = np.stack([40.0 * share, (bend + i) * np.sin(np.pi * share)])
            cells[0, i] = {"pos": pos, "t": share[None]}
        savemat(tmp_path / f"{name}.mat", {"demos": cells})
    return tmp_path


def test_two_simple_strokes_are_learned_and_proved(capsys, tmp_path):
    words = ["bench", "strokes", "--quick", "--shapes", "arc_shallow,line_across"]
    assert cli.main([*words, "--json", str(tmp_path / "s.json")]) == 0
    found = json.loads((tmp_path / "s.json").read_text(encoding="utf-8"))
    rows = [(row["shape"], row["method"]) for row in found["rows"]]
    methods = ("bath_drake", "one_field")
    shapes = ("arc_shallow", "line_across")
    assert rows == [(shape, method) for shape in shapes for method in methods]
    for row in found["rows"]:
        assert row["goal"] == row["proved"] == 1.0
        # Both are nearly straight: the straight line itself is within 0.2.
        assert row["frechet"] < 0.1
    for name in SUMMARY:
        assert np.isfinite(found["figures"][name]["value"])
        # A few strokes at little effort are held to nothing.
        assert found["figures"][name]["target"] is None
    out = capsys.readouterr().out
    assert "arc_shallow" in out
    assert "frechet_median" in out


def test_all_shipped_strokes_are_shapes(shipped):
    takes = {shape.name: len(shape.demonstrations) for shape in shipped}
    assert takes == {stroke.name: stroke.takes for stroke in STROKES}
    crossing = {shape.name for shape in shipped if shape.crosses_itself}
    # Closed rounds may or may not meet their beginning.
    assert crossing - {"circle", "oval"} == {"figure_eight", "loop", "loops", "ribbon"}


def test_a_whole_run_is_held_to_the_targets(fast, shipped, monkeypatch):
    monkeypatch.setattr(strokes, "stroke_shapes", lambda folder, wanted: shipped)
    report = strokes.run_strokes(Settings(), silent)
    assert len(report.rows) == 2 * 30
    targets = {f.name: f.target for f in report.figures if f.target is not None}
    assert targets == {
        "goal_share": 1.0,
        "proved_share": 1.0,
        "obstacles_median": 12.0,
        "fit_seconds_median": 15.0,
        "one_field_goal_share": 1.0,
        "one_field_proved_share": 1.0,
        "one_field_fit_seconds_median": 5.0,
        "sine_to_mean": 0.010,
        "zigzag_long_to_mean": 0.040,
        "figure_eight_frechet": 0.050,
    }


def test_lasa_has_targets_of_its_own(fast, lasa_folder):
    report = strokes.run_lasa(Settings(data=lasa_folder), silent)
    targets = {f.name: f.target for f in report.figures}
    assert [row["shape"] for row in report.rows] == ["Bent", "Bent", "Flat", "Flat"]
    assert targets["frechet_median"] == targets["frechet_mean"] == 0.035
    assert targets["frechet_max"] == 0.060
    assert targets["one_field_uncrossed_frechet_median"] == 0.080


def test_held_out_figures_are_called_so(fast, lasa_folder):
    report = strokes.run_lasa(Settings(data=lasa_folder, held_out=True), silent)
    targets = {f.name: f.target for f in report.figures}
    assert targets["held_out_frechet_median"] == 0.045
    assert "frechet_median" not in targets
    # Of a chain's few stages more can be left out than of a single field's search.
    assert [row["method"] for row in report.rows] == 2 * ["bath_drake"]


def test_a_missing_library_is_named_with_the_line_that_installs_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "movement_primitives.dmp", None)
    with pytest.raises(BathDrakeError) as caught:
        strokes.run_strokes(Settings(peers=True), silent)
    assert "movement_primitives" in str(caught.value)
    assert "pip install movement-primitives pytransform3d" in str(caught.value)


@pytest.mark.peers
def test_peers_are_run_on_the_same_shapes(fast, lasa_folder):
    settings = Settings(data=lasa_folder, peers=True, quick=True)
    report = strokes.run_lasa(settings, silent)
    names = ["bath_drake", "one_field", *peers()]
    assert [row["method"] for row in report.rows] == 2 * names
    figures = {f.name: f.value for f in report.figures}
    for name in peers():
        # The paper's learner promises nothing, least of all when it is quick.
        assert figures[f"{name}_goal_share"] >= (0.0 if name == "paper" else 1.0)
    # What follows a clock has no trouble with one bend.
    assert figures["dmp_frechet_max"] < 0.05
    assert figures["promp_frechet_max"] < 0.05


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("lasa",), "lasa: --data DIR is needed"),
        (("lasa", "--data", "."), "--data: no .mat file in "),
        (("strokes", "--data", "."), "strokes: --data is none of its options"),
        (("strokes", "--shapes", "w,,w"), "--shapes: found 'w,,w', expected NAME"),
        (("strokes", "--shapes", "v"), "--shapes: found 'v', allowed: arc_half"),
    ],
)
def test_bad_input_is_one_line(capsys, tmp_path, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["bench", *words]) == cli.BAD_INPUT
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert err.count("\n") == 1
