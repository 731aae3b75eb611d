"""The way to the skin: in front of the start first, then along the normal.

The stand-off distance is the only thing that changes on the way down, so the
nozzle meets the skin's neighbourhood along the normal and never sideways.
"""

from dataclasses import dataclass
from enum import IntEnum


class Phase(IntEnum):
    """Where on its way the nozzle is. The value is the port's number."""

    REACH = 0
    DESCEND = 1
    WASH = 2


@dataclass(frozen=True, kw_only=True)
class ApproachLimits:
    """How the nozzle comes down to the skin.

    Attributes:
        far_standoff: Distance off the skin at which it lines up, m.
        standoff: Distance off the skin at which it washes, m.
        speed: Speed along the normal, m/s (at most 0.05 near people).
        lined_up: Position error under which it counts as there while far, m.
        arrived: ... and when it has come down, m.
        astray: Further off than this it lines up anew, far from the skin, m: after a
            retreat, or when the body has moved away from a robot that held.
    """

    far_standoff: float = 0.14
    standoff: float = 0.06
    speed: float = 0.05
    lined_up: float = 0.015
    arrived: float = 0.005
    astray: float = 0.05

    def __post_init__(self) -> None:
        """Raises ValueError unless all are positive and far is not near."""
        for name, value in vars(self).items():
            if not 0.0 < value < 10.0:
                raise ValueError(f"{name} must be in (0, 10), got {value}")
        if self.far_standoff < self.standoff:
            raise ValueError(
                f"far_standoff must be at least standoff ({self.standoff}), "
                f"got {self.far_standoff}"
            )


def next_approach(
    phase: Phase,
    standoff: float,
    position_error: float,
    dt: float,
    limits: ApproachLimits,
) -> tuple[Phase, float]:
    """Returns phase and stand-off (m) one step of `dt` seconds later.

    Args:
        phase: The phase now.
        standoff: The commanded distance off the skin now, m.
        position_error: Nozzle tip to its desired place, m.
        dt: The step, s.
        limits: Distances and speed.
    """
    if phase is not Phase.REACH and position_error > limits.astray:
        return Phase.REACH, limits.far_standoff
    if phase is Phase.REACH and position_error < limits.lined_up:
        return Phase.DESCEND, standoff
    if phase is Phase.DESCEND:
        standoff = max(limits.standoff, standoff - limits.speed * dt)
        if standoff == limits.standoff and position_error < limits.arrived:
            return Phase.WASH, standoff
    return phase, standoff
