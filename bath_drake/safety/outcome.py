"""How a run ends."""

from dataclasses import dataclass
from enum import Enum, auto


class LoopOutcome(Enum):
    """What the loop has come to."""

    RUNNING = auto()
    GOAL_REACHED = auto()
    TIMED_OUT = auto()
    TOO_CLOSE = auto()


@dataclass(frozen=True, kw_only=True)
class LoopBounds:
    """What a run must keep to.

    Attributes:
        duration: Longest run, s.
        goal_tolerance: Canonical distance that counts as arrived.
        min_clearance: Least distance of the nozzle off the seen skin, m.
    """

    duration: float = 60.0
    goal_tolerance: float = 0.02
    min_clearance: float = 0.02

    def __post_init__(self) -> None:
        """Raises ValueError unless all are positive and finite."""
        for name, value in vars(self).items():
            if not 0.0 < value < float("inf"):
                raise ValueError(f"{name} must be positive and finite, got {value}")


def judge_loop(
    *,
    time: float,
    washing: bool,
    goal_distance: float,
    clearance: float,
    bounds: LoopBounds,
) -> LoopOutcome:
    """Judges one instant; a violated bound goes before success.

    Args:
        time: s since the start.
        washing: Whether the nozzle is down at the skin.
        goal_distance: Of the washed point, in N.
        clearance: Nozzle tip off the seen skin along its normal, m.
        bounds: What to keep to.
    """
    if clearance < bounds.min_clearance:
        return LoopOutcome.TOO_CLOSE
    if washing and goal_distance < bounds.goal_tolerance:
        return LoopOutcome.GOAL_REACHED
    # Event times are multiples of a period, up to rounding.
    if time >= bounds.duration - 1e-9:
        return LoopOutcome.TIMED_OUT
    return LoopOutcome.RUNNING
