"""What breaks in a run besides its camera, as a schema for scenario files."""

import math
from dataclasses import dataclass, field

from bath_drake.perception.faults import Spell, check_spell

KINDS = ("nan", "constant", "offset", "ramp", "frozen", "drift")


@dataclass(kw_only=True)
class SignalFault(Spell):
    """A vector port whose readers get something else for a while.

    One port may have several, one after the other.

    Kinds: `nan`; `constant`, the value itself; `offset`, the value more; `ramp`, the
    value more with every second; `frozen`, what it was when the fault began; `drift`,
    all of it frozen, but for the elements, which ramp from there.
    """

    port: str = ""  # system.port, an output
    kind: str = "nan"
    value: float = 0.0
    elements: list[int] = field(default_factory=list)  # none given: all


@dataclass(kw_only=True)
class AreaFault(Spell):
    """A restricted area that nobody sees come: an ellipse in N from one moment on."""

    centre: list[float] = field(default_factory=lambda: [0.0, 0.0])
    semi_axes: list[float] = field(default_factory=lambda: [0.1, 0.1])
    angle: float = 0.0  # rad, counter-clockwise
    from_tool: bool = False  # the centre counts from where the nozzle is as it begins
    velocity: list[float] = field(default_factory=lambda: [0.0, 0.0])  # 1/s


@dataclass(kw_only=True)
class FaultScript:
    """All of them, in a scenario's `faults`; the camera's are `scene.camera.faults`."""

    signals: list[SignalFault] = field(default_factory=list)
    areas: list[AreaFault] = field(default_factory=list)

    @property
    def any(self) -> bool:
        """Whether there is any fault at all."""
        return bool(self.signals or self.areas)


# What leaves a guard goes on as it is: a fault behind it would prove nothing.
GUARDS = ("canonical_guard", "joint_guard")
_LARGEST = 1e300


def check_script(script: FaultScript) -> None:
    """Raises ValueError naming the key that makes no fault, and what is allowed."""
    for k, fault in enumerate(script.signals):
        check_spell(f"signals[{k}]", fault)
        _check_signal(f"signals[{k}]", fault)
    for k, fault in enumerate(script.signals):
        for before in script.signals[:k]:
            if fault.port == before.port and _overlap(fault, before):
                raise ValueError(
                    f"signals[{k}].port: found {fault.port} once more, allowed one "
                    "fault of a port at a time"
                )
    for k, area in enumerate(script.areas):
        check_spell(f"areas[{k}]", area)
        for name in ("centre", "semi_axes", "velocity"):
            values = getattr(area, name)
            if len(values) != 2 or not all(map(math.isfinite, values)):
                raise ValueError(
                    f"areas[{k}].{name}: found {values}, allowed two finite numbers"
                )
        if not min(area.semi_axes) > 0.0:
            raise ValueError(
                f"areas[{k}].semi_axes: found {area.semi_axes}, allowed above 0"
            )
        if not math.isfinite(area.angle):
            raise ValueError(
                f"areas[{k}].angle: found {area.angle}, allowed a finite number"
            )


def _overlap(one: Spell, other: Spell) -> bool:
    return one.begin < other.end and other.begin < one.end


def _check_signal(key: str, fault: SignalFault) -> None:
    system, _, port = fault.port.partition(".")
    if not (system and port) or system in GUARDS:
        raise ValueError(
            f"{key}.port: found {fault.port[:60]!r}, allowed SYSTEM.PORT, an output "
            f"of no guard"
        )
    if fault.kind not in KINDS:
        raise ValueError(
            f"{key}.kind: found {fault.kind[:40]!r}, allowed {', '.join(KINDS)}"
        )
    if not abs(fault.value) <= _LARGEST:
        raise ValueError(
            f"{key}.value: found {fault.value}, allowed a number up to {_LARGEST:g}"
        )
    if not all(k >= 0 for k in fault.elements):
        raise ValueError(
            f"{key}.elements: found {fault.elements}, allowed numbers from 0"
        )
