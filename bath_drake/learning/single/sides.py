"""On which side of the stroke each obstacle stands: a tree of decisions.

The paper leaves the choice between left and right open (Sec. VI). Here every bend of
the stroke offers two places, within it and without, and an obstacle more is one such
decision more. Branches are rated by the flow's direction along the stroke, which
needs no roll-out; the best few of each depth go on.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.learning import genome
from bath_drake.learning.cost import LearningProblem
from bath_drake.learning.matching import Matcher
from bath_drake.learning.seeding import beside
from bath_drake.learning.trace import places
from bath_drake.notation import FloatArray


@dataclass(frozen=True, eq=False)
class Branch:
    """Obstacles and the decisions that put them there.

    Attributes:
        rows: Shape (Q, 5): centre, ln a, ln b, angle.
        kappa: The best with them.
        mismatch: How badly the flow's direction fits, see `Matcher`.
        places: Sorted, see `bath_drake.learning.trace.places`.
    """

    rows: FloatArray
    kappa: float
    mismatch: float
    places: tuple[int, ...]

    @property
    def member(self) -> FloatArray:
        """As the learner's vector, shape (5 Q + 1,)."""
        return np.append(self.rows.ravel(), np.log(self.kappa))


class Tree:
    """Grows branches by one obstacle at a time."""

    def __init__(self, problem: LearningProblem, pool: int) -> None:
        """``pool``: how many places and shapes a new obstacle is chosen among."""
        self._problem = problem
        self._matcher = Matcher(problem)
        self._pool = pool

    def root(self, member: FloatArray | None = None) -> Branch:
        """The branch that a member (5 Q + 1,) stands on; None has no obstacle."""
        if member is None:
            return Branch(np.empty((0, genome.GENES)), 1.0, np.inf, ())
        rows = member[:-1].reshape(-1, genome.GENES)
        known = places(self._problem.strokes.mean, rows[:, :2]).tolist()
        return Branch(rows, float(np.exp(member[-1])), np.inf, tuple(sorted(known)))

    def grow(
        self,
        branches: list[Branch],
        width: int,
        rng: np.random.Generator,
        begin: float = 0.0,
    ) -> list[Branch]:
        """The best ``width`` branches of one obstacle more, no two in the same places.

        Every branch is tried with the best obstacle at each place of the stroke, or
        of what is behind the share ``begin`` of it, which is all that counts then.
        """
        curve = self._problem.strokes.mean
        first = min(int(begin * len(curve)), len(curve) - 8)
        at = rng.integers(max(first, 2), len(curve) - 2, self._pool)
        sides = rng.choice(np.array([-1.0, 1.0]), self._pool)
        choice = beside(at, sides, self._problem, rng)
        there = places(curve, choice[:, :2])
        grown = []
        for branch in branches:
            mismatches, kappas = self._matcher.rate(branch.rows, choice, begin=begin)
            for place in np.unique(there):
                at_place = np.flatnonzero(there == place)
                best = at_place[int(np.argmin(mismatches[at_place]))]
                grown.append(
                    Branch(
                        np.concatenate([branch.rows, choice[best : best + 1]]),
                        float(kappas[best]),
                        float(mismatches[best]),
                        tuple(sorted((*branch.places, int(place)))),
                    )
                )
        grown.sort(key=lambda b: b.mismatch)
        kept: dict[tuple[int, ...], Branch] = {}
        for branch in grown:
            kept.setdefault(branch.places, branch)
        return list(kept.values())[:width]
