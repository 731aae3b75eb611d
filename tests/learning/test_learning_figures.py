"""The pictures of learning, and the trace they are drawn from."""

from dataclasses import replace

import matplotlib.image
import numpy as np
import pytest
from readable import check_readable

from bath_drake.demonstrations.processing import canonical_demonstrations
from bath_drake.demonstrations.recording import read_recording
from bath_drake.learning.checkpoint import Checkpoint
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.generalisation import evaluate_generalisation
from bath_drake.learning.held_out import HeldOut
from bath_drake.learning.learner import learn_skill
from bath_drake.learning.trace import Generation, Trace, places
from bath_drake.learning_figures.fields import fields_figure
from bath_drake.learning_figures.held_out import held_out_figure
from bath_drake.learning_figures.overview import overview_figure
from bath_drake.learning_figures.paths import picture_path
from bath_drake.learning_figures.population import population_figure
from bath_drake.learning_figures.stages import stages_figure
from bath_drake.learning_figures.write import DPI, write_learning_figures
from bath_drake.report.generalisation_figure import draw_generalisation
from bath_drake.resources import models_folder


def _strokes(name):
    folder = models_folder() / "demonstrations" / "strokes"
    recordings = [read_recording(p) for p in sorted(folder.glob(f"{name}_[0-9].csv"))]
    return canonical_demonstrations(recordings)[0]


@pytest.fixture(scope="module")
def chain():
    """A composed skill of an S, quickly learned, and its demonstrations."""
    strokes = _strokes("s_curve")
    config = replace(LearnerConfig.quick(), fields="many")
    return learn_skill(strokes, config), [s.points for s in strokes]


@pytest.fixture(scope="module")
def single():
    strokes = _strokes("arc_shallow")
    config = replace(LearnerConfig.quick(), obstacles=1)
    return learn_skill(strokes, config), [s.points for s in strokes]


def test_a_chain_is_shown_with_its_stages_and_what_was_tried(chain):
    result, points = chain
    count = len(result.chain)
    assert count > 1
    overview = overview_figure(result, points)
    check_readable(overview)
    plane, curve = overview.axes
    numbers = [t.get_text() for t in plane.texts]
    assert numbers == [str(k + 1) for k in range(count)]
    assert curve.get_xlabel() == "members evaluated"
    assert curve.get_yscale() == "log"
    for figure in (fields_figure(result, points), stages_figure(result)):
        check_readable(figure)
        titles = [a.get_title() for a in figure.axes if a.get_visible()]
        assert len(titles) == count
        for k, title in enumerate(titles):
            assert title.startswith(f"Stage {k + 1}")
    assert population_figure(result.trace, 1) is None


def test_the_stages_chosen_are_those_of_the_chain(chain):
    result, _ = chain
    plan = result.trace.plan_of(0)
    obstacles = [len(field.obstacles) for field in result.chain.fields]
    assert [trial.obstacles for trial in plan.chosen] == obstacles
    assert len(plan.pieces) == len(result.chain)
    for stages in plan.stages:
        assert [trial.obstacles for trial in stages] == list(range(len(stages)))
        for trial in stages:
            assert trial.price >= trial.error


def test_a_single_field_is_shown_with_the_population_it_came_from(single):
    result, points = single
    check_readable(overview_figure(result, points))
    check_readable(fields_figure(result, points))
    assert stages_figure(result) is None
    check_readable(population_figure(result.trace, 1))
    steps = result.trace.generations_of(0)
    assert steps[0].name == "by direction"
    assert steps[-1].name == "finish"
    for step in steps:
        assert len(step.places) == len(step.costs)
        assert (np.diff(step.costs) >= 0.0).all()
        assert all(len(member) == 1 for member in step.places)


def test_a_long_search_for_several_ways_stays_readable():
    names = ["by direction", "from the goal", *(f"generation {g}" for g in range(10))]
    members = ((0, 3, 3), (1,), (2, 5))
    costs = np.array([0.02, 0.03, 0.2])
    trace = Trace(
        [Generation(w, n, costs, members) for w in (0, 1) for n in [*names, "finish"]]
    )
    figure = population_figure(trace, 2)
    check_readable(figure)
    sides = figure.axes[2]
    assert [t.get_text() for t in sides.get_yticklabels()] == [
        f"bend {k}, {side}" for k in (1, 2, 3) for side in ("left", "right")
    ]


def test_nothing_tried_is_no_figure():
    assert population_figure(Trace(), 1) is None


def test_the_left_is_to_the_left_of_who_goes_along():
    t = np.linspace(0.0, 1.0, 100)
    arc = np.stack([np.cos(np.pi * t), np.sin(np.pi * t)], axis=-1)
    # Along a half circle against the clock its middle is to the left.
    assert places(arc, np.array([[0.0, 0.5], [0.0, 1.5]])).tolist() == [0, 1]
    back = places(arc[::-1], np.array([[0.0, 0.5], [0.0, 1.5]]))
    assert back.tolist() == [1, 0]
    assert len(places(arc, np.empty((0, 2)))) == 0


def test_a_resumed_run_traces_the_same(tmp_path):
    strokes = _strokes("arc_shallow")
    config = replace(LearnerConfig.quick(), obstacles=1)
    with Checkpoint(tmp_path / "s.checkpoint") as kept:
        first = learn_skill(strokes, config, checkpoint=kept)
    with Checkpoint(tmp_path / "s.checkpoint", resume=True) as kept:
        assert kept.found > 0
        again = learn_skill(strokes, config, checkpoint=kept)
    assert len(first.trace.generations) == len(again.trace.generations)
    for a, b in zip(first.trace.generations, again.trace.generations, strict=True):
        assert (a.name, a.places) == (b.name, b.places)
        assert np.array_equal(a.costs, b.costs)


def test_generalisation_is_shown_ring_by_ring(chain):
    result, points = chain
    found = evaluate_generalisation(result.branches, points, count=4)
    # What is proved arrives, and so it does as far out as demonstrated.
    assert found.rings[0].arrived.all()
    figure = draw_generalisation(found, result.branches)
    check_readable(figure)
    for axes, ring in zip(figure.axes, found.rings, strict=True):
        assert f"{int(ring.arrived.sum())} of 4 arrive" in axes.get_title()


def test_what_did_not_arrive_is_marked_in_the_held_out_figure(chain):
    _, points = chain
    count = len(points)
    found = HeldOut(
        names=tuple(f"take {i}" for i in range(count)),
        in_sample=(float("nan"), *np.full(count - 1, 0.02)),
        distances=tuple(np.linspace(0.03, 0.05, count)),
        arrived=(False, *(True,) * (count - 1)),
        proved=(True,) * count,
        strokes=tuple(points),
        paths=tuple(p + 0.01 for p in points),
        finished=True,
    )
    figure = held_out_figure(found)
    check_readable(figure)
    legend = [t.get_text() for t in figure.axes[0].get_legend().get_texts()]
    assert legend == ["in-sample", "held out", "did not arrive", "median 0.0400"]
    ticks = [t.get_text() for t in figure.axes[0].get_yticklabels()]
    assert ticks[0] == "1  take 0"


def test_pictures_are_written_beside_the_skill_and_stale_ones_go(single, tmp_path):
    result, points = single
    skill = tmp_path / "s.yaml"
    stale = picture_path(skill, "stages")
    stale.write_text("of another skill")
    written = write_learning_figures(skill, result, points)
    assert sorted(tmp_path.iterdir()) == sorted(written)
    assert [p.name for p in written] == ["s.png", "s_fields.png", "s_population.png"]
    height, width, _ = matplotlib.image.imread(written[0]).shape
    # 12 by 5.9 inches.
    assert (width, height) == (12 * DPI, round(5.9 * DPI))
    alone = write_learning_figures(skill, result, points, overview_only=True)
    assert alone == [skill.with_suffix(".png")]
    assert list(tmp_path.iterdir()) == alone
