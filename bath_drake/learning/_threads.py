"""Independent pieces of work on all cores; kernels release the interpreter lock."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np

from bath_drake.notation import FloatArray

Item = TypeVar("Item")
Result = TypeVar("Result")


def workers() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0))


def parallel_map(work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """``[work(i) for i in items]``, several at a time; the order is kept."""
    with ThreadPoolExecutor(workers()) as pool:
        return list(pool.map(work, items))


def split(xs: FloatArray, least: int = 8) -> list[FloatArray]:
    """Members (n, P) in about four parts a core, none much smaller than ``least``."""
    parts = max(1, min(len(xs) // least, 4 * workers()))
    return np.array_split(xs, parts)
