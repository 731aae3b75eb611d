"""A scenario's strokes as one skill."""

import numpy as np
import pytest

from bath_drake.composition.chain import Chain
from bath_drake.composition.stroke_config import LanesConfig, StrokeConfig
from bath_drake.errors import ScenarioError
from bath_drake.scenario import Scenario, load_scenario
from bath_drake.skill_file import load_skill, save_skill
from bath_drake.strokes import (
    is_strung,
    planned_strokes,
    scenario_skill,
    string_strokes,
)


@pytest.fixture(scope="module")
def coverage():
    return load_scenario("coverage")


@pytest.fixture(scope="module")
def whole_back(coverage):
    return scenario_skill(coverage)


def test_a_scenario_without_strokes_keeps_its_skill(whole_back):
    assert planned_strokes(Scenario()) == []
    assert string_strokes(Scenario(), whole_back) is whole_back
    assert is_strung(whole_back)
    assert not is_strung(scenario_skill(Scenario()))


def test_the_lanes_of_the_shipped_scenario_are_one_proved_skill(coverage, whole_back):
    strokes = planned_strokes(coverage)
    assert len(strokes) == 6
    assert len(whole_back.chain) == 11
    assert whole_back.certificate["verdict"] == "proved"
    np.testing.assert_array_equal(whole_back.start, strokes[0].start)
    np.testing.assert_array_equal(whole_back.chain.goal, strokes[-1].goal)
    # Its plan goes over all of the lanes, a jet's radius within the target.
    path = whole_back.mean_demonstration
    assert np.abs(np.ptp(path, axis=0) - [1.16, 0.9]).max() < 0.05
    assert (
        whole_back.demonstration_hashes
        == scenario_skill(Scenario(skill=coverage.skill)).demonstration_hashes
    )


def test_written_and_read_again_it_is_not_strung_twice(coverage, whole_back, tmp_path):
    path = tmp_path / "skill.yaml"
    save_skill(path, whole_back)
    again = load_skill(path)
    assert again.chain == whole_back.chain
    assert string_strokes(coverage, again) is again
    assert scenario_skill(coverage, path).chain == whole_back.chain


def test_each_stroke_may_have_a_skill_of_its_own():
    scenario = Scenario(skill="line_across.yaml")
    scenario.strokes = [
        StrokeConfig(start=[-0.6, 0.3], goal=[0.6, 0.3]),
        StrokeConfig(start=[0.6, 0.0], goal=[-0.6, 0.0], skill="back_sinusoid.yaml"),
    ]
    skill = scenario_skill(scenario)
    assert len(skill.chain) == 3
    assert skill.certificate["verdict"] == "proved"
    assert len(skill.demonstration_hashes) == 6
    # The second one swings as the sinusoid does, on both sides.
    last = skill.mean_demonstration[-100:]
    assert np.ptp(skill.mean_demonstration[:, 1]) > 0.5
    assert last[:, 1].max() > 0.1


def test_what_cannot_be_strung_is_told_by_its_stroke():
    scenario = Scenario(skill="scrubbing.yaml", lanes=LanesConfig())
    with pytest.raises(ScenarioError, match=r"strokes\[0\]: found a skill with a per"):
        scenario_skill(scenario)


def test_the_fields_between_strokes_hold_no_obstacles(whole_back):
    between = Chain(whole_back.chain.fields[1::2], whole_back.chain.gates[1::2][:-1])
    assert between.obstacle_count == 0
