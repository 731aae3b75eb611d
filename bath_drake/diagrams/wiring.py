"""Puts systems into a builder and joins ports of one name."""

from collections.abc import Iterable
from typing import Any

from pydrake.systems.framework import DiagramBuilder


def add_all(builder: DiagramBuilder, systems: dict[str, Any]) -> dict[str, Any]:
    """Adds systems under their names, and returns them."""
    for name, system in systems.items():
        builder.AddNamedSystem(name, system)
    return systems


def connect(
    builder: DiagramBuilder, source: Any, port: str, sinks: Iterable[Any]
) -> None:
    """Connects an output to the input ports of the same name."""
    for sink in sinks:
        builder.Connect(source.GetOutputPort(port), sink.GetInputPort(port))
