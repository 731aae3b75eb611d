"""Independent pieces of work on all cores; kernels release the interpreter lock.

How work is cut into pieces does not depend on the number of cores, so that no result
does. BATH_DRAKE_WORKERS in the environment sets how many are used.
"""

import itertools
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from bath_drake.errors import BathDrakeError
from bath_drake.notation import FloatArray

# Enough to keep eight cores evenly busy.
_PIECES = 32

Item = TypeVar("Item")
Result = TypeVar("Result")


def workers() -> int:
    """How many pieces are worked on at a time: by default one a core.

    Raises:
        BathDrakeError: BATH_DRAKE_WORKERS is not a number from 1 on.
    """
    asked = os.environ.get("BATH_DRAKE_WORKERS", "")
    if not asked:
        return len(os.sched_getaffinity(0))
    if not asked.isdecimal() or int(asked) < 1:
        raise BathDrakeError(f"BATH_DRAKE_WORKERS: found {asked!r}, allowed: 1 or more")
    return int(asked)


def parallel_map(work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """``[work(i) for i in items]``, several at a time; the order is kept."""
    items = list(items)
    if len(items) < 2 or workers() < 2:
        return [work(i) for i in items]  # a pool costs more than a short piece
    with ThreadPoolExecutor(workers()) as pool:
        return list(pool.map(work, items))


def parts(count: int, least: int = 8) -> list[slice]:
    """0..count in at most 32 even slices, none shorter than ``least`` but the only."""
    pieces = max(1, min(count // least, _PIECES))
    ends = [count * i // pieces for i in range(pieces + 1)]
    return [slice(a, b) for a, b in itertools.pairwise(ends)]


def split(xs: FloatArray, least: int = 8) -> list[FloatArray]:
    """Members (n, P) in the parts that `parts` cuts."""
    return [xs[part] for part in parts(len(xs), least)]
