"""The picture of the cycle shows what was shown, learned, asked for and washed."""

import numpy as np

from bath_drake.demonstrations.processing import canonical_demonstrations
from bath_drake.demonstrations.recording import read_recording
from bath_drake.learning.periodic import learn_cycle
from bath_drake.report import style
from bath_drake.report.cycle_figure import draw_cycle
from bath_drake.resources import models_folder


def legends(figure):
    return [
        [text.get_text() for text in axes.get_legend().get_texts()]
        for axes in figure.axes
    ]


def test_of_a_skill_and_of_a_run(tmp_path):
    path = models_folder() / "demonstrations" / "scrubbing_1.csv"
    demonstrations, _ = canonical_demonstrations([read_recording(path)])
    cycle = learn_cycle(demonstrations).cycle
    asked = cycle.offset(np.linspace(0.0, 6.0, 50))
    with style.figure_style():
        of_skill = draw_cycle(cycle, demonstrations)
        of_run = draw_cycle(cycle, demonstrations, asked, asked + 0.01)
        of_run.savefig(tmp_path / "cycle.png", dpi=40)
    assert legends(of_skill) == [["demonstrated", "learned cycle"]]
    assert legends(of_run)[1] == ["washed", "asked for"]
    drawn = of_run.axes[1].lines
    np.testing.assert_array_equal(drawn[0].get_xydata(), asked + 0.01)
    assert all("in N" in axes.get_xlabel() for axes in of_run.axes)
