"""Clocks for benchmarks."""

import contextlib
import os
import time
from collections.abc import Callable, Iterator


def best_seconds(function: Callable[[], object], repeats: int) -> float:
    """Seconds of the fastest of some calls, after one that is not counted.

    Whatever else the machine does can only make a call slower: for microseconds the
    fastest call is the figure that says most about the program.
    """
    function()
    return min(seconds(function) for _ in range(repeats))


def seconds(function: Callable[[], object]) -> float:
    """Seconds one call takes."""
    begin = time.perf_counter()
    function()
    return time.perf_counter() - begin


@contextlib.contextmanager
def one_core() -> Iterator[None]:
    """Keeps this thread, and those it starts, to one core."""
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, cores)
