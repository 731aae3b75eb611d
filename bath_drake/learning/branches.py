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
from bath_drake.learning.seeding import bends, beside
from bath_drake.notation import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Branch:
    """Obstacles and the decisions that put them there.

    Attributes:
        rows: Shape (Q, 5): centre, ln a, ln b, angle.
        kappa: The best with them.
        mismatch: How badly the flow's direction fits, see `Matcher`.
        places: Sorted; 2 i for the left of the stroke's part i, 2 i + 1 for its right.
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
        middles = [at for at, _ in bends(problem.strokes.mean)]
        self._edges = (np.array(middles[1:]) + np.array(middles[:-1])) // 2

    def root(self, member: FloatArray | None = None) -> Branch:
        """The branch that a member (5 Q + 1,) stands on; None has no obstacle."""
        if member is None:
            return Branch(np.empty((0, genome.GENES)), 1.0, np.inf, ())
        rows = member[:-1].reshape(-1, genome.GENES)
        places = tuple(sorted(self._places(rows[:, :2]).tolist()))
        return Branch(rows, float(np.exp(member[-1])), np.inf, places)

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
        sides = rng.choice([-1.0, 1.0], self._pool)
        choice = beside(at, sides, self._problem, rng)
        places = self._places(choice[:, :2])
        grown = []
        for branch in branches:
            mismatches, kappas = self._matcher.rate(branch.rows, choice, begin=begin)
            for place in np.unique(places):
                there = np.flatnonzero(places == place)
                best = there[int(np.argmin(mismatches[there]))]
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

    def _places(self, centres: FloatArray) -> IntArray:
        """Beside which part of the stroke, and on which side, centres (n, 2) are."""
        curve = self._problem.strokes.mean
        apart = np.linalg.norm(centres[:, None] - curve, axis=-1)
        near = np.clip(apart.argmin(axis=1), 1, len(curve) - 2)
        tangent = curve[near + 1] - curve[near - 1]
        away = centres - curve[near]
        left = tangent[:, 0] * away[:, 1] - tangent[:, 1] * away[:, 0] > 0.0
        parts = np.searchsorted(self._edges, near)
        return np.asarray(2 * parts + np.where(left, 0, 1))
