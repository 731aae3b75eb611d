"""What the certificate of a chain says: its stages', its gates', and the whole."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

from bath_drake.certificate.result import Certificate, Doubt, Enclosure, Verdict

Arrival = Literal["every", "almost every", "not shown"]

SIMULATED: Final = (
    "steps: what is proved is proved of the flow's own curves; roll-outs and the "
    "controller take guarded steps along it",
    "the robot: its size, its lag and what it does between two commands",
    "the world: obstacles that move, a body that is seen late or wrongly",
)
"""What no certificate proves, only the simulation and its guards cover."""


@dataclass(frozen=True)
class Handover:
    """The passage from one stage to the next, through a gate.

    Attributes:
        verdict: 'proved': the goal lies in the gate's interior, the closed gate in the
            next field's free space, and the next field, if it is proved, brings almost
            every motion that enters it to the next goal. 'refuted': a point of the gate
            is proved not to be free. 'undecided': neither was shown.
        reason: The verdict in words.
        clearance: Proved lower bound of the least beta_j of the next field over the
            closed gate, positive; None if there is none.
        level: Proved upper bound of the next field's psi over the gate; None as above.
        arrival: Which motions that enter the gate the next stage brings to its goal:
            'every' if no other critical point lies as low as the gate reaches, else
            'almost every'; 'not shown' where that stage is not proved, or a curve that
            ends at a saddle, of this or a later stage, may run along the boundary.
        witness: For 'refuted' a point of the gate that shows it, else None.
        doubts: Where the proof got stuck.
        boxes: How many boxes were looked at.
    """

    verdict: Verdict
    reason: str
    clearance: float | None = None
    level: float | None = None
    arrival: Arrival = "not shown"
    witness: tuple[float, float] | None = None
    doubts: tuple[Doubt, ...] = ()
    boxes: int = 0


@dataclass(frozen=True)
class ChainCertificate:
    """Whether a chain brings almost every start to its last goal.

    Attributes:
        stages: Each field's certificate, of all its free space or of a region.
        handovers: Of each gate.
        seconds: Time taken.

    Raises:
        ValueError: There is no stage, or not one gate less than stages.
    """

    stages: tuple[Certificate, ...]
    handovers: tuple[Handover, ...] = ()
    seconds: float = 0.0

    def __post_init__(self) -> None:
        if len(self.handovers) != len(self.stages) - 1:
            raise ValueError(
                f"{len(self.stages)} stages need {max(0, len(self.stages) - 1)} "
                f"handovers, got {len(self.handovers)}"
            )

    @property
    def verdict(self) -> Verdict:
        """'proved' if every part is, 'refuted' if one is, else 'undecided'.

        'proved': almost every motion from the first stage's free space (or region)
        reaches the last goal, and none touches a boundary.
        """
        return _worst([part.verdict for part in self._parts])

    @property
    def passed(self) -> bool:
        """Whether the chain is proved."""
        return self.verdict == "proved"

    @property
    def reason(self) -> str:
        """The verdict in words."""
        if len(self.stages) == 1:
            return self.stages[0].reason
        if self.passed:
            return (
                f"{len(self.stages)} fields proved, each gate free in the next one; "
                f"almost every start in the first field's "
                f"{'free space' if self.region is None else 'region'} "
                "reaches the last goal"
            )
        names = [f"stage {k}" for k in range(len(self.stages))]
        names += [f"gate {k}" for k in range(len(self.handovers))]
        return "; ".join(
            f"{name}: {part.reason}"
            for name, part in zip(names, self._parts, strict=True)
            if part.verdict == self.verdict
        )

    @property
    def region(self) -> float | None:
        """The first stage's level, if only a start's region is certified of it."""
        return self.stages[0].region

    @property
    def witness(self) -> tuple[float, float] | None:
        """For 'refuted' a point that shows it, else None."""
        shown = (p.witness for p in self._parts if p.witness is not None)
        return next(shown, None)

    @property
    def critical_points(self) -> tuple[Enclosure, ...]:
        """Those of all stages, in turn."""
        return tuple(point for stage in self.stages for point in stage.critical_points)

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """Where the proofs of the parts got stuck."""
        return tuple(doubt for part in self._parts for doubt in part.doubts)

    @property
    def boxes(self) -> int:
        """How many boxes were looked at."""
        return sum(part.boxes for part in self._parts)

    @property
    def simulated(self) -> tuple[str, ...]:
        """What is not proved but only simulated or assumed, in words."""
        return SIMULATED

    @property
    def _parts(self) -> tuple[Certificate | Handover, ...]:
        return (*self.stages, *self.handovers)


def whole_verdict(certificates: Sequence[ChainCertificate]) -> tuple[Verdict, str]:
    """Verdict and reason of several chains together, the branches of a skill.

    Raises:
        ValueError: There is no chain.
    """
    if not certificates:
        raise ValueError("there is no chain")
    verdict = _worst([part.verdict for part in certificates])
    if len(certificates) == 1:
        return verdict, certificates[0].reason
    if verdict == "proved":
        return verdict, (
            f"{len(certificates)} branches proved: of each, almost every start in the "
            "first field's free space reaches the last goal"
        )
    reasons = [
        f"branch {b}: {part.reason}"
        for b, part in enumerate(certificates)
        if part.verdict == verdict
    ]
    return verdict, "; ".join(reasons)


def _worst(verdicts: list[Verdict]) -> Verdict:
    order: tuple[Verdict, ...] = ("refuted", "undecided", "proved")
    return min(verdicts, key=order.index)
