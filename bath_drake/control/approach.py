"""The way to the skin: in front of the start first, then along the normal.

The stand-off distance is the only thing that changes on the way down, so the
nozzle meets the skin's neighbourhood along the normal and never sideways. It goes down
from rest to rest with bounded speed, acceleration and jerk, and never below its end.
"""

from dataclasses import dataclass, replace
from enum import IntEnum

from bath_drake.safety.smooth_way import SmoothWay


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
        acceleration: Of the way down, m/s^2.
        jerk: Of the way down, m/s^3.
        lined_up: Position error under which it counts as there while far, m.
        arrived: ... and when it has come down, m.
        astray: Further off than this it lines up anew, far from the skin, m: after a
            retreat, or when the body has moved away from a robot that held.
    """

    far_standoff: float = 0.14
    standoff: float = 0.06
    speed: float = 0.05
    acceleration: float = 0.25
    jerk: float = 2.5
    lined_up: float = 0.015
    arrived: float = 0.005
    astray: float = 0.05

    def __post_init__(self) -> None:
        """Raises ValueError unless all are positive and far is not near."""
        for name, value in vars(self).items():
            if not 0.0 < value < 100.0:
                raise ValueError(f"{name} must be in (0, 100), got {value}")
        if self.far_standoff < self.standoff:
            raise ValueError(
                f"far_standoff must be at least standoff ({self.standoff}), "
                f"got {self.far_standoff}"
            )


@dataclass(frozen=True, kw_only=True)
class Approach:
    """Where on its way it is.

    Attributes:
        phase: The phase.
        standoff: The commanded distance off the skin, m.
        begun: The stand-off from which the way down began, at rest, m.
        seconds: For how long it has been on that way, s.
    """

    phase: Phase = Phase.REACH
    standoff: float
    begun: float
    seconds: float = 0.0

    @staticmethod
    def far(limits: ApproachLimits) -> "Approach":
        """The first: it lines up, far from the skin."""
        return Approach(standoff=limits.far_standoff, begun=limits.far_standoff)


def held(now: Approach) -> Approach:
    """What is left of an approach that stands: it goes on from rest, from here."""
    return replace(now, begun=now.standoff, seconds=0.0)


def next_approach(
    now: Approach, position_error: float, dt: float, limits: ApproachLimits
) -> Approach:
    """Returns the approach one step of `dt` seconds later.

    Args:
        now: Phase and stand-off.
        position_error: Nozzle tip to its desired place, m.
        dt: The step, s.
        limits: Distances, speed, acceleration and jerk.
    """
    if now.phase is not Phase.REACH and position_error > limits.astray:
        return Approach.far(limits)
    if now.phase is Phase.REACH and position_error < limits.lined_up:
        return replace(held(now), phase=Phase.DESCEND)
    if now.phase is not Phase.DESCEND:
        return now
    way = SmoothWay(
        distance=max(0.0, now.begun - limits.standoff),
        speed=limits.speed,
        acceleration=limits.acceleration,
        jerk=limits.jerk,
    )
    seconds = now.seconds + dt
    there = seconds >= way.seconds
    standoff = limits.standoff if there else now.begun - way.travelled(seconds)
    arrived = there and position_error < limits.arrived
    return replace(
        now,
        phase=Phase.WASH if arrived else now.phase,
        standoff=standoff,
        seconds=seconds,
    )
