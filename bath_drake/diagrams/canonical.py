"""The learned motion alone, as a Diagram: no body, no camera, no arm."""

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource

from bath_drake.diagrams.wiring import connect
from bath_drake.learning.skill import Skill
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.systems.canonical_reference import CanonicalReference
from bath_drake.systems.navigation_controller import NavigationController
from bath_drake.systems.stage_sequencer import StageSequencer
from bath_drake.systems.virtual_obstacle_source import VirtualObstacleSource


def build_canonical_loop(skill: Skill, *, speed: float = 0.3) -> Diagram:
    """The skill alone in canonical space: source, controller, integrator.

    The point is where the reference is; there is no body, no camera and no arm.

    Args:
        skill: Whose chain of fields is followed from its start.
        speed: In N, 1/s.
    """
    builder = DiagramBuilder()
    unit = CanonicalMap(np.eye(3), np.zeros(3), np.ones(2))
    source = VirtualObstacleSource(chain=skill.chain)
    # Short steps: the Diagram's Euler path is compared with exact roll-outs.
    stages = StageSequencer(period=0.002)
    reference = CanonicalReference(start=skill.start, period=0.002)
    controller = NavigationController(washing_speed=speed)
    body = ConstantValueSource(Value[object](unit))
    for name, system in (
        ("virtual_obstacle_source", source),
        ("stage_sequencer", stages),
        ("canonical_map", body),
        ("navigation_controller", controller),
        ("canonical_reference", reference),
    ):
        builder.AddNamedSystem(name, system)
    builder.Connect(body.get_output_port(), controller.GetInputPort("canonical_map"))
    connect(builder, source, "navigation_chain", [stages])
    connect(builder, stages, "navigation_field", [controller])
    connect(builder, stages, "final_stage", [controller])
    connect(builder, controller, "canonical_velocity", [reference])
    connect(builder, reference, "canonical_reference", [stages])
    position = reference.GetOutputPort("canonical_reference")
    for system in (controller, reference):
        builder.Connect(position, system.GetInputPort("canonical_position"))
    builder.ExportOutput(position, "canonical_position")
    diagram = builder.Build()
    diagram.set_name("canonical_loop")
    return diagram
