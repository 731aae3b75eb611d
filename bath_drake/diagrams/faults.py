"""Puts a scenario's faults into a Diagram that is otherwise built."""

from typing import Any

from pydrake.systems.framework import DiagramBuilder, OutputPort, PortDataType, System

from bath_drake.errors import ScenarioError
from bath_drake.faults.script import FaultScript
from bath_drake.systems.area_fault import AreaFault
from bath_drake.systems.signal_fault import SignalFault


def add_faults(builder: DiagramBuilder, script: FaultScript, *, period: float) -> None:
    """Puts an injector between each port that a fault names and all its readers.

    Args:
        builder: Holds every system and every connection already.
        script: The faults; none changes nothing.
        period: Of the camera, s: areas come as often.

    Raises:
        ScenarioError: If there is no such port, or it is no vector.
    """
    for k, fault in enumerate(script.signals):
        key = f"faults.signals[{k}]"
        system, _, port = fault.port.partition(".")
        source = _find(builder, key, system, port)
        if source.get_data_type() != PortDataType.kVectorValued:
            raise ScenarioError(f"{key}.port: found {fault.port}, allowed a vector")
        try:
            injector = SignalFault(fault=fault, size=source.size())
        except ValueError as error:
            raise ScenarioError(f"{key}.{error}") from error
        earlier = sum(f.port == fault.port for f in script.signals[:k])
        name = f"fault_{system}_{port}" + (f"_{earlier + 1}" if earlier else "")
        _interpose(builder, source, builder.AddNamedSystem(name, injector), "signal")
    if script.areas:
        source = _find(
            builder, "faults.areas", "restricted_area_detector", "sensed_obstacles"
        )
        added = builder.AddNamedSystem(
            "area_fault", AreaFault(faults=script.areas, period=period)
        )
        _interpose(builder, source, added, "sensed_obstacles")
        tool = _find(builder, "faults.areas", "canonical_tracker", "canonical_position")
        builder.Connect(tool, added.GetInputPort("canonical_position"))


def _find(builder: DiagramBuilder, key: str, system: str, port: str) -> OutputPort:
    names = {s.get_name(): s for s in builder.GetSystems()}
    if system not in names:
        raise ScenarioError(
            f"{key}.port: found no system {system[:60]!r}, "
            f"allowed {', '.join(sorted(names))}"
        )
    found: System = names[system]
    ports = {
        found.get_output_port(k).get_name(): found.get_output_port(k)
        for k in range(found.num_output_ports())
    }
    if port not in ports:
        raise ScenarioError(
            f"{key}.port: found no port {port[:60]!r} of {system}, "
            f"allowed {', '.join(ports)}"
        )
    return ports[port]


def _interpose(
    builder: DiagramBuilder, source: OutputPort, injector: Any, port: str
) -> None:
    """All readers but the log's get what the injector makes of a port."""
    readers = [
        system.get_input_port(index)
        for (system, index), (giver, output) in builder.connection_map().items()
        if giver is source.get_system() and output == source.get_index()
        if not system.get_name().startswith("log_")
    ]
    for reader in readers:
        builder.Disconnect(source, reader)
        builder.Connect(injector.get_output_port(), reader)
    builder.Connect(source, injector.GetInputPort(port))
