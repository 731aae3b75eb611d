"""Puts the robot's scene into a DiagramBuilder: room, person, camera and the arm."""

from dataclasses import dataclass, replace

from pydrake.geometry import FrameId, GeometryId, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.controllers import InverseDynamics
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort
from pydrake.systems.rendering import MultibodyPositionToGeometryPose

from bath_drake.patient.people import Person, load_person
from bath_drake.patient.segment_motion import SegmentedSkin
from bath_drake.patient.skin_parts import SkinPart
from bath_drake.patient.skin_segments import segmented_skin
from bath_drake.patient.wound import WoundPatch
from bath_drake.scene.arm import SPONGE_BODY, add_arm, home_position, make_control_plant
from bath_drake.scene.camera import Camera, add_camera, camera_pose
from bath_drake.scene.config import SceneConfig, check_scene
from bath_drake.scene.room import add_pedestal
from bath_drake.scene.studio import (
    add_patient_motion,
    add_studio,
    true_person_pose,
    true_wound,
)
from bath_drake.scene.touched_skin import add_touched_skin
from bath_drake.systems.gravity_compensation import GravityCompensation
from bath_drake.systems.kinematic_arm import KinematicArm
from bath_drake.systems.patient_motion import PatientMotion


@dataclass(frozen=True, eq=False)
class Scene:
    """The scene's systems in the builder, and what is true about it.

    Attributes:
        plant: The arm, named `plant`: a MultibodyPlant, finalised, or what stands for
            it where the arm is kinematic.
        arm_command: Its input: q, v (14).
        arm_state: Its output: q, v (14).
        scene_graph: Draws everything; None where nothing is drawn and nothing needs it.
        camera: The system named `camera`; None where nothing is filmed.
        patient_motion: Moves the person.
        arm: The arm's model instance in a MultibodyPlant.
        person: The true person: for verification and placing alone.
        person_frame: The person's frame M in the SceneGraph.
        skin: The parts of a person that bends; without parts of a rigid one.
        skin_geometries: Theirs in the SceneGraph, in the same order.
        wound: The true wound, or None.
        X_WC: The camera's pose.
        config: What it was built from.
        contact_results: The plant's, where skin can be touched; else None.
        tool: The geometries that touch it.
    """

    plant: MultibodyPlant | KinematicArm
    arm_command: InputPort
    arm_state: OutputPort
    scene_graph: SceneGraph | None
    camera: Camera | None
    patient_motion: PatientMotion
    arm: ModelInstanceIndex | None
    person: Person
    person_frame: FrameId
    skin: tuple[SkinPart, ...]
    skin_geometries: tuple[GeometryId, ...]
    wound: WoundPatch | None
    X_WC: RigidTransform
    config: SceneConfig
    contact_results: OutputPort | None = None
    tool: frozenset[GeometryId] = frozenset()

    def true_person_pose(self, t: float) -> RigidTransform:
        """Returns the true X_WM at time t, for verification alone."""
        return true_person_pose(self.config, self.person, t)


@dataclass(frozen=True, eq=False)
class _Arm:
    plant: MultibodyPlant | KinematicArm
    command: InputPort
    state: OutputPort
    scene_graph: SceneGraph | None
    instance: ModelInstanceIndex | None = None
    skin: SegmentedSkin | None = None
    skin_command: InputPort | None = None
    contact_results: OutputPort | None = None
    tool: frozenset[GeometryId] = frozenset()


def add_scene(
    builder: DiagramBuilder,
    config: SceneConfig,
    *,
    person: Person | None = None,
    frame_period: float = 1.0 / 30.0,
    films: bool = True,
    draws: bool = True,
) -> Scene:
    """Adds the whole scene to a builder.

    The arm's gravity is carried by Drake's InverseDynamics, its commands go to the
    plant's desired-state port of instance `arm` (14: q, v). A kinematic arm has no
    gravity.

    Args:
        builder: Not yet built.
        config: Every number of the scene.
        person: Already loaded; None loads the one `config.person` names.
        frame_period: Of the camera, s; see `add_studio`.
        films: Whether there is a camera that renders.
        draws: Whether room and person are drawn for somebody else. What is neither
            filmed nor drawn is left out, and without a plant so is the SceneGraph.

    Raises:
        ScenarioError: If the person's folder is damaged.
        ValueError: If a number makes no scene.
    """
    check_scene(config)
    if config.carer is not None:
        raise ValueError("where a carer washes there is no robot: film it instead")
    person = load_person(config.person) if person is None else person
    seen = films or draws
    if config.arm.fidelity == "kinematic":
        arm = _kinematic_arm(builder, config, seen)
    else:
        arm = _dynamic_arm(builder, config, person)
    if seen and arm.scene_graph is not None:
        studio = add_studio(
            builder,
            arm.scene_graph,
            config,
            person,
            frame_period=frame_period,
            segments=arm.skin,
        )
        add_pedestal(arm.scene_graph, studio.room, config.arm)
        motion, frame = studio.patient_motion, studio.person_frame
        camera = (
            add_camera(
                builder, arm.scene_graph, config.camera, studio.skin_by_geometry()
            )
            if films
            else None
        )
        skin, geometries, wound = studio.skin, studio.skin_geometries, studio.wound
    else:
        frame = FrameId.get_new_id()
        motion = add_patient_motion(builder, config, person, frame, segments=arm.skin)
        camera, skin, geometries = None, (), ()
        wound = true_wound(config, person)
    if arm.skin_command is not None:
        builder.Connect(motion.GetOutputPort("skin_segments"), arm.skin_command)
    return Scene(
        plant=arm.plant,
        arm_command=arm.command,
        arm_state=arm.state,
        scene_graph=arm.scene_graph,
        camera=camera,
        patient_motion=motion,
        arm=arm.instance,
        person=person,
        person_frame=frame,
        skin=skin,
        skin_geometries=geometries,
        wound=wound,
        X_WC=camera_pose(config.camera),
        config=config,
        contact_results=arm.contact_results,
        tool=arm.tool,
    )


def _dynamic_arm(builder: DiagramBuilder, config: SceneConfig, person: Person) -> _Arm:
    touches = config.arm.fidelity == "contact"
    plant, scene_graph = AddMultibodyPlant(
        MultibodyPlantConfig(
            time_step=config.time_step,
            contact_model="hydroelastic_with_fallback",
            discrete_contact_approximation="sap",
        ),
        builder,
    )
    plant.set_name("plant")
    scene_graph.set_name("scene_graph")
    arm = add_arm(plant, config.arm, soft=touches)
    skin, instance = None, None
    if touches:
        skin = segmented_skin(person, bends=config.motion.bends)
        X_WM = true_person_pose(config, person, 0.0)
        instance = add_touched_skin(plant, scene_graph, skin, X_WM)
    plant.Finalize()
    plant.SetDefaultPositions(arm, home_position(config.arm))
    # The plant itself is the model where the arm is all there is in it: Drake keeps
    # a pointer only, and a plant of its own would be gone with its Python name.
    _compensate_gravity(
        builder,
        plant,
        arm,
        GravityCompensation(plant=make_control_plant(config.arm)) if touches else None,
    )
    moved = _Arm(
        plant,
        plant.get_desired_state_input_port(arm),
        plant.get_state_output_port(arm),
        scene_graph,
        arm,
    )
    if instance is None:
        return moved
    sponge = plant.GetBodyByName(SPONGE_BODY)
    return replace(
        moved,
        skin=skin,
        skin_command=plant.get_desired_state_input_port(instance),
        contact_results=plant.get_contact_results_output_port(),
        tool=frozenset(plant.GetCollisionGeometriesForBody(sponge)),
    )


def _kinematic_arm(builder: DiagramBuilder, config: SceneConfig, seen: bool) -> _Arm:
    arm = KinematicArm()
    builder.AddNamedSystem("plant", arm)
    scene_graph = None
    if seen:
        scene_graph = SceneGraph()
        builder.AddNamedSystem("scene_graph", scene_graph)
        model = MultibodyPlant(time_step=0.0)
        source = model.RegisterAsSourceForSceneGraph(scene_graph)
        add_arm(model, config.arm)
        model.Finalize()
        # Drake keeps a pointer to the model only: the arm keeps it alive.
        arm.model = model
        poses = MultibodyPositionToGeometryPose(model)
        builder.AddNamedSystem("arm_geometry", poses)
        builder.Connect(arm.GetOutputPort("arm_position"), poses.get_input_port())
        builder.Connect(
            poses.get_output_port(), scene_graph.get_source_pose_port(source)
        )
    return _Arm(
        arm,
        arm.GetInputPort("arm_desired_state"),
        arm.GetOutputPort("arm_state"),
        scene_graph,
    )


def _compensate_gravity(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    arm: ModelInstanceIndex,
    own: GravityCompensation | None,
) -> None:
    """Without it the implicit PD would let the nozzle droop."""
    if own is not None:
        builder.AddNamedSystem("gravity_compensation", own)
        taken, given = own.get_input_port(), own.get_output_port()
    else:
        gravity = InverseDynamics(
            plant, InverseDynamics.InverseDynamicsMode.kGravityCompensation
        )
        builder.AddNamedSystem("gravity_compensation", gravity)
        taken = gravity.get_input_port_estimated_state()
        given = gravity.get_output_port_generalized_force()
    builder.Connect(plant.get_state_output_port(arm), taken)
    builder.Connect(given, plant.get_actuation_input_port(arm))
