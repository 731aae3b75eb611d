"""How much of the cycles that were asked for was washed."""

import numpy as np

from bath_drake.notation import FloatArray
from bath_drake.rhythm.limit_cycle import LimitCycle


def washed_cycles(
    cycle: LimitCycle | None, around: FloatArray, offsets: FloatArray
) -> dict[str, float] | None:
    """Measures washed points against the cycles asked for; None without any.

    Args:
        cycle: That was learned.
        around: Washed points (n, 2), seen from the discrete motion's reference, in N.
        offsets: What was asked for there, (n, 2), in N.

    Returns:
        `cycles`, how many were asked for; `gain`, the share of them that was washed
        (by least squares; lag takes from it); `asked_share`, their size as a share of
        the learned one.
    """
    if cycle is None or not offsets.any():
        return None
    around = around - around.mean(axis=0)
    axis = np.linalg.svd(offsets, full_matrices=False)[2][0]
    swings = np.sign(offsets @ axis)
    crossings = np.count_nonzero(np.diff(swings[swings != 0.0]))
    size = float(np.quantile(np.linalg.norm(offsets, axis=1), 0.95))
    return {
        "cycles": float(crossings / 2.0),
        "gain": float(np.sum(around * offsets) / np.sum(offsets**2)),
        "asked_share": size / cycle.radius,
    }
