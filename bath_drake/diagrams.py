"""Wires the systems into the Diagrams people build.

Each builder unpacks a scenario; no system takes one. The named systems and
their ports are recorded in `diagrams/wiring`, checked by a test.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import (
    ConstantValueSource,
    ConstantVectorSource,
    Demultiplexer,
    LogVectorOutput,
)

from bath_drake.learning.skill import Skill
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.scenario import (
    Scenario,
    approach_limits,
    loop_bounds,
    segmentation,
)
from bath_drake.scene import (
    ArmGeometry,
    Scene,
    add_scene,
    home_position,
    make_control_plant,
)
from bath_drake.scene.sensing import add_depth_noise, add_frame_recorder
from bath_drake.systems._ports import drake_vector
from bath_drake.systems.approach_sequencer import ApproachSequencer
from bath_drake.systems.body_segmenter import BodySegmenter
from bath_drake.systems.canonical_projector import CanonicalProjector
from bath_drake.systems.canonical_reference import CanonicalReference
from bath_drake.systems.canonical_tracker import CanonicalTracker
from bath_drake.systems.certificate_monitor import CertificateMonitor
from bath_drake.systems.differential_ik import DifferentialIk
from bath_drake.systems.frame_recorder import WriteFrame
from bath_drake.systems.hold_supervisor import HoldSupervisor
from bath_drake.systems.loop_monitor import LoopMonitor
from bath_drake.systems.navigation_controller import NavigationController
from bath_drake.systems.nozzle_kinematics import NozzleKinematics
from bath_drake.systems.restricted_area_detector import RestrictedAreaDetector
from bath_drake.systems.stage_sequencer import StageSequencer
from bath_drake.systems.surface_reference import SurfaceReference
from bath_drake.systems.virtual_obstacle_source import VirtualObstacleSource
from bath_drake.systems.world_reconciler import WorldReconciler

# What a run logs. `body_pose` is the truth: into the log, nowhere else.
LOGGED_PORTS = (
    ("canonical_tracker", "canonical_position"),
    ("canonical_reference", "canonical_reference"),
    ("stage_sequencer", "stage"),
    ("approach_sequencer", "phase"),
    ("approach_sequencer", "standoff"),
    ("hold_supervisor", "hold_reason"),
    ("certificate_monitor", "certificate_verdict"),
    ("certificate_monitor", "certificate_seconds"),
    ("certificate_monitor", "certified_start"),
    ("differential_ik", "joint_command"),
    ("plant", "arm_state"),
    ("patient_motion", "body_pose"),
)
_LOG_PERIOD_S = 0.01
_MESHCAT_PERIOD_S = 1.0 / 15.0


def log_name(system: str, port: str) -> str:
    """Returns the name of the sink that logs a port."""
    return f"log_{system}_{port}"


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
    _connect(builder, source, "navigation_chain", [stages])
    _connect(builder, stages, "navigation_field", [controller])
    _connect(builder, stages, "final_stage", [controller])
    _connect(builder, controller, "canonical_velocity", [reference])
    _connect(builder, reference, "canonical_reference", [stages])
    position = reference.GetOutputPort("canonical_reference")
    for system in (controller, reference):
        builder.Connect(position, system.GetInputPort("canonical_position"))
    builder.ExportOutput(position, "canonical_position")
    diagram = builder.Build()
    diagram.set_name("canonical_loop")
    return diagram


def build_perception(scenario: Scenario) -> Diagram:
    """The scene, the camera and what is made of its images; the arm stays at home."""
    builder = DiagramBuilder()
    scene = add_scene(builder, scenario.scene)
    perception = _add_perception(
        builder, scenario, scene, _depth(builder, scenario, scene)
    )
    rest = np.concatenate([home_position(scenario.scene.arm), np.zeros(7)])
    command = builder.AddNamedSystem(
        "joint_command", ConstantVectorSource(drake_vector(rest))
    )
    builder.Connect(
        command.get_output_port(), scene.plant.get_desired_state_input_port(scene.arm)
    )
    for system, port in (
        (perception["body_segmenter"], "body_observation"),
        (perception["canonical_projector"], "canonical_map"),
        (perception["restricted_area_detector"], "sensed_obstacles"),
    ):
        builder.ExportOutput(system.GetOutputPort(port), port)
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
        ScenarioError: If the person the scenario names is not there or damaged.
    """
    builder = DiagramBuilder()
    scene = add_scene(builder, scenario.scene)
    depth = _depth(builder, scenario, scene)
    perception = _add_perception(builder, scenario, scene, depth)
    control = _add_control(builder, scenario, skill)
    _close_loop(builder, scene, perception, control)
    _add_logs(builder, scene, {**perception, **control})
    if write_frame is not None:
        add_frame_recorder(
            builder,
            colour=scene.camera.color_image_output_port(),
            depth=depth,
            config=scenario.scene.camera,
            period=1.0 / scenario.perception.camera_rate,
            write=write_frame,
        )
    if meshcat is not None:
        visualizer = MeshcatVisualizer.AddToBuilder(
            builder,
            scene.scene_graph,
            meshcat,
            MeshcatVisualizerParams(publish_period=_MESHCAT_PERIOD_S),
        )
        visualizer.set_name("meshcat_visualizer")
    diagram = builder.Build()
    diagram.set_name("reproduction")
    return diagram


def _add_all(builder: DiagramBuilder, systems: dict[str, Any]) -> dict[str, Any]:
    for name, system in systems.items():
        builder.AddNamedSystem(name, system)
    return systems


def _connect(
    builder: DiagramBuilder, source: Any, port: str, sinks: Iterable[Any]
) -> None:
    """Connects an output to the input ports of the same name."""
    for sink in sinks:
        builder.Connect(source.GetOutputPort(port), sink.GetInputPort(port))


def _depth(builder: DiagramBuilder, scenario: Scenario, scene: Scene) -> OutputPort:
    """What the loop gets of the camera's depth: noisy if the scenario says so."""
    return add_depth_noise(
        builder,
        scene.camera.depth_image_32F_output_port(),
        scenario.scene.camera,
        seed=scenario.random_seed,
        period=1.0 / scenario.perception.camera_rate,
    )


def _add_perception(
    builder: DiagramBuilder, scenario: Scenario, scene: Scene, depth: OutputPort
) -> dict[str, Any]:
    config = scenario.perception
    systems = _add_all(
        builder,
        {
            "arm_position": Demultiplexer([7, 7]),
            "body_segmenter": BodySegmenter(
                camera=scenario.scene.camera.pinhole(),
                X_WC=scene.X_WC,
                robot=ArmGeometry(scenario.scene.arm),
                config=segmentation(scenario),
                period=1.0 / config.camera_rate,
            ),
            "canonical_projector": CanonicalProjector(period=1.0 / config.camera_rate),
            "restricted_area_detector": RestrictedAreaDetector(
                margin=config.area_margin, period=1.0 / config.camera_rate
            ),
        },
    )
    segmenter = systems["body_segmenter"]
    projector = systems["canonical_projector"]
    detector = systems["restricted_area_detector"]
    builder.Connect(
        scene.camera.color_image_output_port(), segmenter.GetInputPort("colour_image")
    )
    builder.Connect(depth, segmenter.GetInputPort("depth_image"))
    split = systems["arm_position"]
    builder.Connect(
        scene.plant.get_state_output_port(scene.arm), split.get_input_port()
    )
    builder.Connect(split.get_output_port(0), segmenter.GetInputPort("arm_position"))
    _connect(builder, segmenter, "body_observation", [projector, detector])
    _connect(builder, projector, "canonical_map", [detector])
    return systems


def _add_control(
    builder: DiagramBuilder, scenario: Scenario, skill: Skill
) -> dict[str, Any]:
    control = scenario.control
    camera_period = 1.0 / scenario.perception.camera_rate
    arm = make_control_plant(scenario.scene.arm)
    systems = _add_all(
        builder,
        {
            "virtual_obstacle_source": VirtualObstacleSource(chain=skill.chain),
            "stage_sequencer": StageSequencer(),
            "world_reconciler": WorldReconciler(period=camera_period),
            "certificate_monitor": CertificateMonitor(period=camera_period),
            "navigation_controller": NavigationController(
                washing_speed=control.washing_speed, slow_radius=control.slow_radius
            ),
            "canonical_reference": CanonicalReference(
                start=skill.start, leash=control.leash
            ),
            "approach_sequencer": ApproachSequencer(limits=approach_limits(scenario)),
            "surface_reference": SurfaceReference(
                radius=scenario.perception.patch_radius
            ),
            "differential_ik": DifferentialIk(
                plant=arm,
                home=home_position(scenario.scene.arm),
                posture=np.array(scenario.scene.arm.posture),
            ),
            "nozzle_kinematics": NozzleKinematics(plant=arm),
            "canonical_tracker": CanonicalTracker(),
            "hold_supervisor": HoldSupervisor(max_frame_age=control.max_frame_age),
            "loop_monitor": LoopMonitor(bounds=loop_bounds(scenario)),
        },
    )
    stages = systems["stage_sequencer"]
    world = systems["world_reconciler"]
    proof = systems["certificate_monitor"]
    controller = systems["navigation_controller"]
    reference = systems["canonical_reference"]
    approach = systems["approach_sequencer"]
    surface = systems["surface_reference"]
    ik = systems["differential_ik"]
    tracker = systems["canonical_tracker"]
    supervisor = systems["hold_supervisor"]
    monitor = systems["loop_monitor"]
    for source, port, sinks in (
        (systems["virtual_obstacle_source"], "navigation_chain", [stages]),
        (stages, "navigation_field", [world, monitor]),
        (stages, "remaining_chain", [world]),
        (stages, "final_stage", [controller, monitor]),
        (world, "reconciled_worlds", [proof]),
        (proof, "world_status", [supervisor]),
        (controller, "canonical_velocity", [reference]),
        (reference, "canonical_reference", [stages, surface, world, proof]),
        (tracker, "canonical_position", [reference, monitor]),
        (approach, "phase", [reference, monitor]),
        (approach, "standoff", [surface, tracker]),
        (surface, "desired_nozzle_pose", [ik, approach]),
        (surface, "surface_patch", [monitor]),
        (surface, "surface_status", [supervisor]),
        (ik, "ik_status", [supervisor]),
        (systems["nozzle_kinematics"], "nozzle_pose", [tracker, approach, monitor]),
        (supervisor, "hold", [ik, reference, approach]),
    ):
        _connect(builder, source, port, sinks)
    for port, name, sinks in (
        ("reconciled_field", "navigation_field", [controller, proof]),
        ("reconciled_obstacles", "sensed_obstacles", [controller, proof]),
        ("world_status", "reconciler_status", [proof]),
        ("restricted_areas", "sensed_obstacles", [stages]),
    ):
        for sink in sinks:
            builder.Connect(world.GetOutputPort(port), sink.GetInputPort(name))
    # The flow is asked where the reference is; see bath_drake.control.reference.
    builder.Connect(
        reference.GetOutputPort("canonical_reference"),
        controller.GetInputPort("canonical_position"),
    )
    return systems


def _close_loop(
    builder: DiagramBuilder,
    scene: Scene,
    perception: dict[str, Any],
    control: dict[str, Any],
) -> None:
    """Perception into control, control into the arm, the arm into control."""
    surface = control["surface_reference"]
    _connect(
        builder,
        perception["body_segmenter"],
        "body_observation",
        [surface, control["hold_supervisor"]],
    )
    _connect(
        builder,
        perception["canonical_projector"],
        "canonical_map",
        [surface, control["navigation_controller"], control["canonical_tracker"]],
    )
    _connect(
        builder,
        perception["restricted_area_detector"],
        "sensed_obstacles",
        [control["world_reconciler"]],
    )
    builder.Connect(
        control["differential_ik"].GetOutputPort("joint_command"),
        scene.plant.get_desired_state_input_port(scene.arm),
    )
    builder.Connect(
        scene.plant.get_state_output_port(scene.arm),
        control["nozzle_kinematics"].GetInputPort("arm_state"),
    )


def _add_logs(builder: DiagramBuilder, scene: Scene, systems: dict[str, Any]) -> None:
    everything = {
        **systems,
        "plant": scene.plant,
        "patient_motion": scene.patient_motion,
    }
    for system, port in LOGGED_PORTS:
        source: System = everything[system]
        sink = LogVectorOutput(source.GetOutputPort(port), builder, _LOG_PERIOD_S)
        sink.set_name(log_name(system, port))
