"""Work shared among cores: all of it, in order, and its errors are heard."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from bath_drake.errors import BathDrakeError
from bath_drake.threads import parallel_map, parts, split, workers


@given(st.integers(0, 500), st.integers(1, 20))
def test_parts_cover_all_and_few_are_small(count, least):
    found = parts(count, least)
    covered = [i for part in found for i in range(count)[part]]
    assert covered == list(range(count))
    assert len(found) <= 32
    assert len(found) == 1 or min(p.stop - p.start for p in found) >= least


def test_split_keeps_every_member_in_its_place(rng):
    xs = rng.normal(size=(77, 3))
    np.testing.assert_array_equal(np.concatenate(split(xs)), xs)


def test_the_order_is_kept():
    assert parallel_map(lambda i: i * i, range(50)) == [i * i for i in range(50)]
    assert parallel_map(str, []) == []


def test_an_error_in_a_thread_is_raised():
    def fail(i):
        raise ValueError(f"item {i}")

    with pytest.raises(ValueError, match="item 0"):
        parallel_map(fail, [0, 1, 2])


@pytest.mark.parametrize("count", [1, 2, 7])
def test_the_environment_says_how_many_work(monkeypatch, count):
    whole = parts(500)
    monkeypatch.setenv("BATH_DRAKE_WORKERS", str(count))
    assert workers() == count
    assert parallel_map(lambda i: i * i, range(50)) == [i * i for i in range(50)]
    # Pieces that followed the workers could round differently.
    assert parts(500) == whole


@pytest.mark.parametrize("asked", ["0", "-1", "two", "1.5"])
def test_a_bad_number_of_workers_is_refused(monkeypatch, asked):
    monkeypatch.setenv("BATH_DRAKE_WORKERS", asked)
    with pytest.raises(BathDrakeError, match=f"BATH_DRAKE_WORKERS: found '{asked}'"):
        workers()
