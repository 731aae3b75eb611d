"""Local descent x <- x - omega grad C on members of a population (Sec. III-C)."""

from collections.abc import Callable

import numpy as np

from bath_drake.notation import FloatArray

_DIFFERENCE = 1e-5


def descend(
    cost: Callable[[FloatArray], FloatArray],
    xs: FloatArray,
    scale: FloatArray,
    *,
    iterations: int = 10,
    omega: float = 0.1,
    clip: Callable[[FloatArray], FloatArray] | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Descends from members (n, P), all at once; returns them and their costs (n,).

    The gradient is taken by central differences in units of ``scale`` (P,), its
    length set to one: omega is the length of a step in those units. Several omegas
    are tried in one batch, from twice the last one down to a 512th of it, and the
    best is taken if it lowers the cost.
    """
    xs = np.array(xs, dtype=np.float64)
    n, size = xs.shape
    costs = cost(xs)
    lengths = np.full(n, omega)
    trials = 2.0 * 0.25 ** np.arange(6)
    shifts = _DIFFERENCE * np.diag(scale)
    for _ in range(iterations):
        ahead = cost((xs[:, None] + shifts).reshape(-1, size)).reshape(n, size)
        behind = cost((xs[:, None] - shifts).reshape(-1, size)).reshape(n, size)
        gradient = (ahead - behind) / (2.0 * _DIFFERENCE)
        norm = np.linalg.norm(gradient, axis=1, keepdims=True)
        steps = -scale * gradient / np.maximum(norm, 1e-12)
        candidates = (
            xs[:, None] + lengths[:, None, None] * trials[:, None] * steps[:, None]
        )
        flat = candidates.reshape(-1, size)
        flat = flat if clip is None else clip(flat)
        tried = cost(flat).reshape(n, -1)
        best = tried.argmin(axis=1)
        rows = np.arange(n)
        better = tried[rows, best] < costs
        chosen = flat.reshape(n, -1, size)[rows, best]
        xs = np.where(better[:, None], chosen, xs)
        costs = np.where(better, tried[rows, best], costs)
        factor = np.where(better, trials[best], trials[-1])
        lengths = np.clip(lengths * factor, 1e-6, 1.0)
    return xs, costs
