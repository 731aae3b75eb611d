"""What every Diagram's camera films: the room and the person on the stool."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import (
    FrameId,
    GeometryFrame,
    GeometryId,
    GeometryInstance,
    IllustrationProperties,
    Mesh,
    PerceptionProperties,
    RenderLabel,
    Rgba,
    SceneGraph,
    SourceId,
)
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder

from bath_drake.patient.bending import BendingSkin
from bath_drake.patient.motion import person_pose
from bath_drake.patient.people import PARTS, Person
from bath_drake.patient.segment_motion import SegmentedSkin
from bath_drake.patient.skin_parts import SkinPart, skin_parts
from bath_drake.patient.wound import WoundPatch, wound_patch
from bath_drake.scene.backgrounds import add_background, room_colours
from bath_drake.scene.bending_person import add_bending_parts
from bath_drake.scene.config import SceneConfig
from bath_drake.scene.room import (
    add_camera_stand,
    add_room,
    add_stool,
    coloured,
    obj_mesh,
)
from bath_drake.scene.visitor import add_visitor
from bath_drake.systems._ports import drake_vector
from bath_drake.systems._poses import at, rotation_from
from bath_drake.systems.patient_motion import PatientMotion

# Labels of the person's parts in the label image, for tests and verification.
PERSON_LABELS = {part: 100 + k for k, part in enumerate(PARTS)}
WOUND_LABEL = 110


@dataclass(frozen=True, eq=False)
class Studio:
    """The systems that are in every scene, and what is true about them.

    Attributes:
        scene_graph: Draws everything.
        patient_motion: Moves the person.
        person: The true person.
        person_frame: The person's frame M in the SceneGraph.
        skin: The parts of a person that bends; without parts of a rigid one.
        skin_geometries: Theirs in the SceneGraph, in the same order.
        room: The SceneGraph's source of all that stands still.
        wound: The true wound, or None.
    """

    scene_graph: SceneGraph
    patient_motion: PatientMotion
    person: Person
    person_frame: FrameId
    skin: tuple[SkinPart, ...]
    skin_geometries: tuple[GeometryId, ...]
    room: SourceId
    wound: WoundPatch | None

    def skin_by_geometry(self) -> dict[GeometryId, SkinPart]:
        """The parts that bend, by their geometries."""
        return dict(zip(self.skin_geometries, self.skin, strict=True))


def add_studio(
    builder: DiagramBuilder,
    scene_graph: SceneGraph,
    config: SceneConfig,
    person: Person,
    *,
    frame_period: float = 1.0 / 30.0,
    segments: SegmentedSkin | None = None,
) -> Studio:
    """Adds room and person to a SceneGraph in a builder.

    Args:
        builder: Gets the systems.
        scene_graph: In the builder.
        config: Every number of the scene.
        person: Who sits there.
        frame_period: Of the camera, s: a bending skin is moved for each frame.
        segments: The skin that can be touched; None where nothing touches it.

    Raises:
        ScenarioError: If the person is to bend and has no sound rig.
        ValueError: If the wound does not lie on the back.
    """
    room = scene_graph.RegisterSource("room")
    add_room(scene_graph, room, room_colours(config.background))
    add_background(scene_graph, room, config)
    X_WM = true_person_pose(config, person, 0.0)
    add_stool(scene_graph, room, X_WM.multiply(drake_vector(person.seat)))
    add_camera_stand(scene_graph, room, config.camera)
    source = scene_graph.RegisterSource("person")
    frame = scene_graph.RegisterFrame(source, GeometryFrame("person"))
    wound = true_wound(config, person)
    skin: tuple[SkinPart, ...] = ()
    shells: dict[GeometryId, BendingSkin] = {}
    if config.motion.bends:
        skin = skin_parts(person, wound)
        labels = PERSON_LABELS | {"wound": WOUND_LABEL}
        geometries = add_bending_parts(scene_graph, source, skin, labels)
        shells = {geometries[part.name]: part.shell for part in skin}
    else:
        _add_rigid_parts(scene_graph, source, frame, person, wound)
    motion = add_patient_motion(
        builder,
        config,
        person,
        frame,
        skin=shells,
        frame_period=frame_period,
        segments=segments,
    )
    builder.Connect(
        motion.GetOutputPort("geometry_pose"), scene_graph.get_source_pose_port(source)
    )
    if skin:
        builder.Connect(
            motion.GetOutputPort("skin_configuration"),
            scene_graph.get_source_configuration_port(source),
        )
    if config.visitor is not None:
        add_visitor(builder, scene_graph, config.visitor)
    return Studio(scene_graph, motion, person, frame, skin, tuple(shells), room, wound)


def add_patient_motion(
    builder: DiagramBuilder,
    config: SceneConfig,
    person: Person,
    frame: FrameId,
    *,
    skin: Mapping[GeometryId, BendingSkin] | None = None,
    frame_period: float = 1.0 / 30.0,
    segments: SegmentedSkin | None = None,
) -> PatientMotion:
    """Adds the system `patient_motion`, with what it moves."""
    motion = PatientMotion(
        frame_id=frame,
        motion=config.motion,
        person_position=np.array(config.person_position),
        person_yaw=config.person_yaw,
        hips=person.hips,
        breath_direction=person.back_normal,
        skin=skin,
        frame_period=frame_period,
        segments=segments,
        segment_step=config.time_step,
    )
    builder.AddNamedSystem("patient_motion", motion)
    return motion


def true_person_pose(config: SceneConfig, person: Person, t: float) -> RigidTransform:
    """Returns the true X_WM at time t: for verification and placing alone."""
    R, p = person_pose(
        t,
        config.motion,
        np.array(config.person_position),
        config.person_yaw,
        person.hips,
        person.back_normal,
    )
    return at(p, rotation_from(R))


def true_wound(config: SceneConfig, person: Person) -> WoundPatch | None:
    """Returns the true wound, at rest: for drawing and verification alone."""
    if config.wound is None:
        return None
    return wound_patch(
        person,
        np.array(config.wound.centre),
        np.array(config.wound.semi_axes),
        config.wound.angle,
        config.wound.colour,
    )


def _add_rigid_parts(
    scene_graph: SceneGraph,
    source: SourceId,
    frame: FrameId,
    person: Person,
    wound: WoundPatch | None,
) -> None:
    for part in PARTS:
        _register_part(scene_graph, source, frame, person, part)
    if wound is None:
        return
    shape = obj_mesh("wound", wound.vertices, wound.normals, wound.triangles)
    scene_graph.RegisterGeometry(
        source,
        frame,
        coloured(shape, RigidTransform(), "wound", Rgba(*wound.colour), WOUND_LABEL),
    )


def _register_part(
    scene_graph: SceneGraph,
    source: SourceId,
    frame: FrameId,
    person: Person,
    part: str,
) -> list[GeometryId]:
    """One geometry for both roles, or two where the camera's is decimated."""
    perception = PerceptionProperties()
    perception.AddProperty("label", "id", RenderLabel(PERSON_LABELS[part]))
    paths = {person.part_path(part), person.part_path(part, for_camera=True)}
    ids = []
    for path in sorted(paths):
        name = path.stem
        instance = GeometryInstance(RigidTransform(), Mesh(path), name)
        if path == person.part_path(part):
            instance.set_illustration_properties(IllustrationProperties())
        if path == person.part_path(part, for_camera=True):
            instance.set_perception_properties(perception)
        ids.append(scene_graph.RegisterGeometry(source, frame, instance))
    return ids
