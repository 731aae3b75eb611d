"""The learner's cost, its hinges, and the shooting that lowers it."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from bath_drake.errors import DemonstrationError
from bath_drake.field.obstacles import Workspace, curvature_margin, pair_gaps
from bath_drake.field.rollout import rollout
from bath_drake.learning import genome, shooting
from bath_drake.learning.cost import GOAL_TOLERANCE, LearningProblem, ValidityMargins
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.seeding import bends, obstacle_counts, seed_population
from bath_drake.learning.strokes import gather_strokes
from bath_drake.notation import FloatArray

_DISC = Workspace(np.zeros(2), np.array([2.0, 2.0]))
MakeStrokes = Callable[..., Any]


def _problem(make: MakeStrokes, shape: str = "one period") -> LearningProblem:
    return LearningProblem(gather_strokes(make(shape, 1), 80), _DISC, ValidityMargins())


def test_c_is_the_mean_frechet_distance_of_the_roll_outs(
    make_strokes: MakeStrokes,
) -> None:
    problem = _problem(make_strokes)
    xs = seed_population(problem, 3, 6, np.random.default_rng(0))
    costs = problem.evaluate(xs)
    for k, x in enumerate(xs):
        field = genome.decode(x, _DISC, problem.strokes.goal)
        for d, curve in enumerate(problem.strokes.points):
            path = rollout(
                curve[0],
                field,
                step=problem.step,
                max_steps=problem.max_steps,
                goal_tolerance=GOAL_TOLERANCE,
            ).path
            # Swapped axes and angles of the same ellipse differ by rounding.
            assert costs.distances[k, d] == pytest.approx(
                discrete_frechet(path, curve), abs=1e-6
            )
    np.testing.assert_allclose(costs.demonstration_cost, costs.distances.mean(axis=1))
    assert (costs.total >= costs.demonstration_cost).all()


def test_members_are_judged_alike_alone_and_together(make_strokes: MakeStrokes) -> None:
    problem = _problem(make_strokes)
    xs = seed_population(problem, 2, 20, np.random.default_rng(0))
    together = problem.evaluate(xs).total
    alone = np.array([problem.evaluate(x[None]).total[0] for x in xs])
    np.testing.assert_array_equal(together, alone)


def test_without_hinges_the_geometry_is_clear(make_strokes: MakeStrokes) -> None:
    problem = _problem(make_strokes)
    margins = problem.margins
    xs = seed_population(problem, 3, 300, np.random.default_rng(5))
    lacks = problem.lacks(xs)
    assert (lacks >= 0.0).all()
    clear = xs[(lacks == 0.0).all(axis=1)]
    assert 0 < len(clear) < len(xs)
    for x in clear:
        field = genome.decode(x, _DISC, problem.strokes.goal)
        # The learner's own gap is from below, so the true one is at least as wide.
        assert pair_gaps(field.obstacles).min() >= margins.pair
        assert _DISC.beta(field.obstacles.boundary()).min() > 0.0
        assert curvature_margin(field.obstacles, field.goal).min() >= margins.curvature
        assert field.kappa >= margins.kappa * 3


def test_an_overlap_a_rim_and_a_low_kappa_are_charged(
    make_strokes: MakeStrokes,
) -> None:
    problem = _problem(make_strokes)
    r = np.log(0.1)
    apart = np.array([0.0, 1.2, r, r, 0.0, 0.5, -1.2, r, r, 0.0, np.log(5.0)])
    assert problem.lacks(apart[None]).sum() == 0.0
    for index, value in ((6, 1.15), (1, 1.95), (10, 0.0), (1, 0.0)):
        worse = apart.copy()
        worse[index] = value
        if index == 6:
            worse[5] = 0.0
        assert problem.lacks(worse[None]).sum() > 0.0


def test_shooting_lowers_its_cost_and_a_perfect_start_stays(
    make_strokes: MakeStrokes,
) -> None:
    problem = _problem(make_strokes, "wide arc")
    windows = shooting.cut_windows(problem.strokes.points, 10, 5)
    x = seed_population(problem, 2, 1, np.random.default_rng(3))[0]
    before = shooting.shooting_cost(x[None], problem, windows, 2.0, 100.0)[0]
    y, after, evaluations = shooting.fit(x, problem, windows, iterations=5)
    assert after < before
    assert evaluations > 5
    again = shooting.shooting_cost(y[None], problem, windows, 2.0, 100.0)[0]
    assert after == again


def test_the_normal_equations_give_the_gradient_of_the_cost(
    make_strokes: MakeStrokes,
) -> None:
    problem = _problem(make_strokes)
    windows = shooting.cut_windows(problem.strokes.points, 10, 7)
    x = seed_population(problem, 2, 1, np.random.default_rng(8))[0]
    for power in (2.0, 6.0):
        cost, matrix, gradient = shooting.linearise(x, problem, windows, power, 10.0)
        again = shooting.shooting_cost(x[None], problem, windows, power, 10.0)
        assert again == pytest.approx([cost], rel=1e-12)
        np.testing.assert_array_equal(matrix, matrix.T)
        h = 1e-6
        shifted = np.concatenate([x + h * np.eye(len(x)), x - h * np.eye(len(x))])
        costs = shooting.shooting_cost(shifted, problem, windows, power, 10.0)
        difference = (costs[: len(x)] - costs[len(x) :]) / (2.0 * h)
        # Couplings that switch between x - h and x + h.
        np.testing.assert_allclose(
            gradient, difference, rtol=1e-3, atol=5e-4 * np.abs(difference).max()
        )


def test_bends_of_a_sinusoid_alternate_and_a_line_has_none(
    make_strokes: MakeStrokes,
) -> None:
    sine = gather_strokes(make_strokes("one and a half periods", 0))
    turns = [np.sign(t) for _, t in bends(sine.mean)]
    assert turns == [-1.0, 1.0, -1.0]
    assert obstacle_counts(sine.mean)[0] == 3
    line = gather_strokes(make_strokes("line", 0))
    assert bends(line.mean) == []
    assert obstacle_counts(line.mean)[0] == 0


def test_strokes_share_one_goal_and_report_what_was_moved(
    make_strokes: MakeStrokes,
) -> None:
    raw = make_strokes("J", 2)
    strokes = gather_strokes(raw, 60)
    assert strokes.points.shape == (3, 60, 2)
    np.testing.assert_array_equal(strokes.points[:, -1], np.tile(strokes.goal, (3, 1)))
    for stroke, offset in zip(raw, strokes.offsets, strict=True):
        np.testing.assert_allclose(stroke.points[-1] + offset, strokes.goal, atol=1e-12)
    np.testing.assert_allclose(strokes.offsets.sum(axis=0), 0.0, atol=1e-12)
    assert 0.0 < strokes.floor < 0.1


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((1, 2)), "shape"),
        (np.zeros((5, 3)), "shape"),
        (np.zeros((5, 2)), "no length"),
        (np.array([[0.0, 0.0], [np.nan, 1.0]]), "not finite"),
    ],
)
def test_unusable_strokes_are_refused_by_name(
    make_strokes: MakeStrokes, points: FloatArray, message: str
) -> None:
    stroke = type(make_strokes("J", 0)[0])("bad one", points)
    with pytest.raises(DemonstrationError, match=f"bad one.*{message}"):
        gather_strokes([stroke])
    with pytest.raises(DemonstrationError, match="no demonstration"):
        gather_strokes([])


def test_the_hinges_rows_are_their_derivatives(make_strokes: MakeStrokes) -> None:
    problem = _problem(make_strokes)
    seen = np.zeros(11, dtype=bool)
    for x in seed_population(problem, 2, 40, np.random.default_rng(4)):
        x = x - np.append(np.zeros(10), 1.0)  # a kappa that is too low
        rows = shooting.hinge_slopes(x, problem)
        h = 1e-6
        ahead, behind = (
            problem.lacks(x + h * np.eye(11)),
            problem.lacks(x - h * np.eye(11)),
        )
        lacking = problem.lacks(x[None])[0] > 1e-5  # clear of its kink
        # Differences of second order; the curvature's own are of first order.
        np.testing.assert_allclose(
            rows[lacking], ((ahead - behind) / (2.0 * h)).T[lacking], atol=1e-4
        )
        seen[: len(lacking)] |= lacking
    assert seen[[0, 1, 2, 5, 6]].any()
