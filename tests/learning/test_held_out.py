"""Demonstrations held against what was learned from the others."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bath_drake.errors import DemonstrationError
from bath_drake.learning.checkpoint import Checkpoint
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.held_out import leave_one_out
from bath_drake.learning.learner import learn_skill

MakeStrokes = Callable[..., Any]
STRAIGHT = replace(LearnerConfig.quick(), obstacles=0)


def test_what_the_others_show_as_well_is_foreseen_as_well(
    make_strokes: MakeStrokes,
) -> None:
    (stroke,) = make_strokes("line", 0, 1)
    same = [replace(stroke, name=f"take {i}") for i in range(3)]
    result = learn_skill(same, STRAIGHT)
    shares: list[float] = []
    found = leave_one_out(same, result, shares.append)
    assert found.finished
    assert found.names == ("take 0", "take 1", "take 2")
    # The mean of two equal strokes is that of three, to rounding.
    assert found.distances == pytest.approx(found.in_sample, abs=1e-6)
    assert all(found.arrived)
    assert all(found.proved)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_each_is_compared_with_a_motion_from_its_own_start_to_the_goal(
    make_strokes: MakeStrokes,
) -> None:
    strokes = make_strokes("line", 3)
    result = learn_skill(strokes, STRAIGHT)
    found = leave_one_out(strokes, result)
    assert found.in_sample == result.per_demonstration
    for stroke, path in zip(found.strokes, found.paths, strict=True):
        assert np.array_equal(path[0], stroke[0])
        # The roll-out ends within the goal's tolerance.
        assert np.allclose(path[-1], stroke[-1], atol=3e-3)


def test_a_stopped_search_tells_what_is_done_and_goes_on_where_it_was(
    make_strokes: MakeStrokes,
) -> None:
    strokes = make_strokes("line", 3)
    result = learn_skill(strokes, STRAIGHT)
    kept = Checkpoint()

    def stop_after_one(share: float) -> None:
        if share >= 1 / 3:
            kept.stop()

    partial = leave_one_out(strokes, result, stop_after_one, kept)
    assert not partial.finished
    assert len(partial.names) == 1
    whole = leave_one_out(strokes, result)
    assert partial.distances == whole.distances[:1]


def test_one_demonstration_cannot_be_held_out(make_strokes: MakeStrokes) -> None:
    strokes = make_strokes("line", 0, 1)
    result = learn_skill(strokes, STRAIGHT)
    with pytest.raises(DemonstrationError, match="line 0: the only demonstration"):
        leave_one_out(strokes, result)
