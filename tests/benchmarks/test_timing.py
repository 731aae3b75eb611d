import os

import pytest

from bath_drake.benchmarks.timing import best_seconds, one_core, seconds


def test_the_best_call_counts_after_one_that_does_not():
    calls = []
    assert best_seconds(lambda: calls.append(0), 4) >= 0.0
    assert len(calls) == 5


def test_one_call_is_timed_once():
    calls = []
    assert seconds(lambda: calls.append(0)) >= 0.0
    assert len(calls) == 1


def test_one_core_is_one_and_afterwards_there_are_all_again():
    before = os.sched_getaffinity(0)
    with one_core():
        assert len(os.sched_getaffinity(0)) == 1
    assert os.sched_getaffinity(0) == before
    with pytest.raises(RuntimeError, match="broken"), one_core():
        raise RuntimeError("broken")
    assert os.sched_getaffinity(0) == before
