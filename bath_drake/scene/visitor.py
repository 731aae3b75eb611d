"""Somebody else who comes into the room during a run."""

import numpy as np
from pydrake.geometry import (
    GeometryFrame,
    GeometryInstance,
    IllustrationProperties,
    Mesh,
    PerceptionProperties,
    RenderLabel,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder

from bath_drake.patient.motion import MotionConfig
from bath_drake.patient.people import PARTS, load_person
from bath_drake.scene.config import VisitorConfig
from bath_drake.systems.patient_motion import PatientMotion

# In the label image.
VISITOR_LABEL = 230


def add_visitor(
    builder: DiagramBuilder, scene_graph: SceneGraph, config: VisitorConfig
) -> None:
    """Adds the visitor and the system `visitor_motion` that moves them.

    Args:
        builder: Gets the system.
        scene_graph: Gets the visitor's shape.
        config: Who comes, from where and when.

    Raises:
        ScenarioError: If there is no such person, or the folder is damaged.
    """
    person = load_person(config.person)
    source = scene_graph.RegisterSource("visitor")
    frame = scene_graph.RegisterFrame(source, GeometryFrame("visitor"))
    for part in PARTS:
        path = person.part_path(part, for_camera=True)
        shape = GeometryInstance(RigidTransform(), Mesh(path), f"visitor_{part}")
        shape.set_illustration_properties(IllustrationProperties())
        perception = PerceptionProperties()
        perception.AddProperty("label", "id", RenderLabel(VISITOR_LABEL))
        shape.set_perception_properties(perception)
        scene_graph.RegisterGeometry(source, frame, shape)
    still = MotionConfig(
        breath_amplitude=0.0,
        twist_amplitude=0.0,
        lean_amplitude=0.0,
        departure=config.walk,
    )
    motion = PatientMotion(
        frame_id=frame,
        motion=still,
        person_position=np.array(config.position),
        person_yaw=config.yaw,
        hips=person.hips,
        breath_direction=person.back_normal,
    )
    builder.AddNamedSystem("visitor_motion", motion)
    builder.Connect(
        motion.GetOutputPort("geometry_pose"), scene_graph.get_source_pose_port(source)
    )
