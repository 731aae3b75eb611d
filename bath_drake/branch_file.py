"""The branches of a skill as blocks of its file; their chains stand in `field`.

A branch's block has the keys start, starts, mean_demonstration and conditioning, the
last null or the numbers of a `bath_drake.composition.conditioning.Conditioning`.
"""

from typing import Any

import numpy as np

from bath_drake.composition.branch import Branch
from bath_drake.composition.chain import Chain
from bath_drake.composition.conditioning import NUMBERS, Conditioning
from bath_drake.yaml_block import Block


def branch_to_mapping(branch: Branch) -> dict[str, Any]:
    """A branch as the tree of plain values of its block."""
    how = branch.conditioning
    return {
        "start": branch.start.tolist(),
        "starts": branch.starts.tolist(),
        "mean_demonstration": branch.mean.tolist(),
        "conditioning": None if how is None else _conditioning_to_mapping(how),
    }


def take_branch(block: Block, chain: Chain) -> Branch:
    """The inverse of `branch_to_mapping`, with the branch's chain.

    Raises:
        BathDrakeError: As the block's error, naming the key.
    """
    start = block.take_list("start", float, 2)
    starts = block.take_rows("starts", None, 2)
    mean = block.take_rows("mean_demonstration", None, 2)
    how = None
    if not block.take_null("conditioning"):
        how = _take_conditioning(block.take_block("conditioning"), len(chain))
    block.finish()
    try:
        return Branch(
            chain=chain,
            start=np.array(start),
            starts=np.array(starts).reshape(-1, 2),
            mean=np.array(mean).reshape(-1, 2),
            conditioning=how,
        )
    except ValueError as problem:
        block.fail("", str(problem))


def _conditioning_to_mapping(how: Conditioning) -> dict[str, Any]:
    return {
        "start": how.start.tolist(),
        "goal": how.goal.tolist(),
        "starts": how.starts.tolist(),
        "width": how.width,
        "reach": how.reach,
        "pivots": how.pivots.tolist(),
        # Four rows a stage, one stage after the other.
        "coefficients": how.coefficients.reshape(
            -1, how.coefficients.shape[-1]
        ).tolist(),
    }


def _take_conditioning(block: Block, stages: int) -> Conditioning:
    start, goal = (block.take_list(key, float, 2) for key in ("start", "goal"))
    starts = block.take_rows("starts", None, 2)
    width, reach = block.take("width", float), block.take("reach", float)
    pivots = block.take_rows("pivots", stages, 2)
    columns = 4 + len(starts)
    rows = block.take_rows("coefficients", NUMBERS * stages, columns)
    block.finish()
    try:
        return Conditioning(
            start=np.array(start),
            goal=np.array(goal),
            starts=np.array(starts).reshape(-1, 2),
            width=width,
            reach=reach,
            pivots=np.array(pivots),
            coefficients=np.array(rows).reshape(stages, NUMBERS, columns),
        )
    except ValueError as problem:
        block.fail("", str(problem))
