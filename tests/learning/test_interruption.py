"""Learning that is stopped, continued, shared among cores or hit by failures."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bath_drake.composition.rollout import chain_rollout
from bath_drake.learning import shooting
from bath_drake.learning.checkpoint import Arrays, Checkpoint
from bath_drake.learning.config import LearnerConfig, Method
from bath_drake.learning.failures import costs_of
from bath_drake.learning.learner import LearningResult, learn_skill
from bath_drake.notation import FloatArray

MakeStrokes = Callable[..., Any]


class Impatient(Checkpoint):
    """Stops learning after so many new steps."""

    patience = 1

    def step(self, key: str, compute: Callable[[], Arrays]) -> Arrays:
        def counted() -> Arrays:
            self.patience -= 1
            if self.patience < 1:
                self.stop()
            return compute()

        return super().step(key, counted)


def check_same(a: LearningResult, b: LearningResult) -> None:
    assert [x.chain for x in a.branches] == [x.chain for x in b.branches]
    assert a.cost_history == b.cost_history
    assert a.frechet == b.frechet
    assert (a.finished, a.failures) == (b.finished, b.failures)
    np.testing.assert_array_equal(a.rollout.path, b.rollout.path)


@pytest.mark.parametrize("method", ["auto", "paper"])
def test_stopped_after_every_step_learning_ends_the_same(
    make_strokes: MakeStrokes, tmp_path: Path, method: Method
) -> None:
    strokes = make_strokes("zigzag", 0)
    config = replace(LearnerConfig.quick(method=method), obstacles=3, target=0.0)
    whole = learn_skill(strokes, config)
    assert whole.finished
    runs = 0
    costs = []
    result = None
    while result is None or not result.finished:
        with Impatient(tmp_path / "c", {}, resume=True) as checkpoint:
            result = learn_skill(strokes, config, checkpoint=checkpoint)
            assert checkpoint.found == runs
        runs += 1
        if not result.finished:
            costs.append(result.frechet["cost"])
            # Whatever there is, it runs; the paper's obstacles may cover the start.
            points = len(chain_rollout(result.start, result.chain).path)
            assert points >= (1 if method == "paper" else 2)
    check_same(result, whole)
    # At least: seeds, first members, two generations.
    assert len(costs) >= 4
    assert min(*costs, result.frechet["cost"]) < costs[0]


def test_a_chain_stopped_again_and_again_ends_the_same(
    make_strokes: MakeStrokes, tmp_path: Path
) -> None:
    strokes = make_strokes("loop", 0)
    config = replace(LearnerConfig.quick(), fields="many")
    whole = learn_skill(strokes, config)
    assert whole.converged
    result = None
    for _ in range(20):
        with Impatient(tmp_path / "c", {}, resume=True) as checkpoint:
            checkpoint.patience = 15
            result = learn_skill(strokes, config, checkpoint=checkpoint)
        if result.finished:
            break
        assert not result.converged
        assert len(chain_rollout(result.start, result.chain).path) > 1
    assert result is not None
    check_same(result, whole)


def test_progress_tells_of_every_stage_of_a_chain(make_strokes: MakeStrokes) -> None:
    told: list[tuple[int, int, float]] = []
    config = replace(LearnerConfig.quick(), fields="many")
    result = learn_skill(
        make_strokes("C", 0), config, lambda *told_now: told.append(told_now)
    )
    done = [now for now, _, _ in told]
    assert done[:-1] == list(range(1, len(told)))  # the last says that it is the end
    assert all(now <= total for now, total, _ in told)
    assert done[-1] == told[-1][1]
    # No cost is known before the first chain is whole.
    assert told[0][2] == np.inf
    assert told[-1][2] == result.cost_history[-1][1]
    assert len(told) > len(result.cost_history) + len(result.chain)


def test_the_number_of_workers_does_not_tell(
    make_strokes: MakeStrokes, monkeypatch: pytest.MonkeyPatch
) -> None:
    strokes = make_strokes("J", 0)
    found = []
    for workers in ("1", "2", "5"):
        monkeypatch.setenv("BATH_DRAKE_WORKERS", workers)
        found.append(learn_skill(strokes, LearnerConfig.quick(seed=2)))
    check_same(found[0], found[1])
    check_same(found[0], found[2])


def test_candidates_that_fail_are_dropped_and_counted(
    make_strokes: MakeStrokes, monkeypatch: pytest.MonkeyPatch
) -> None:
    strokes = make_strokes("wide arc", 0)
    config = replace(LearnerConfig.quick(), obstacles=2)
    assert learn_skill(strokes, config).failures == 0
    fit, cost = shooting.fit, shooting.shooting_cost

    def unlucky(x: FloatArray) -> bool:
        return int(1e9 * abs(x[0])) % 4 == 0

    def failing_fit(x: FloatArray, *args: Any, **options: Any) -> Any:
        if unlucky(x):
            raise np.linalg.LinAlgError("Singular matrix")
        return fit(x, *args, **options)

    def failing_cost(xs: FloatArray, *args: Any) -> FloatArray:
        if any(unlucky(x) for x in xs):
            raise ZeroDivisionError("division by zero")
        return cost(xs, *args)

    monkeypatch.setattr(shooting, "fit", failing_fit)
    monkeypatch.setattr(shooting, "shooting_cost", failing_cost)
    result = learn_skill(strokes, config)
    assert result.failures > 0
    assert result.finished
    assert result.converged


def test_where_every_candidate_fails_the_straight_way_is_left(
    make_strokes: MakeStrokes, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(xs: FloatArray, *_: Any) -> FloatArray:
        return np.full(len(xs), np.nan)

    def fail_too(x: FloatArray, *_: Any, **__: Any) -> Any:
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr(shooting, "shooting_cost", fail)
    monkeypatch.setattr(shooting, "fit", fail_too)
    config = replace(LearnerConfig.quick(), obstacles=2)
    result = learn_skill(make_strokes("wide arc", 0), config)
    assert result.finished
    assert result.failures > 0
    assert result.obstacle_count == 0


def test_a_failing_member_takes_no_other_with_it() -> None:
    def cost(xs: FloatArray) -> FloatArray:
        if (xs[:, 0] == 0.0).any():
            raise ZeroDivisionError
        return 1.0 / xs[:, 0]

    xs = np.array([[4.0], [0.0], [np.nan], [2.0]])
    np.testing.assert_array_equal(costs_of(cost, xs), [0.25, np.inf, np.inf, 0.5])
