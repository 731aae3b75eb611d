"""One way of doing a stroke: a chain for the mean start, and how ends change it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.composition.chain import Chain
from bath_drake.composition.clearing import cleared
from bath_drake.composition.conditioning import Conditioning
from bath_drake.notation import FloatArray


@dataclass(frozen=True, eq=False)
class Branch:
    """What demonstrations that go the same way have taught.

    Attributes:
        chain: For the mean start and the goal that was learned.
        start: The demonstrations' mean start, shape (2,), in N.
        starts: Their own starts, shape (D, 2).
        mean: Their mean, what the motion is compared with, shape (T, 2).
        conditioning: How the chain's stages follow start and goal; None if they do
            not (only the last field's goal then moves).

    Raises:
        ValueError: A shape is wrong, a number is not finite, or the conditioning is
            for another number of stages.
    """

    chain: Chain
    start: FloatArray
    starts: FloatArray
    mean: FloatArray
    conditioning: Conditioning | None = None

    def __post_init__(self) -> None:
        for name in ("start", "starts", "mean"):
            value = np.array(getattr(self, name), dtype=np.float64)
            if not np.isfinite(value).all():
                raise ValueError(f"{name} must be finite, got {value.tolist()}")
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        if self.start.shape != (2,):
            raise ValueError(f"start must be two numbers, got {self.start}")
        for name, least in (("starts", 1), ("mean", 2)):
            shape = getattr(self, name).shape
            if len(shape) != 2 or shape[1] != 2 or shape[0] < least:
                raise ValueError(f"{name} has shape {shape}, not (n >= {least}, 2)")
        stages = len(self.chain)
        if self.conditioning is not None and len(self.conditioning.pivots) != stages:
            raise ValueError(
                f"the conditioning is for {len(self.conditioning.pivots)} stages, "
                f"the chain has {stages}"
            )

    def chain_for(self, start: ArrayLike, goal: ArrayLike | None = None) -> Chain:
        """The chain for a start and a goal (2,), in N; the goal learned if None.

        A chain like any other, to be certified anew (`composition.certify`). Gates
        that the moves bring into an obstacle are drawn in (`composition.clearing`).

        Raises:
            ValueError: Start or goal are not two finite numbers.
        """
        if self.conditioning is not None:
            moved = self.chain.moved(self.conditioning.similarities(start, goal))
            return cleared(moved)
        if goal is None:
            return self.chain
        last = self.chain.fields[-1].with_goal(np.asarray(goal, dtype=np.float64))
        return replace(self.chain, fields=(*self.chain.fields[:-1], last))


def nearest_branch(branches: Sequence[Branch], start: ArrayLike) -> Branch:
    """The branch with the demonstration that starts nearest to ``start`` (2,)."""
    away = [np.hypot(*(b.starts - np.asarray(start)).T).min() for b in branches]
    return branches[int(np.argmin(away))]
