"""What a certificate says: a verdict, and what shows it."""

from dataclasses import dataclass
from typing import Literal

from bath_drake.field.critical_points import Kind

Verdict = Literal["proved", "refuted", "undecided"]
Cause = Literal["tangency", "degeneracy", "resolution", "uncertainty", "budget"]
Component = Literal["goal", "pocket"]


@dataclass(frozen=True)
class Box:
    """The points of N with x_min <= x <= x_max and y_min <= y <= y_max."""

    x_min: float
    x_max: float
    y_min: float
    y_max: float

    @property
    def centre(self) -> tuple[float, float]:
        """Its middle, rounded."""
        return (
            self.x_min + 0.5 * (self.x_max - self.x_min),
            self.y_min + 0.5 * (self.y_max - self.y_min),
        )

    @property
    def width(self) -> float:
        """Its longer side."""
        return max(self.x_max - self.x_min, self.y_max - self.y_min)

    def holds(self, x: float, y: float) -> bool:
        """Whether a point lies in it, its edges included."""
        return self.x_min <= x <= self.x_max and self.y_min <= y <= self.y_max


@dataclass(frozen=True)
class Enclosure:
    """A critical point of the field other than the goal.

    Attributes:
        x: Where, in N, to working precision.
        y: Where, in N, to working precision.
        kind: 'minimum', 'saddle' or 'maximum' of psi; 'degenerate' if the Hessian is
            singular to working precision.
        eigenvalues: Of psi's Hessian at (x, y), the lower one first.
        box: Proved to hold this critical point and no other, of this kind; None if
            that could not be proved (it is then a finding, not a fact).
    """

    x: float
    y: float
    kind: Kind
    eigenvalues: tuple[float, float]
    box: Box | None


@dataclass(frozen=True)
class Trap:
    """A minimum besides the goal.

    Attributes:
        box: Proved to lie in free space and to hold exactly one minimum.
        x: Where, in N, to working precision.
        y: Where, in N, to working precision.
        component: Whether the trap is in the goal's component of free space or in a
            pocket that obstacles close off (judged on a grid).
        start: A point from which the flow ends in the trap: one some way off where
            roll-outs showed it, else one right beside the minimum.
    """

    box: Box
    x: float
    y: float
    component: Component
    start: tuple[float, float]


@dataclass(frozen=True)
class Doubt:
    """A place where the proof got stuck.

    Attributes:
        box: Could be neither cleared nor refuted.
        cause: 'tangency': boundaries touch there to working precision; 'degeneracy':
            a critical point whose Hessian is nearly singular; 'resolution': the field
            changes within the smallest boxes; 'uncertainty': the obstacles' tolerances
            make the difference; 'budget': boxes ran out.
        remedy: The change that would decide it, in words.
    """

    box: Box
    cause: Cause
    remedy: str


@dataclass(frozen=True)
class Certificate:
    """Whether a field, or a region of it, is free of traps.

    Attributes:
        verdict: 'proved': almost every start (of the region, if one is given) reaches
            the goal and none touches a boundary. 'refuted': a minimum besides the goal
            exists, or the goal or a start is proved not to be free. 'undecided':
            neither was shown.
        reason: The verdict in words.
        critical_points: All that were found, the goal not among them; sorted by x.
        traps: The proved minima found, each enough for 'refuted'.
        doubts: Where the proof got stuck; empty unless 'undecided'.
        region: The level c of the certified set, the starts' components of
            {psi <= c}; None for all free space.
        apart: Whether {psi <= c} seems to have other components, with traps or doubts
            of their own, of which the certificate says nothing.
        notes: Facts that do not decide: obstacles that touch the rim or each other.
        witness: For 'refuted' a point that shows it, else None.
        boxes: How many boxes were looked at.
        seconds: Time taken.
    """

    verdict: Verdict
    reason: str
    critical_points: tuple[Enclosure, ...] = ()
    traps: tuple[Trap, ...] = ()
    doubts: tuple[Doubt, ...] = ()
    region: float | None = None
    apart: bool = False
    notes: tuple[str, ...] = ()
    witness: tuple[float, float] | None = None
    boxes: int = 0
    seconds: float = 0.0

    @property
    def passed(self) -> bool:
        """Whether freedom from traps is proved."""
        return self.verdict == "proved"
