"""What a search tried on its way: for pictures and for whoever wants to know why.

All of it follows from the steps that a checkpoint keeps, so a resumed run traces the
same; nothing that is learned depends on it.
"""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from bath_drake.learning.seeding import bends
from bath_drake.notation import FloatArray, IntArray

SIDES: Final = ("left", "right")
"""Of a stroke, seen along it."""


@dataclass(frozen=True, eq=False)
class Generation:
    """The members of a step of the search for a single field.

    Attributes:
        way: Which way of doing the stroke it is for, from 0.
        name: Of the step.
        costs: What it compares members by, in N, shape (n,), the best first.
        places: Of each member's obstacles, see `places`.
    """

    way: int
    name: str
    costs: FloatArray
    places: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class StageTrial:
    """One number of obstacles for one stage of a chain.

    Attributes:
        obstacles: The number.
        error: What was left of the stage's cost, in N.
        price: The error and the obstacles' price: what is compared.
        proved: Whether the field is.
    """

    obstacles: int
    error: float
    price: float
    proved: bool

    @property
    def rank(self) -> tuple[bool, float]:
        """Proved ones first, then the cheaper."""
        return not self.proved, self.price


@dataclass(frozen=True, eq=False)
class PlanTrial:
    """One way of cutting a stroke into stages.

    Attributes:
        way: Which way of doing the stroke it is for, from 0.
        cuts: Indices of the mean, the ends included.
        pieces: Of the aligned demonstrations, (D, T_k, 2) for each stage.
        stages: What was tried for each stage, in turn.
        evaluations: Members' roll-outs that it took.
    """

    way: int
    cuts: tuple[int, ...]
    pieces: tuple[FloatArray, ...]
    stages: tuple[tuple[StageTrial, ...], ...]
    evaluations: int

    @property
    def chosen(self) -> tuple[StageTrial, ...]:
        """The trial that each stage's field comes from."""
        return tuple(min(trials, key=lambda t: t.rank) for trials in self.stages)


@dataclass(eq=False)
class Trace:
    """All that was tried.

    Attributes:
        generations: Of the single fields' searches.
        plans: Of the chains, each with the criterion that chose among them, the less
            the better (`judge.Judged.rank`).
    """

    generations: list[Generation] = field(default_factory=list)
    plans: list[tuple[PlanTrial, tuple[bool, float]]] = field(default_factory=list)

    def plan_of(self, way: int) -> PlanTrial | None:
        """The best plan of a way, if chains were tried for it."""
        found = [entry for entry in self.plans if entry[0].way == way]
        return min(found, key=lambda entry: entry[1])[0] if found else None

    def generations_of(self, way: int) -> list[Generation]:
        """The steps of a way's search for a single field."""
        return [g for g in self.generations if g.way == way]


def places(curve: FloatArray, centres: FloatArray) -> IntArray:
    """Beside which part of a stroke, and on which side, obstacles stand.

    A part is what is nearest to one of the stroke's bends.

    Args:
        curve: The stroke, shape (T, 2).
        centres: Shape (n, 2).

    Returns:
        2 i for the left of part i, 2 i + 1 for its right, shape (n,).
    """
    middles = np.array([at for at, _ in bends(curve)], dtype=np.int64)
    apart = np.linalg.norm(centres[:, None] - curve, axis=-1)
    near = np.clip(apart.argmin(axis=1), 1, len(curve) - 2)
    tangent = curve[near + 1] - curve[near - 1]
    away = centres - curve[near]
    left = tangent[:, 0] * away[:, 1] - tangent[:, 1] * away[:, 0] > 0.0
    parts = np.searchsorted((middles[1:] + middles[:-1]) // 2, near)
    return np.asarray(2 * parts + np.where(left, 0, 1))
