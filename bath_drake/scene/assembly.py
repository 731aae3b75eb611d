"""Puts the robot's scene into a DiagramBuilder: room, person, camera and the arm."""

from dataclasses import dataclass

from pydrake.geometry import FrameId, GeometryId, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.controllers import InverseDynamics
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import RgbdSensor

from bath_drake.patient.people import Person, load_person
from bath_drake.patient.skin_parts import SkinPart
from bath_drake.patient.wound import WoundPatch
from bath_drake.scene.arm import add_arm, home_position
from bath_drake.scene.config import SceneConfig, check_scene
from bath_drake.scene.room import add_pedestal
from bath_drake.scene.studio import add_studio, true_person_pose
from bath_drake.systems.patient_motion import PatientMotion


@dataclass(frozen=True, eq=False)
class Scene:
    """The scene's systems in the builder, and what is true about it.

    Attributes:
        plant: The arm's MultibodyPlant, named `plant`, finalised.
        scene_graph: Draws everything.
        camera: The RgbdSensor named `camera`.
        patient_motion: Moves the person.
        arm: The arm's model instance.
        person: The true person: for verification and placing alone.
        person_frame: The person's frame M in the SceneGraph.
        skin: The parts of a person that bends; without parts of a rigid one.
        skin_geometries: Theirs in the SceneGraph, in the same order.
        wound: The true wound, or None.
        X_WC: The camera's pose.
        config: What it was built from.
    """

    plant: MultibodyPlant
    scene_graph: SceneGraph
    camera: RgbdSensor
    patient_motion: PatientMotion
    arm: ModelInstanceIndex
    person: Person
    person_frame: FrameId
    skin: tuple[SkinPart, ...]
    skin_geometries: tuple[GeometryId, ...]
    wound: WoundPatch | None
    X_WC: RigidTransform
    config: SceneConfig

    def true_person_pose(self, t: float) -> RigidTransform:
        """Returns the true X_WM at time t, for verification alone."""
        return true_person_pose(self.config, self.person, t)


def add_scene(
    builder: DiagramBuilder,
    config: SceneConfig,
    *,
    person: Person | None = None,
    frame_period: float = 1.0 / 30.0,
) -> Scene:
    """Adds the whole scene to a builder.

    The arm's gravity is carried by Drake's InverseDynamics, its commands go to the
    plant's desired-state port of instance `arm` (14: q, v).

    Args:
        builder: Not yet built.
        config: Every number of the scene.
        person: Already loaded; None loads the one `config.person` names.
        frame_period: Of the camera, s; see `add_studio`.

    Raises:
        ScenarioError: If the person's folder is damaged.
        ValueError: If a number makes no scene.
    """
    check_scene(config)
    if config.carer is not None:
        raise ValueError("where a carer washes there is no robot: film it instead")
    person = load_person(config.person) if person is None else person
    plant, scene_graph = AddMultibodyPlant(
        MultibodyPlantConfig(
            time_step=config.time_step, discrete_contact_approximation="sap"
        ),
        builder,
    )
    plant.set_name("plant")
    scene_graph.set_name("scene_graph")
    arm = add_arm(plant, config.arm)
    plant.Finalize()
    plant.SetDefaultPositions(arm, home_position(config.arm))
    _compensate_gravity(builder, plant, arm)
    studio = add_studio(builder, scene_graph, config, person, frame_period=frame_period)
    add_pedestal(scene_graph, studio.room, config.arm)
    return Scene(
        plant=plant,
        scene_graph=scene_graph,
        camera=studio.camera,
        patient_motion=studio.patient_motion,
        arm=arm,
        person=person,
        person_frame=studio.person_frame,
        skin=studio.skin,
        skin_geometries=studio.skin_geometries,
        wound=studio.wound,
        X_WC=studio.X_WC,
        config=config,
    )


def _compensate_gravity(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    arm: ModelInstanceIndex,
) -> None:
    """Without it the implicit PD would let the nozzle droop."""
    # The plant itself is the model, for the arm is all there is in it: Drake keeps
    # a pointer only, and a plant of its own would be gone with its Python name.
    gravity = InverseDynamics(
        plant, InverseDynamics.InverseDynamicsMode.kGravityCompensation
    )
    builder.AddNamedSystem("gravity_compensation", gravity)
    builder.Connect(
        plant.get_state_output_port(arm), gravity.get_input_port_estimated_state()
    )
    builder.Connect(
        gravity.get_output_port_generalized_force(),
        plant.get_actuation_input_port(arm),
    )
