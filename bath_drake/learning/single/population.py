"""Members of different sizes in one population."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bath_drake.learning import genome
from bath_drake.learning.checkpoint import Arrays
from bath_drake.learning.seeding import MAX_OBSTACLES
from bath_drake.notation import FloatArray

_ALIKE = 0.005


@dataclass(frozen=True, eq=False)
class Population:
    """Members and what they cost, the best first.

    Attributes:
        members: Vectors (5 Q + 1,), each with its own Q.
        costs: Finite, shape (n,).
    """

    members: tuple[FloatArray, ...]
    costs: FloatArray

    @classmethod
    def of(cls, members: Sequence[FloatArray], costs: FloatArray) -> "Population":
        """Sorts members by their costs (n,) and drops those of no finite cost."""
        order = [i for i in np.argsort(costs, kind="stable") if np.isfinite(costs[i])]
        return cls(tuple(members[i] for i in order), costs[order])

    def __add__(self, other: "Population") -> "Population":
        costs = np.concatenate([self.costs, other.costs])
        return Population.of((*self.members, *other.members), costs)

    def distinct(self, size: int) -> "Population":
        """The best ``size`` that are not copies of a better one.

        Members of one basin have nearly one cost after their descent: a cost within
        0.5 % of a better member's with as many obstacles is taken for a copy.
        """
        kept: list[int] = []
        for i, (x, cost) in enumerate(zip(self.members, self.costs, strict=True)):
            alike = (
                len(x) == len(self.members[k])
                and cost - self.costs[k] <= _ALIKE * abs(cost)
                for k in kept
            )
            if len(kept) < size and not any(alike):
                kept.append(i)
        return Population(tuple(self.members[i] for i in kept), self.costs[kept])

    def pack(self) -> Arrays:
        """As arrays of one size, for a checkpoint."""
        padded = np.full((len(self.members), genome.GENES * MAX_OBSTACLES + 1), np.nan)
        for row, member in zip(padded, self.members, strict=True):
            row[: len(member)] = member
        return {"members": padded, "costs": self.costs}

    @classmethod
    def unpack(cls, arrays: Arrays) -> "Population":
        """What `pack` gave, bit by bit."""
        members = tuple(row[~np.isnan(row)] for row in arrays["members"])
        return cls(members, arrays["costs"])
