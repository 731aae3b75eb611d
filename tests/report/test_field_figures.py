"""The report's pictures of fields: nothing of them is cut off."""

import numpy as np
import pytest
from made_up_skill import composed_skill
from readable import check_readable

from bath_drake.composition.rollout import chain_rollout
from bath_drake.report import style
from bath_drake.report.field_figures import draw_chain, draw_demonstrations
from bath_drake.scenario import find_skill
from bath_drake.skill_file import load_skill

SKILLS = {
    "one field": lambda: load_skill(find_skill("back_sinusoid.yaml")),
    "a chain": lambda: load_skill(find_skill("figure_eight.yaml")),
    "two fields": composed_skill,
}


@pytest.mark.parametrize("name", SKILLS)
def test_the_learned_motion_is_readable(name):
    skill = SKILLS[name]()
    mean = skill.mean_demonstration
    path = chain_rollout(skill.start, skill.chain).path
    with style.figure_style():
        figure = draw_chain(
            skill.chain, [mean], mean, path, "Fréchet 0.00646, floor 0.0175"
        )
        check_readable(figure)


def test_demonstrations_are_readable():
    x = np.linspace(-0.7, 0.7, 50)
    path = np.column_stack([x, 0.3 * np.sin(8.0 * x)])
    with style.figure_style():
        check_readable(draw_demonstrations([path] * 3, [path] * 3, path))
