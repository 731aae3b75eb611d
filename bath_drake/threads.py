"""Independent pieces of work on all cores; kernels release the interpreter lock."""

import itertools
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from bath_drake.notation import FloatArray

Item = TypeVar("Item")
Result = TypeVar("Result")


def workers() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0))


def parallel_map(work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """``[work(i) for i in items]``, several at a time; the order is kept."""
    items = list(items)
    if len(items) < 2 or workers() < 2:
        return [work(i) for i in items]  # a pool costs more than a short piece
    with ThreadPoolExecutor(workers()) as pool:
        return list(pool.map(work, items))


def parts(count: int, least: int = 8) -> list[slice]:
    """0..count in about four slices a core, none much shorter than ``least``."""
    pieces = max(1, min(count // least, 4 * workers()))
    ends = [count * i // pieces for i in range(pieces + 1)]
    return [slice(a, b) for a, b in itertools.pairwise(ends)]


def split(xs: FloatArray, least: int = 8) -> list[FloatArray]:
    """Members (n, P) in about four parts a core, none much smaller than ``least``."""
    return [xs[part] for part in parts(len(xs), least)]
