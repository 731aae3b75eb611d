"""The Diagram that films a carer: no robot, no loop, a camera and its recorder."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import SceneGraph
from pydrake.math import RigidTransform
from pydrake.systems.framework import Diagram, DiagramBuilder

from bath_drake.carer.arm import CarerArm
from bath_drake.carer.config import CarerConfig
from bath_drake.carer.skin_path import lay_on_skin
from bath_drake.carer.stroke import Stroke, demonstrated_stroke, waypoint_stroke
from bath_drake.demonstrations.processing import canonical_demonstrations
from bath_drake.demonstrations.recording import read_recording
from bath_drake.errors import ScenarioError
from bath_drake.notation import ByteArray
from bath_drake.patient.people import load_person
from bath_drake.patient.skin import TrueSkin
from bath_drake.scenario import Scenario, find_demonstration
from bath_drake.scene.camera import add_camera
from bath_drake.scene.carer import add_carer, carer_arm
from bath_drake.scene.config import check_scene
from bath_drake.scene.sensing import (
    add_camera_noise,
    add_frame_recorder,
    camera_ports,
)
from bath_drake.scene.studio import add_studio, true_person_pose
from bath_drake.systems.frame_recorder import WriteFrame


@dataclass(frozen=True, eq=False)
class CarerFilm:
    """A Diagram that films a carer, and what is true about it.

    Attributes:
        diagram: Its `frame_recorder` writes the frames.
        scenario: What it was built from; has a carer.
        stroke: What the hand is to do, canonical.
        skin: Of the person.
        arm: Where the carer's parts are.
    """

    diagram: Diagram
    scenario: Scenario
    stroke: Stroke
    skin: TrueSkin
    arm: CarerArm

    def person_pose(self, t: float) -> RigidTransform:
        """Returns the true X_WM at time t."""
        return true_person_pose(self.scenario.scene, self.skin.person, t)


def discard(t: float, colour: ByteArray, depth: NDArray[np.float32]) -> None:
    """Writes no frame."""


def build_recording(
    scenario: Scenario, *, write_frame: WriteFrame = discard
) -> CarerFilm:
    """Room, person, carer and camera, and every frame of it to `write_frame`.

    Args:
        scenario: Its scene has a carer.
        write_frame: Takes the frames.

    Raises:
        DemonstrationError: If the carer's demonstration cannot be read.
        ScenarioError: If there is no carer, the person's folder is damaged, or the
            stroke leaves the back.
    """
    carer = scenario.scene.carer
    if carer is None:
        raise ScenarioError("scene.carer: is missing; who is to be filmed?")
    check_scene(scenario.scene)
    stroke = _stroke(carer)
    person = load_person(scenario.scene.person)
    skin = TrueSkin(person)
    arm = carer_arm(scenario.scene, skin, lay_on_skin(stroke, skin))
    builder = DiagramBuilder()
    scene_graph = SceneGraph()
    builder.AddNamedSystem("scene_graph", scene_graph)
    studio = add_studio(builder, scene_graph, scenario.scene, person)
    add_carer(builder, studio, carer, arm)
    camera, period = scenario.scene.camera, 1.0 / scenario.perception.camera_rate
    filming = add_camera(builder, scene_graph, camera, studio.skin_by_geometry())
    ports = add_camera_noise(
        builder,
        camera_ports(filming),
        camera,
        seed=scenario.random_seed,
        period=period,
    )
    add_frame_recorder(
        builder, ports=ports, config=camera, period=period, write=write_frame
    )
    diagram = builder.Build()
    diagram.set_name("recording")
    return CarerFilm(diagram, scenario, stroke, skin, arm)


def _stroke(carer: CarerConfig) -> Stroke:
    if carer.demonstration is None:
        return waypoint_stroke(carer)
    recording = read_recording(find_demonstration(carer.demonstration))
    (demonstration,), _ = canonical_demonstrations([recording])
    return demonstrated_stroke(demonstration, carer)
