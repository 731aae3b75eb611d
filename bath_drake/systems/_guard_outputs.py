"""The ports through which both guards say what they do and why."""

from collections.abc import Callable
from typing import Any

from pydrake.systems.framework import BasicVector, LeafSystem

from bath_drake.safety.guard_ticks import CanonicalTick, JointTick
from bath_drake.safety.reasons import Reason
from bath_drake.systems._ports import set_vector

_Tick = CanonicalTick | JointTick


def declare_guard_outputs(
    system: LeafSystem, last_tick: Callable[[Any], _Tick], ticket: Any
) -> None:
    """Declares `guard_mode`, `guard_reason` and their like.

    Args:
        system: Gets the ports.
        last_tick: What its last update came to, from its context.
        ticket: Of the state that this is.
    """
    outputs: dict[str, tuple[int, Callable[[_Tick], Any]]] = {
        "guard_mode": (1, lambda tick: [float(tick.state.mode)]),
        "guard_reason": (1, lambda tick: [float(tick.state.reason)]),
        "present_reason": (1, lambda tick: [float(tick.state.present)]),
        "guard_counts": (len(Reason), lambda tick: tick.state.counts),
        "limited_count": (1, lambda tick: [float(tick.limited)]),
    }
    for name, (size, told) in outputs.items():

        def calc(context: Any, output: BasicVector, told: Any = told) -> None:
            set_vector(output, told(last_tick(context)))

        system.DeclareVectorOutputPort(name, size, calc, {ticket})
