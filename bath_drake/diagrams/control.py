"""Wires what drives the motion: field, world, reference, surface, arm."""

from dataclasses import replace
from typing import Any

import numpy as np
from pydrake.systems.framework import DiagramBuilder

from bath_drake.composition.rollout import chain_rollout
from bath_drake.control.avoidance import AvoidanceConfig
from bath_drake.diagrams.wiring import add_all, connect
from bath_drake.learning.skill import Skill
from bath_drake.safety.limits import GuardLimits, load_limits
from bath_drake.scenario import Scenario, approach_limits, force_limits, loop_bounds
from bath_drake.scene import home_position, make_control_plant
from bath_drake.scene.arm import base_pose
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.scene.obstacles import fixed_obstacles
from bath_drake.systems.approach_sequencer import ApproachSequencer
from bath_drake.systems.arm_link import ArmLink
from bath_drake.systems.body_obstacles import BodyObstacles
from bath_drake.systems.canonical_guard import CanonicalGuard
from bath_drake.systems.canonical_reference import CanonicalReference
from bath_drake.systems.canonical_tracker import CanonicalTracker
from bath_drake.systems.certificate_monitor import CertificateMonitor
from bath_drake.systems.differential_ik import DifferentialIk
from bath_drake.systems.force_regulator import ForceRegulator
from bath_drake.systems.force_sensor import ForceSensor
from bath_drake.systems.joint_guard import JointGuard
from bath_drake.systems.loop_monitor import LoopMonitor
from bath_drake.systems.navigation_controller import NavigationController
from bath_drake.systems.nozzle_clearance import NozzleClearance
from bath_drake.systems.nozzle_kinematics import NozzleKinematics
from bath_drake.systems.obstacle_distance import ObstacleDistance
from bath_drake.systems.periodic_motion import PeriodicMotion
from bath_drake.systems.self_distance import SelfDistance
from bath_drake.systems.stage_sequencer import StageSequencer
from bath_drake.systems.surface_reference import SurfaceReference
from bath_drake.systems.surface_velocity import SurfaceVelocity
from bath_drake.systems.virtual_obstacle_source import VirtualObstacleSource
from bath_drake.systems.world_reconciler import WorldReconciler

# What is planned stays this much further from the guard's limits: rad, and a share.
PLANNED_MARGIN, PLANNED_SHARE = 0.02, 0.8
# m, and how much earlier the null space is used to keep off.
PLANNED_DISTANCE, AVOIDED_WITHIN = 0.01, 0.04
# N, along each axis, what is left of the force sensor's bias: a careful taring's.
_FORCE_BIAS = 0.1


def add_control(
    builder: DiagramBuilder, scenario: Scenario, skill: Skill
) -> dict[str, Any]:
    """Adds the systems of the control and joins them; returns them by name.

    A skill with a periodic motion has a `periodic_motion` between the reference and
    all that follows it; one without has none.
    """
    control = scenario.control
    camera_period = 1.0 / scenario.perception.camera_rate
    arm = make_control_plant(scenario.scene.arm)
    limits = guard_limits(scenario)
    chain = arm_chain(scenario.scene.arm)
    systems = add_all(
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
            "surface_velocity": SurfaceVelocity(
                period=camera_period, radius=scenario.perception.patch_radius
            ),
            "differential_ik": DifferentialIk(
                plant=arm,
                home=home_position(scenario.scene.arm),
                posture=np.array(scenario.scene.arm.posture),
                joint_margin=limits.joints.margin + PLANNED_MARGIN,
                joint_acceleration=PLANNED_SHARE * min(limits.joints.acceleration),
                arm=chain,
                avoidance=avoidance(limits),
            ),
            "canonical_guard": CanonicalGuard(limits=limits),
            "joint_guard": _joint_guard(arm, scenario, limits),
            "arm_link": ArmLink(),
            "self_distance": SelfDistance(arm=chain),
            "body_obstacles": BodyObstacles(
                X_WB=np.array(base_pose(scenario.scene.arm).GetAsMatrix4()),
                fixed=fixed_obstacles(scenario.scene),
            ),
            "obstacle_distance": ObstacleDistance(arm=chain),
            "force_sensor": ForceSensor(
                seed=scenario.random_seed,
                period=limits.loop.period,
                force_bias=_FORCE_BIAS,
            ),
            "nozzle_kinematics": NozzleKinematics(plant=arm),
            "nozzle_clearance": NozzleClearance(),
            "canonical_tracker": CanonicalTracker(),
            "loop_monitor": LoopMonitor(bounds=loop_bounds(scenario)),
        },
    )
    if skill.periodic is not None:
        path = chain_rollout(skill.start, skill.chain).path
        systems["periodic_motion"] = builder.AddNamedSystem(
            "periodic_motion",
            PeriodicMotion(
                cycle=skill.periodic,
                length=float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()),
                washing_speed=control.washing_speed,
            ),
        )
    if scenario.scene.arm.fidelity == "contact":
        systems["force_regulator"] = builder.AddNamedSystem(
            "force_regulator",
            ForceRegulator(limits=force_limits(scenario), period=limits.loop.period),
        )
    stages = systems["stage_sequencer"]
    world = systems["world_reconciler"]
    proof = systems["certificate_monitor"]
    controller = systems["navigation_controller"]
    reference = systems["canonical_reference"]
    approach = systems["approach_sequencer"]
    pacer = systems.get("force_regulator", approach)
    surface = systems["surface_reference"]
    ik = systems["differential_ik"]
    tracker = systems["canonical_tracker"]
    monitor = systems["loop_monitor"]
    guard = systems["joint_guard"]
    clearance = systems["nozzle_clearance"]
    for source, port, sinks in (
        (systems["virtual_obstacle_source"], "navigation_chain", [stages]),
        (stages, "navigation_field", [world, monitor]),
        (stages, "remaining_chain", [world]),
        (stages, "final_stage", [controller]),
        (world, "reconciled_worlds", [proof]),
        (reference, "canonical_reference", [stages, world, proof]),
        (pacer, "phase", [reference, monitor, ik]),
        (pacer, "standoff", [surface, tracker, ik]),
        (systems["surface_velocity"], "surface_velocity", [surface, ik]),
        (surface, "desired_nozzle_pose", [ik, approach]),
        (surface, "surface_patch", [clearance]),
        (systems["nozzle_kinematics"], "nozzle_pose", [tracker, approach, clearance]),
        (clearance, "nozzle_clearance", [guard, monitor]),
        (guard, "hold", [ik, reference, approach]),
        (ik, "joint_command", [guard]),
        (ik, "ik_status", [guard]),
        (surface, "surface_status", [guard]),
        (surface, "surface_normal", [guard]),
        (proof, "world_status", [guard, systems["canonical_guard"]]),
        (guard, "condition_number", [systems["canonical_guard"]]),
        (ik, "joint_command", [systems["self_distance"]]),
        (systems["self_distance"], "self_distance", [guard]),
        (systems["body_obstacles"], "obstacles", [ik, systems["obstacle_distance"]]),
        (ik, "joint_command", [systems["obstacle_distance"]]),
        (systems["obstacle_distance"], "obstacle_distance", [guard]),
        (systems["arm_link"], "robot_stamp", [guard]),
        (systems["arm_link"], "following_error", [guard]),
        (systems["arm_link"], "loop_seconds", [guard]),
        (systems["force_sensor"], "wrench", [guard]),
        (controller, "canonical_velocity", [systems["canonical_guard"]]),
    ):
        connect(builder, source, port, sinks)
    moving = [controller, proof, systems["canonical_guard"]]
    for port, name, sinks in (
        ("reconciled_field", "navigation_field", moving),
        ("reconciled_obstacles", "sensed_obstacles", moving),
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
    for source, port, sink, name in (
        (
            reference,
            "canonical_reference",
            systems["canonical_guard"],
            "canonical_position",
        ),
        (systems["canonical_guard"], "present_reason", guard, "other_reason"),
        (guard, "checked_command", ik, "emitted_command"),
        (guard, "checked_command", systems["arm_link"], "checked_command"),
    ):
        builder.Connect(source.GetOutputPort(port), sink.GetInputPort(name))
    _join_reference(builder, systems)
    _join_force(builder, systems)
    return systems


def guard_limits(scenario: Scenario) -> GuardLimits:
    """Returns the shipped limits, and what a scenario may change of them.

    It can make frames stale sooner, and take another arm: no joint goes faster than
    half of what that one can. Where it washes from nearer, the guard lets the
    skin come nearer: halfway from there to where the run is ended.
    """
    limits, control = load_limits(), scenario.control
    age = min(limits.frames.hold_age, control.max_frame_age)
    clearance = min(
        max(limits.nozzle.clearance, control.min_clearance),
        0.5 * (control.min_clearance + control.standoff),
    )
    speed = 0.5 * arm_chain(scenario.scene.arm).speed
    velocity = np.minimum(limits.joints.velocity, speed).tolist()
    return replace(
        limits,
        joints=replace(limits.joints, velocity=velocity),
        frames=replace(limits.frames, hold_age=age),
        nozzle=replace(limits.nozzle, clearance=clearance),
    )


def avoidance(limits: GuardLimits) -> AvoidanceConfig:
    """Returns how the inverse kinematics keeps the links off things.

    It stops before the guard does, and begins to avoid well before that.
    """
    stop = limits.joints.obstacle_distance + PLANNED_DISTANCE
    return AvoidanceConfig(
        stop=stop,
        near=stop + AVOIDED_WITHIN,
        self_stop=limits.joints.self_distance + PLANNED_DISTANCE,
    )


def _joint_guard(arm: Any, scenario: Scenario, limits: GuardLimits) -> JointGuard:
    # Right after the inverse kinematics' step of the same instant.
    return JointGuard(
        plant=arm,
        home=home_position(scenario.scene.arm),
        limits=limits,
        offset=0.1 * limits.loop.period,
    )


def _join_force(builder: DiagramBuilder, systems: dict[str, Any]) -> None:
    """Between the approach and who goes by it, where there is skin to press on."""
    if "force_regulator" not in systems:
        return
    regulator, approach = systems["force_regulator"], systems["approach_sequencer"]
    for port in ("standoff", "phase"):
        builder.Connect(
            approach.GetOutputPort(port), regulator.GetInputPort(f"approach_{port}")
        )
    connect(builder, systems["force_sensor"], "wrench", [regulator])
    connect(builder, systems["joint_guard"], "hold", [regulator])


def _join_reference(builder: DiagramBuilder, systems: dict[str, Any]) -> None:
    """What the reference gets, and what is made of it."""
    checked = systems["canonical_guard"].GetOutputPort("checked_velocity")
    reference = systems["canonical_reference"]
    surface, monitor = systems["surface_reference"], systems["loop_monitor"]
    tracker = systems["canonical_tracker"]
    stages = systems["stage_sequencer"]
    if "periodic_motion" not in systems:
        connect(builder, stages, "final_stage", [monitor])
        builder.Connect(checked, reference.GetInputPort("canonical_velocity"))
        connect(builder, tracker, "canonical_position", [reference, monitor])
        connect(
            builder,
            reference,
            "canonical_reference",
            [surface, systems["surface_velocity"]],
        )
        return
    # The discrete motion is followed as if there were no cycles on it.
    motion, world = systems["periodic_motion"], systems["world_reconciler"]
    builder.Connect(checked, motion.GetInputPort("canonical_velocity"))
    connect(builder, reference, "canonical_reference", [motion])
    connect(builder, tracker, "canonical_position", [motion, monitor])
    connect(builder, stages, "navigation_field", [motion])
    connect(builder, stages, "final_stage", [motion])
    pacer = systems.get("force_regulator", systems["approach_sequencer"])
    connect(builder, pacer, "phase", [motion])
    connect(builder, systems["joint_guard"], "hold", [motion])
    for source, port, sink, name in (
        (world, "restricted_areas", motion, "sensed_obstacles"),
        (motion, "canonical_target", surface, "canonical_reference"),
        (
            motion,
            "canonical_target",
            systems["surface_velocity"],
            "canonical_reference",
        ),
        (motion, "discrete_velocity", reference, "canonical_velocity"),
        (motion, "discrete_position", reference, "canonical_position"),
        (motion, "faded", monitor, "final_stage"),
    ):
        builder.Connect(source.GetOutputPort(port), sink.GetInputPort(name))
