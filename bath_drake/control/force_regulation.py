"""How hard the sponge presses: an admittance along the skin's normal.

The surface estimate says where the skin is and how it moves; what is left, and how far
skin and sponge give way, the measured force tells. The stand-off that is asked for goes
in or out with a speed in proportion to the force that is missing (an admittance without
mass or spring; Villani and De Schutter, "Force Control", Springer Handbook of Robotics,
2nd ed., 2016), bounded in speed and way.
"""

import math
from dataclasses import dataclass, replace
from enum import IntEnum

from bath_drake.control.approach import Phase


class Touch(IntEnum):
    """Whether there is skin against the sponge. The value is the port's number."""

    AWAY = 0  # not asked for, or held
    SEEK = 1  # on the way in, nothing felt yet
    PRESS = 2  # felt; the force is regulated


@dataclass(frozen=True, kw_only=True)
class ForceLimits:
    """How the force is regulated.

    Attributes:
        force: What to press with, N; 3 to 5 is what washing needs.
        admittance: Speed along the normal for each newton that is missing, m/(s N).
        speed: Greatest speed along the normal on top of the skin's own, m/s.
        seek_speed: Speed in while nothing is felt, m/s.
        deepest: How far in from the stand-off before contact it may ask, m.
        felt: Force above which it is touching, N; several times the sensor's noise.
        lost: Force below which it is not, N.
        patience: How long the force may be lost before washing stops, s.
        settled: Washing begins once the force is so near to what is asked for, N.
        ramp: How fast what is asked for grows from what was felt, N/s.
    """

    force: float = 4.0
    admittance: float = 0.01
    speed: float = 0.03
    seek_speed: float = 0.01
    deepest: float = 0.025
    felt: float = 0.8
    lost: float = 0.3
    patience: float = 0.2
    settled: float = 0.5
    ramp: float = 8.0

    def __post_init__(self) -> None:
        """Raises ValueError naming what is out of its range.

        More than 5 N is never asked for, and nothing is faster than 0.05 m/s.
        """
        for name, high in (
            ("force", 5.0),
            ("admittance", 0.05),
            ("speed", 0.05),
            ("seek_speed", 0.05),
            ("deepest", 0.05),
            ("felt", 2.0),
            ("lost", 2.0),
            ("patience", 10.0),
            ("settled", 5.0),
            ("ramp", 100.0),
        ):
            value = getattr(self, name)
            if not (math.isfinite(value) and 0.0 < value <= high):
                raise ValueError(f"{name} must be in (0, {high:g}], got {value}")
        if not self.lost < self.felt < self.force:
            raise ValueError(
                "lost, felt and force must rise, got "
                f"{self.lost}, {self.felt} and {self.force}"
            )


@dataclass(frozen=True, kw_only=True)
class ForceState:
    """What the regulator remembers.

    Attributes:
        touch: Whether there is skin against the sponge.
        depth: How far in it asks to be from the stand-off before contact, m.
        asked: The force that is asked for now, N.
        washing: Whether the force has settled since the last contact.
        lost_for: For how long no force has been felt, s.
    """

    touch: Touch = Touch.AWAY
    depth: float = 0.0
    asked: float = 0.0
    washing: bool = False
    lost_for: float = 0.0


def next_force_state(
    state: ForceState,
    force: float,
    phase: Phase,
    *,
    held: bool,
    dt: float,
    limits: ForceLimits,
) -> ForceState:
    """Returns the state `dt` seconds later.

    Args:
        state: Now.
        force: Measured, along the tool into the skin, N; positive presses.
        phase: The approach's: only where it has come down there is anything to seek.
        held: Whether the guard lets nothing pass: then all begins anew, away from the
            skin.
        dt: The step, s.
        limits: What to keep to.

    A force that is no number is taken for one that is too great: the sponge goes out.
    """
    if held or phase is not Phase.WASH:
        return ForceState()
    if not math.isfinite(force):
        depth = max(state.depth - limits.speed * dt, 0.0)
        return replace(state, depth=depth, washing=False)
    touch = state.touch
    if touch is not Touch.PRESS:
        if force < limits.felt:
            depth = min(state.depth + limits.seek_speed * dt, limits.deepest)
            return ForceState(touch=Touch.SEEK, depth=depth)
        asked = min(force, limits.force)
        return ForceState(touch=Touch.PRESS, depth=state.depth, asked=asked)
    lost_for = state.lost_for + dt if force < limits.lost else 0.0
    if lost_for > limits.patience:
        return ForceState(touch=Touch.SEEK, depth=state.depth)
    asked = min(state.asked + limits.ramp * dt, limits.force)
    wanted = limits.admittance * (asked - force)
    # Skin that went away is followed no faster than it was sought.
    fastest = limits.seek_speed if force < limits.lost else limits.speed
    speed = max(-limits.speed, min(fastest, wanted))
    # The bound is on what is integrated, so nothing winds up beyond it.
    depth = max(0.0, min(limits.deepest, state.depth + speed * dt))
    there = asked == limits.force and abs(force - asked) < limits.settled
    return ForceState(
        touch=Touch.PRESS,
        depth=depth,
        asked=asked,
        washing=state.washing or there,
        lost_for=lost_for,
    )


def touch_phase(state: ForceState, phase: Phase) -> Phase:
    """The phase as all others see it: who has come down washes once it presses."""
    if phase is Phase.WASH and not state.washing:
        return Phase.DESCEND
    return phase
