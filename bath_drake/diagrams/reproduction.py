"""Wires the systems into the Diagrams people build.

Each builder unpacks a scenario; no system takes one. The named systems and
their ports are recorded in `diagrams/wiring`, checked by a test.
"""

from typing import Any

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import (
    ConstantVectorSource,
    Demultiplexer,
)

from bath_drake.diagrams.control import add_control
from bath_drake.diagrams.faults import add_faults
from bath_drake.diagrams.logs import add_logs
from bath_drake.diagrams.perception import (
    add_ideal_perception,
    add_perception,
    export_perception,
)
from bath_drake.diagrams.wiring import connect
from bath_drake.errors import ScenarioError
from bath_drake.learning.skill import Skill
from bath_drake.scenario import Scenario
from bath_drake.scene import (
    ArmGeometry,
    Scene,
    add_scene,
    home_position,
)
from bath_drake.scene.arm import base_pose
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.scene.sensing import (
    CameraPorts,
    add_camera_faults,
    add_camera_noise,
    add_frame_recorder,
    camera_ports,
)
from bath_drake.scene.true_sight import true_sight
from bath_drake.systems._ports import drake_vector
from bath_drake.systems.contact_wrench import ContactWrench
from bath_drake.systems.frame_recorder import WriteFrame
from bath_drake.systems.guard_view import GuardView
from bath_drake.systems.skin_view import DrawnPart, SkinView

# Who heeds what the camera saw, and when.
_WATCHING = ("canonical_guard", "joint_guard")
# m, from the arm's base: beside it, where the viewer looks past.
_LAMP = np.array([0.1, 0.45, 0.95])
_MESHCAT_PERIOD_S = 1.0 / 15.0


def build_perception(scenario: Scenario) -> Diagram:
    """The scene, the camera and what is made of its images; the arm stays at home."""
    builder = DiagramBuilder()
    scene = _add_scene(builder, scenario)
    perception, _ = _add_eyes(builder, scenario, scene)
    rest = np.concatenate([home_position(scenario.scene.arm), np.zeros(7)])
    command = builder.AddNamedSystem(
        "joint_command", ConstantVectorSource(drake_vector(rest))
    )
    builder.Connect(command.get_output_port(), scene.arm_command)
    export_perception(builder, perception)
    diagram = builder.Build()
    diagram.set_name("perception")
    return diagram


def build_reproduction(
    scenario: Scenario,
    skill: Skill,
    *,
    meshcat: Meshcat | None = None,
    write_frame: WriteFrame | None = None,
) -> Diagram:
    """The whole chain, from the camera to the arm and back (paper, Sec. IV).

    Args:
        scenario: Every choice of the run.
        skill: What to reproduce.
        meshcat: Where to draw the scene; None draws nothing.
        write_frame: Takes every frame of the camera; None records nothing.

    Raises:
        ScenarioError: If the person the scenario names is not there or damaged, or
            frames are to be recorded where none are taken.
    """
    builder = DiagramBuilder()
    scene = _add_scene(builder, scenario, draws=meshcat is not None)
    perception, camera = _add_eyes(builder, scenario, scene, watched=True)
    control = add_control(builder, scenario, skill)
    _close_loop(
        builder, scene, perception, control, body_rim=scenario.perception.body_rim
    )
    add_logs(builder, scene, {**perception, **control})
    add_faults(builder, scenario.faults, period=1.0 / scenario.perception.camera_rate)
    if write_frame is not None:
        if camera is None:
            raise ScenarioError(
                "perception.source: found 'ideal', allowed camera to record its frames"
            )
        add_frame_recorder(
            builder,
            ports=camera,
            config=scenario.scene.camera,
            period=1.0 / scenario.perception.camera_rate,
            write=write_frame,
        )
    if meshcat is not None and scene.scene_graph is not None:
        visualizer = MeshcatVisualizer.AddToBuilder(
            builder,
            scene.scene_graph,
            meshcat,
            MeshcatVisualizerParams(publish_period=_MESHCAT_PERIOD_S),
        )
        visualizer.set_name("meshcat_visualizer")
        _add_skin_view(builder, scene, meshcat)
    if meshcat is not None:
        lamp = GuardView(
            meshcat=meshcat,
            place=np.array(scenario.scene.arm.base_position) + _LAMP,
            period=_MESHCAT_PERIOD_S,
        )
        builder.AddNamedSystem("guard_view", lamp)
        connect(builder, control["joint_guard"], "guard_mode", [lamp])
    diagram = builder.Build()
    diagram.set_name("reproduction")
    return diagram


def _add_scene(
    builder: DiagramBuilder, scenario: Scenario, *, draws: bool = False
) -> Scene:
    """The scene; where nothing is filmed or shown, only what moves in it."""
    return add_scene(
        builder,
        scenario.scene,
        frame_period=1.0 / scenario.perception.camera_rate,
        films=scenario.perception.source == "camera",
        draws=draws,
    )


def _add_eyes(
    builder: DiagramBuilder,
    scenario: Scenario,
    scene: Scene,
    *,
    watched: bool = False,
) -> tuple[dict[str, Any], CameraPorts | None]:
    """Perception's systems by name, and the images, noisy if the scenario says so."""
    perception = scenario.perception
    period = 1.0 / perception.camera_rate
    if perception.source == "ideal":
        sight = true_sight(
            scene, margin=perception.area_margin, given=perception.restricted_areas
        )
        systems = add_ideal_perception(builder, sight, period=period)
        for port in ("body_pose", "trunk_bend"):
            connect(builder, scene.patient_motion, port, [systems["body_segmenter"]])
        return systems, None
    camera = add_camera_noise(
        builder,
        camera_ports(scene.camera),
        scenario.scene.camera,
        seed=scenario.random_seed,
        period=period,
    )
    systems = _add_perception(builder, scenario, scene, camera, watched=watched)
    return systems, camera


def _add_skin_view(builder: DiagramBuilder, scene: Scene, meshcat: Meshcat) -> None:
    if not scene.skin:
        return
    drawn = zip(scene.skin, scene.skin_geometries, strict=True)
    parts = [DrawnPart(p.name, id_, p.triangles, p.rgba) for p, id_ in drawn]
    view = SkinView(meshcat=meshcat, parts=parts, period=_MESHCAT_PERIOD_S)
    builder.AddNamedSystem("skin_view", view)
    connect(builder, scene.patient_motion, "skin_configuration", [view])


def _add_perception(
    builder: DiagramBuilder,
    scenario: Scenario,
    scene: Scene,
    camera: CameraPorts,
    *,
    watched: bool = False,
) -> dict[str, Any]:
    period = 1.0 / scenario.perception.camera_rate
    systems = add_perception(
        builder,
        scenario,
        camera=scenario.scene.camera.pinhole(),
        X_WC=scene.X_WC,
        robot=ArmGeometry(scenario.scene.arm),
        period=period,
        arm=arm_chain(scenario.scene.arm),
        X_WB=base_pose(scenario.scene.arm),
        watched=watched,
    )
    split = builder.AddNamedSystem("arm_position", Demultiplexer([7, 7]))
    builder.Connect(scene.arm_state, split.get_input_port())
    now = split.get_output_port(0)
    come = add_camera_faults(
        builder,
        camera,
        now,
        scenario.scene.camera,
        seed=scenario.random_seed,
        period=period,
    )
    segmenter = systems["body_segmenter"]
    for port, name in (
        (come.colour, "colour_image"),
        (come.depth, "depth_image"),
        (come.arm_position or now, "arm_position"),
        (come.stamp, "frame_stamp"),
    ):
        if port is not None:
            builder.Connect(port, segmenter.GetInputPort(name))
    if watched:
        for port, name in ((come.depth, "depth_image"), (come.stamp, "frame_stamp")):
            if port is not None:
                builder.Connect(port, systems["frame_monitor"].GetInputPort(name))
        builder.Connect(come.depth, systems["body_monitor"].GetInputPort("depth_image"))
        sight = systems["camera_monitor"]
        builder.Connect(come.depth, sight.GetInputPort("depth_image"))
        builder.Connect(come.arm_position or now, sight.GetInputPort("arm_position"))
    return systems


def _close_loop(
    builder: DiagramBuilder,
    scene: Scene,
    perception: dict[str, Any],
    control: dict[str, Any],
    *,
    body_rim: bool,
) -> None:
    """Perception into control, control into the arm, the arm into control."""
    surface = control["surface_reference"]
    connect(
        builder,
        perception["body_segmenter"],
        "body_observation",
        [
            surface,
            *(
                control[name]
                for name in ("surface_velocity", "nozzle_clearance", *_WATCHING)
            ),
        ],
    )
    connect(
        builder,
        perception["canonical_projector"],
        "canonical_map",
        [
            control[name]
            for name in (
                "surface_reference",
                "surface_velocity",
                "navigation_controller",
                "canonical_guard",
                "canonical_tracker",
                "body_obstacles",
                "periodic_motion",
            )
            if name in control
        ],
    )
    connect(
        builder,
        perception["canonical_projector"],
        "map_status",
        [control[name] for name in _WATCHING],
    )
    connect(
        builder,
        perception["canonical_projector"],
        "recalled_skin",
        [surface, control["surface_velocity"], control["nozzle_clearance"]],
    )
    guards = [control[name] for name in ("canonical_guard", "joint_guard")]
    for name, port in (
        ("frame_monitor", "frame_status"),
        ("body_monitor", "body_status"),
        ("camera_monitor", "camera_status"),
    ):
        # Ideal perception has none of them: there are no frames, and one body.
        if name in perception:
            connect(builder, perception[name], port, guards)
    if body_rim:
        connect(
            builder,
            perception["canonical_projector"],
            "body_rim",
            [control["world_reconciler"]],
        )
    connect(
        builder,
        perception["restricted_area_detector"],
        "sensed_obstacles",
        [control["world_reconciler"]],
    )
    builder.Connect(
        control["joint_guard"].GetOutputPort("checked_command"), scene.arm_command
    )
    for name in ("nozzle_kinematics", "arm_link"):
        builder.Connect(scene.arm_state, control[name].GetInputPort("arm_state"))
    if scene.contact_results is None:
        return
    # What is felt of the true skin, and by the force sensor alone.
    control["contact_wrench"] = builder.AddNamedSystem(
        "contact_wrench", ContactWrench(tool=scene.tool)
    )
    felt = control["contact_wrench"]
    builder.Connect(scene.contact_results, felt.GetInputPort("contact_results"))
    connect(builder, control["nozzle_kinematics"], "nozzle_pose", [felt])
    connect(builder, felt, "contact_wrench", [control["force_sensor"]])
