"""Learning as a whole: quick checks always, the real target when asked for."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from bath_drake.field.critical_points import check_field
from bath_drake.field.rollout import RolloutStatus, rollout
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.cost import GOAL_TOLERANCE
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.learner import LearningResult, learn_skill

MakeStrokes = Callable[..., Any]


def _check_consistency(result: LearningResult) -> None:
    """What every result must satisfy, good or bad."""
    path = rollout(result.start, result.field, goal_tolerance=GOAL_TOLERANCE)
    np.testing.assert_array_equal(path.path, result.rollout.path)
    raw = discrete_frechet(path.path, result.mean_demonstration)
    assert result.frechet["to_mean_raw"] == pytest.approx(raw, rel=1e-12)
    assert result.frechet["to_mean"] == pytest.approx(raw / result.scale, rel=1e-12)
    assert result.frechet["cost"] == pytest.approx(np.mean(result.per_demonstration))
    assert check_field(result.field).verdict == result.check.verdict
    evaluations, costs = zip(*result.cost_history, strict=True)
    assert (np.diff(evaluations) >= 0).all()
    assert (np.diff(costs) <= 0).all()
    if result.converged:
        assert result.check.passed
        assert path.status is RolloutStatus.ARRIVED
        assert result.frechet["to_mean"] <= 0.10


def test_the_same_seed_gives_the_same_skill(make_strokes: MakeStrokes) -> None:
    strokes = make_strokes("one period", 0)
    calls: list[tuple[int, int, float]] = []
    config = LearnerConfig.quick(seed=3)
    result = learn_skill(strokes, config, lambda *a: calls.append(a))
    assert learn_skill(strokes, config).field == result.field
    _check_consistency(result)
    assert result.converged
    done = [c[0] for c in calls]
    assert done == sorted(done)
    assert calls[-1][0] == calls[-1][1]


def test_a_straight_stroke_needs_no_obstacle(make_strokes: MakeStrokes) -> None:
    result = learn_skill(make_strokes("line", 1), LearnerConfig.quick())
    _check_consistency(result)
    assert len(result.field.obstacles) == 0
    assert result.converged


def test_the_papers_method_lowers_the_paper_cost(make_strokes: MakeStrokes) -> None:
    strokes = make_strokes("wide arc", 0)
    result = learn_skill(strokes, LearnerConfig.quick(method="paper"))
    _check_consistency(result)
    assert result.cost_history[-1][1] < result.cost_history[0][1]
    assert result.frechet["cost"] < 0.10


def test_a_single_demonstration_will_do(make_strokes: MakeStrokes) -> None:
    result = learn_skill(make_strokes("wide arc", 0, count=1), LearnerConfig.quick())
    _check_consistency(result)
    assert result.frechet["floor"] == pytest.approx(0.0, abs=5e-3)  # resampled twice
    assert result.converged


def test_a_stroke_outside_the_workspace_is_refused(make_strokes: MakeStrokes) -> None:
    config = LearnerConfig(workspace_radius=0.5)
    with pytest.raises(ValueError, match=r"workspace of radius 0\.5"):
        learn_skill(make_strokes("J", 0), config)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"method": "best"}, "method"),
        ({"obstacles": 13}, "obstacles"),
        ({"population": 3}, "population"),
        ({"generations": -1}, "generations"),
        ({"seeds": 0}, "seeds"),
        ({"points": 5}, "points"),
        ({"workspace_radius": 0.0}, "workspace_radius"),
    ],
)
def test_bad_configurations_are_refused(arguments: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        LearnerConfig(**arguments)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_three_sinusoids_are_learned_to_three_hundredths(
    make_strokes: MakeStrokes, seed: int
) -> None:
    strokes = make_strokes("one and a half periods", seed)
    result = learn_skill(strokes, LearnerConfig(seed=seed))
    _check_consistency(result)
    assert result.converged
    assert result.frechet["to_mean"] <= 0.03  # the paper reports 0.052


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "limit"),
    [
        ("one period", 0.03),
        ("C", 0.03),
        ("wide arc", 0.03),
        ("line", 0.03),
        ("J", 0.05),
        # Sharp bends near the goal are the hard ones for a single field.
        ("S", 0.10),
        ("zigzag", 0.06),
        ("two periods", 0.10),
    ],
)
def test_other_strokes_are_learned(
    make_strokes: MakeStrokes, shape: str, limit: float
) -> None:
    result = learn_skill(make_strokes(shape, 0), LearnerConfig())
    _check_consistency(result)
    assert result.converged
    assert result.frechet["to_mean"] <= limit


@pytest.mark.slow
def test_a_stroke_that_crosses_itself_ends_honestly(make_strokes: MakeStrokes) -> None:
    result = learn_skill(make_strokes("loop", 0), LearnerConfig())
    _check_consistency(result)
    assert not result.converged
