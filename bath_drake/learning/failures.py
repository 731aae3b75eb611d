"""A member that cannot be evaluated costs nothing but itself."""

from collections.abc import Callable

import numpy as np

from bath_drake.notation import FloatArray

FAILURES = (ArithmeticError, np.linalg.LinAlgError)
"""What evaluating a field raises when its numbers run out: kernels, on 1 / 0."""


def costs_of(cost: Callable[[FloatArray], FloatArray], xs: FloatArray) -> FloatArray:
    """``cost(xs)`` of members (n, P), with inf for each that fails or is not finite."""
    try:
        costs = cost(xs)
    except FAILURES:
        if len(xs) == 1:
            return np.array([np.inf])
        return np.concatenate([costs_of(cost, x[None]) for x in xs])
    return np.where(np.isfinite(costs), costs, np.inf)
