"""A learned skill: everything that reproducing it needs."""

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.composition.branch import Branch, nearest_branch
from bath_drake.composition.chain import Chain
from bath_drake.demonstrations.canonical import CanonicalFrame
from bath_drake.field.navigation import NavigationField
from bath_drake.notation import FloatArray
from bath_drake.rhythm.limit_cycle import LimitCycle


@dataclass(frozen=True, eq=False)
class Skill:
    """Chains of fields, where they start, and where both came from.

    Attributes:
        branches: One or more ways of doing the stroke, in N; of demonstrations that
            go different ways each way has one.
        seed: Of the learner's random generator.
        config: The learner's configuration, plain values.
        demonstration_hashes: SHA-256 of every demonstration file, in order.
        canonical: The map between the demonstrations' coordinates and N.
        scale: Longest side of the demonstrations' joint box, in N; Fréchet
            figures are divided by it.
        frechet: Figures as in `LearningResult.frechet`.
        certificate: What was proved of it, plain values (see
            `bath_drake.certificate_file`).
        finished: Whether the learner came to its end; False for the best it had when
            it was interrupted.
        periodic: Circles or scrubbing on top of the motion; None without.

    Raises:
        ValueError: There is no branch, or the scale is not positive.
    """

    branches: tuple[Branch, ...]
    seed: int
    config: dict[str, Any]
    demonstration_hashes: tuple[str, ...]
    canonical: CanonicalFrame
    scale: float
    frechet: dict[str, float] = dataclasses.field(default_factory=dict)
    certificate: dict[str, Any] = dataclasses.field(default_factory=dict)
    finished: bool = True
    periodic: LimitCycle | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "branches", tuple(self.branches))
        if not self.branches:
            raise ValueError("a skill needs at least one branch, got none")
        if not (0.0 < self.scale < np.inf):
            raise ValueError(f"scale must be positive and finite, got {self.scale}")

    @property
    def chain(self) -> Chain:
        """The first branch's, for its mean start."""
        return self.branches[0].chain

    @property
    def chains(self) -> tuple[Chain, ...]:
        """Each branch's, for its mean start."""
        return tuple(branch.chain for branch in self.branches)

    @property
    def start(self) -> FloatArray:
        """The first branch's mean start, shape (2,), in N."""
        return self.branches[0].start

    @property
    def mean_demonstration(self) -> FloatArray:
        """The first branch's at equal shares of arc length, shape (T, 2), in N."""
        return self.branches[0].mean

    @property
    def obstacle_count(self) -> int:
        """Virtual obstacles of all fields of all branches."""
        return sum(branch.chain.obstacle_count for branch in self.branches)

    @property
    def is_single(self) -> bool:
        """Whether one field is all there is."""
        return len(self.branches) == 1 and len(self.chain) == 1

    @property
    def field(self) -> NavigationField:
        """The field of a single skill.

        Raises:
            ValueError: The skill is composed.
        """
        if not self.is_single:
            count = sum(len(branch.chain) for branch in self.branches)
            raise ValueError(
                f"a composed skill of {count} fields has no single field; see chain_for"
            )
        return self.chain.fields[0]

    def branch_for(self, start: ArrayLike) -> Branch:
        """The branch with the demonstration that starts nearest to ``start`` (2,)."""
        return nearest_branch(self.branches, start)

    def chain_for(self, start: ArrayLike, goal: ArrayLike | None = None) -> Chain:
        """The chain for a start and a goal (2,), in N; the goal learned if None.

        A goal that is given is the last field's to the last bit, wherever conditioning
        would have moved it.

        Raises:
            ValueError: Start or goal are not two finite numbers.
        """
        chain = self.branch_for(start).chain_for(start, goal)
        if goal is None or np.array_equal(chain.goal, goal):
            return chain
        last = chain.fields[-1].with_goal(np.asarray(goal, dtype=np.float64))
        return dataclasses.replace(chain, fields=(*chain.fields[:-1], last))
