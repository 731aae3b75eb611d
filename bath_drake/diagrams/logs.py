"""What a run logs, and the sinks that take it down."""

from collections.abc import Container
from typing import Any

from pydrake.systems.framework import DiagramBuilder, System
from pydrake.systems.primitives import LogVectorOutput

from bath_drake.scene import Scene

# What a run logs. `body_pose` is the truth: into the log, nowhere else.
LOGGED_PORTS = (
    ("canonical_tracker", "canonical_position"),
    ("canonical_reference", "canonical_reference"),
    ("stage_sequencer", "stage"),
    ("approach_sequencer", "phase"),
    ("approach_sequencer", "standoff"),
    ("joint_guard", "guard_mode"),
    ("joint_guard", "guard_reason"),
    ("joint_guard", "checked_command"),
    ("canonical_projector", "rejected_frames"),
    ("certificate_monitor", "certificate_verdict"),
    ("certificate_monitor", "certificate_seconds"),
    ("certificate_monitor", "certified_start"),
    ("differential_ik", "joint_command"),
    ("plant", "arm_state"),
    ("patient_motion", "body_pose"),
)
# And where there is a periodic motion.
PERIODIC_PORTS = (("periodic_motion", "canonical_offset"),)
# And where there is a camera to watch.
CAMERA_PORTS = (("camera_monitor", "camera_status"),)
# And where skin can be touched; phase and stand-off are then the regulator's.
FORCE_PORTS = (
    ("force_regulator", "phase"),
    ("force_regulator", "standoff"),
    ("force_regulator", "asked_force"),
    ("force_sensor", "wrench"),
    ("contact_wrench", "contact_wrench"),
)
_LOG_PERIOD_S = 0.01


def logged_ports(names: Container[str]) -> tuple[tuple[str, str], ...]:
    """The systems and ports that a Diagram with systems of these names logs."""
    ports = LOGGED_PORTS + (PERIODIC_PORTS if "periodic_motion" in names else ())
    ports += CAMERA_PORTS if "camera_monitor" in names else ()
    if "force_regulator" not in names:
        return ports
    paced = {port for _, port in FORCE_PORTS}
    return tuple(pair for pair in ports if pair[1] not in paced) + FORCE_PORTS


def log_name(system: str, port: str) -> str:
    """Returns the name of the sink that logs a port."""
    return f"log_{system}_{port}"


def add_logs(builder: DiagramBuilder, scene: Scene, systems: dict[str, Any]) -> None:
    """Adds a sink for every port of `logged_ports`.

    Args:
        builder: Holds the systems.
        scene: Whose plant and person are logged.
        systems: Of perception and control, by name.
    """
    everything = {
        **systems,
        "plant": scene.plant,
        "patient_motion": scene.patient_motion,
    }
    for system, port in logged_ports(systems):
        source: System = everything[system]
        sink = LogVectorOutput(source.GetOutputPort(port), builder, _LOG_PERIOD_S)
        sink.set_name(log_name(system, port))
