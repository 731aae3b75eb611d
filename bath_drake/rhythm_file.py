"""A skill's periodic motion as a block of its file.

The block `periodic` has the keys coefficients (rows cos phi, sin phi, cos 2 phi, ... by
x and y), period, pitch, begin and end; see `bath_drake.rhythm.limit_cycle.LimitCycle`.
Skills without a periodic motion have no such block.
"""

from typing import Any

import numpy as np

from bath_drake.rhythm.limit_cycle import LimitCycle
from bath_drake.yaml_block import Block

PERIODIC = "periodic"
# A thousand harmonics are no hand's motion.
_MOST_ROWS = 64


def cycle_to_mapping(cycle: LimitCycle) -> dict[str, Any]:
    """A cycle as the tree of plain values of its block."""
    return {
        "coefficients": cycle.coefficients.tolist(),
        "period": float(cycle.period),
        "pitch": float(cycle.pitch),
        "begin": float(cycle.begin),
        "end": float(cycle.end),
    }


def take_cycle(block: Block) -> LimitCycle:
    """The inverse of `cycle_to_mapping`.

    Raises:
        BathDrakeError: As the block's error, naming the key.
    """
    rows = block.take_rows("coefficients", None, 2)
    numbers = {k: block.take(k, float) for k in ("period", "pitch", "begin", "end")}
    block.finish()
    if len(rows) > _MOST_ROWS:
        block.fail(
            "coefficients", f"found {len(rows)} rows, allowed: {_MOST_ROWS} at most"
        )
    try:
        return LimitCycle(np.array(rows).reshape(-1, 2), **numbers)
    except ValueError as problem:
        block.fail("", str(problem))
