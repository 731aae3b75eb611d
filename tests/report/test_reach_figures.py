"""The reach's pictures, and the files that `bath-drake reach` leaves."""

import json

import numpy as np
import pytest

from bath_drake import cli
from bath_drake.errors import ScenarioError
from bath_drake.reach import precheck
from bath_drake.reach.judge import Cause, Places
from bath_drake.reach.over_back import grid
from bath_drake.reach.placement import Placement, PlacementMap
from bath_drake.reach.precheck import Reachability
from bath_drake.report import style
from bath_drake.report.reach_figures import draw_placement, draw_reachability
from bath_drake.safety.limits import GuardLimits
from bath_drake.scenario import load_scenario
from bath_drake.strokes import scenario_skill


def places(p_N):
    """Made up: the farther from the middle, the worse; above, not reached."""
    n = len(p_N)
    away = np.hypot(*p_N.T)
    cause = np.where(p_N[:, 1] > 0.7, Cause.SINGULAR, Cause.NONE)
    return Places(
        p_N=p_N,
        condition=10.0 + 20.0 * away,
        margin=np.maximum(0.8 - away, 0.1),
        self_distance=np.full(n, 0.1),
        obstacle_distance=np.full(n, 0.1),
        place_error=np.zeros(n),
        elbow=np.full(n, -1.5),
        cause=cause,
    )


@pytest.fixture(scope="module")
def found():
    here = Placement(np.array([0.0, 0.0, 0.2]), 0.1, 0.5, 40.0, 0.1)
    best = Placement(np.array([0.1, 0.0, 0.4]), 0.1, 1.0, 12.0, 0.1)
    x = y = np.array([0.0, 0.1])
    share = np.array([[0.2, 0.4], [np.nan, 0.8]])
    plan = PlacementMap(x, y, 0.4, 0.1, share, share, here, best)
    path = places(np.array([[0.0, 0.0], [0.1, 0.8]]))
    back = places(grid().reshape(-1, 2))
    return Reachability(path, path, back, here, best, plan, GuardLimits())


@pytest.mark.parametrize("draw", [draw_reachability, draw_placement])
def test_the_same_is_drawn_again(found, draw):
    with style.figure_style():
        first, again = (style.as_data_uri(draw(found)) for _ in range(2))
    assert first == again


def test_what_was_not_asked_for_is_not_drawn(found):
    without = Reachability(found.path, found.rest, None, None, None, None, found.limits)
    assert draw_reachability(without) is None
    assert draw_placement(without) is None
    assert len(without.lines()) == 1


def test_it_is_told_what_is_not_reached_and_from_where_it_would_be(found):
    first, second = found.lines()
    assert first.endswith("reached; from (0.10, 0.80) to (0.10, 0.80) singular")
    assert "yaw 0.10, 100 % of the path would be reached" in second


@pytest.mark.slow
def test_the_verb_leaves_its_files_and_says_by_its_code_whether_all_is_reached(
    tmp_path, capsys
):
    scenario = tmp_path / "still.yaml"
    scenario.write_text(
        "scene: {motion: {twist_amplitude: 0.0, lean_amplitude: 0.0}}\n"
    )
    out = tmp_path / "out"
    assert cli.main(["reach", str(scenario), "--out", str(out)]) == 0
    assert "the whole path is reached" in capsys.readouterr().out
    assert sorted(path.name for path in out.iterdir()) == [
        "base.svg",
        "reach.json",
        "reach.svg",
    ]
    assert json.loads((out / "reach.json").read_text())["path"]["reached"]


def test_where_a_carer_washes_there_is_nothing_to_reach(capsys):
    assert cli.main(["reach", "demonstration"]) == 2
    assert "a carer washes here" in capsys.readouterr().err


def test_the_verb_judges_the_lanes_that_are_washed(monkeypatch, capsys):
    seen = {}

    def looked(scenario, skill, **choices):
        seen["skill"] = skill
        raise ScenarioError("seen")

    monkeypatch.setattr(precheck, "reachability", looked)
    assert cli.main(["reach", "coverage"]) == 2
    assert "seen" in capsys.readouterr().err
    assert len(seen["skill"].chain.fields) == len(
        scenario_skill(load_scenario("coverage")).chain.fields
    )
    assert len(seen["skill"].chain.fields) > 6
