"""A skill's cycle comes back from its file, or is refused by name."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_run import make_skill

from bath_drake.errors import SkillFileError
from bath_drake.rhythm.limit_cycle import LimitCycle
from bath_drake.rhythm_file import cycle_to_mapping, take_cycle
from bath_drake.scenario import Scenario
from bath_drake.skill_file import load_skill, save_skill, skill_to_mapping
from bath_drake.yaml_block import Block

CYCLE = LimitCycle(np.array([[0.1, 0.2], [0.3, -0.1]]) / 3.0, 1.1, 0.12, 0.01, 0.02)


def take(**changes):
    mapping = {**cycle_to_mapping(CYCLE), **changes}
    return take_cycle(Block(mapping, "skill.yaml", "periodic", error=SkillFileError))


def test_a_cycle_comes_back_to_the_last_bit():
    assert take() == CYCLE
    assert hash(take()) == hash(CYCLE)


def test_a_skill_with_a_cycle_comes_back_and_one_without_has_no_block(tmp_path):
    plain = make_skill(Scenario())
    assert "periodic" not in skill_to_mapping(plain)
    path = tmp_path / "skill.yaml"
    save_skill(path, replace(plain, periodic=CYCLE))
    assert load_skill(path).periodic == CYCLE


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"period": -1.0}, "period must be positive"),
        ({"pitch": "x"}, "periodic.pitch: found 'x'"),
        ({"coefficients": [[1.0, 2.0, 3.0]] * 2}, r"coefficients\[0\]: found 3"),
        ({"coefficients": []}, r"shape \(2 K, 2\)"),
        ({"coefficients": [[0.0, 0.0]] * 2}, "the cycle is a point"),
        ({"coefficients": [[0.1, 0.1]] * 66}, "found 66 rows, allowed: 64"),
        ({"speed": 1.0}, "speed"),
    ],
)
def test_a_damaged_block_is_refused_by_name(changes, complaint):
    with pytest.raises(SkillFileError, match=complaint):
        take(**changes)
