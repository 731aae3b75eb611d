"""Runs a reproduction Diagram to its end and keeps what happened."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator, SimulatorStatus
from pydrake.systems.framework import Context, Diagram

from bath_drake.diagrams.logs import log_name, logged_ports
from bath_drake.field.parameters import pack_field
from bath_drake.notation import ByteArray, FloatArray
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.scenario import Scenario
from bath_drake.scene import make_control_plant
from bath_drake.simulation_log import SimulationLog
from bath_drake.systems._ports import drake_vector
from bath_drake.systems.nozzle_kinematics import NOZZLE_FRAME

Progress = Callable[[float, float], None]

_CHUNK_S = 0.1
_KEYFRAME_PERIOD_S = 1.0
_MOST_OBSTACLES = 64


def run(
    diagram: Diagram,
    scenario: Scenario,
    progress: Progress | None = None,
    *,
    context: Context | None = None,
) -> SimulationLog:
    """Simulates until the loop monitor ends the run.

    One Diagram serves many runs, each with a Context of its own.

    Args:
        diagram: What `bath_drake.diagrams.build_reproduction` built.
        scenario: What it was built from.
        progress: Called with simulated and longest seconds as the run goes on.
        context: Of the Diagram, where the run begins, its time included: a multiple of
            the camera's period. None begins at time zero, all as built.

    Raises:
        RuntimeError: If the Diagram has no loop monitor that ends the run.
    """
    simulator = Simulator(diagram) if context is None else Simulator(diagram, context)
    context = simulator.get_mutable_context()
    start = context.get_time()
    _set_span(diagram, context, start, scenario.duration)
    simulator.Initialize()
    wall_time = [(start, 0.0)]
    keyframes: list[dict[str, Any]] = []
    worlds = [(start, _packed_world(diagram, context))]
    outcome = ""
    while not outcome:
        boundary = start + len(wall_time) * _CHUNK_S
        if boundary - start > scenario.duration + 1.0:
            raise RuntimeError("nothing ended the run: is there a loop_monitor?")
        begin = time.perf_counter()
        status = simulator.AdvanceTo(boundary)
        elapsed = time.perf_counter() - begin
        if status.reason() == SimulatorStatus.ReturnReason.kReachedTerminationCondition:
            outcome = status.message()
        now = context.get_time()
        wall_time.append((now, wall_time[-1][1] + elapsed))
        world = _packed_world(diagram, context)
        if not np.array_equal(world, worlds[-1][1]):
            worlds.append((now, world))
        # Outside the clock: no loop needs them.
        due = start + len(keyframes) * _KEYFRAME_PERIOD_S + _CHUNK_S
        if outcome or now >= due - 1e-9:
            keyframes.append(_keyframe(diagram, context, scenario))
        if progress is not None:
            progress(now - start, scenario.duration)
    return _collect(diagram, context, scenario, wall_time, keyframes, worlds, outcome)


def _set_span(
    diagram: Diagram, context: Context, begin: float, duration: float
) -> None:
    if diagram.HasSubsystemNamed("loop_monitor"):
        monitor: Any = diagram.GetSubsystemByName("loop_monitor")
        own = monitor.GetMyMutableContextFromRoot(context)
        monitor.set_span(own, begin, duration)


def _names(diagram: Diagram) -> set[str]:
    return {system.get_name() for system in diagram.GetSystems()}


def _output(diagram: Diagram, context: Context, system: str, port: str) -> Any:
    subsystem = diagram.GetSubsystemByName(system)
    return subsystem.GetOutputPort(port).Eval(subsystem.GetMyContextFromRoot(context))


def _keyframe(diagram: Diagram, context: Context, scenario: Scenario) -> dict[str, Any]:
    observation = _output(diagram, context, "body_segmenter", "body_observation")
    canonical_map = _output(diagram, context, "canonical_projector", "canonical_map")
    areas = _output(diagram, context, "restricted_area_detector", "sensed_obstacles")
    shape = scenario.scene.camera.height, scenario.scene.camera.width
    colour, depth = _images(diagram, context, shape)
    # Before the first frame, which may be lost, there are no masks.
    nothing = np.zeros(shape, dtype=bool)
    return {
        "time": context.get_time(),
        "colour": colour,
        "depth": depth,
        "mask": observation.mask if observation.mask.size else nothing,
        "robot": observation.robot_mask if observation.robot_mask.size else nothing,
        "map": _map_row(canonical_map),
        "areas": areas.theta,
        "world": _packed_world(diagram, context),
        "reach": (
            observation.visible_fraction,
            observation.hidden_share,
            observation.completion_quality,
        ),
    }


def _images(
    diagram: Diagram, context: Context, shape: tuple[int, int]
) -> tuple[ByteArray, FloatArray]:
    """Colours (H, W, 3) and depths (H, W); black and of nothing without a camera."""
    if not diagram.HasSubsystemNamed("camera"):
        return np.zeros((*shape, 3), np.uint8), np.full(shape, np.inf, np.float32)
    colour = _last_image(diagram, context, "colour")
    depth = _last_image(diagram, context, "depth")
    return colour[:, :, :3].copy(), depth[:, :, 0].copy()


def _last_image(diagram: Diagram, context: Context, kind: str) -> Any:
    """As the loop saw it: with what noise and faults the Diagram has."""
    rendered = {"colour": "color_image", "depth": "depth_image_32f"}[kind]
    for system, port in (
        ("camera_faults", f"{kind}_image"),
        (f"{kind}_noise", f"noisy_{kind}_image"),
        ("camera", rendered),
    ):
        if diagram.HasSubsystemNamed(system):
            return _output(diagram, context, system, port).data
    raise RuntimeError("the Diagram has no camera")


def _packed_world(diagram: Diagram, context: Context) -> FloatArray:
    """The field that is driven in, sensed areas included."""
    virtual = _output(diagram, context, "world_reconciler", "reconciled_field")
    areas = _output(diagram, context, "world_reconciler", "reconciled_obstacles")
    return pack_field(virtual.with_obstacles(areas), _MOST_OBSTACLES)


def _map_row(canonical_map: CanonicalMap) -> FloatArray:
    return np.concatenate(
        [
            canonical_map.R_WP.ravel(),
            canonical_map.p_WP,
            canonical_map.half_extents,
        ]
    )


def _collect(
    diagram: Diagram,
    context: Context,
    scenario: Scenario,
    wall_time: list[tuple[float, float]],
    keyframes: list[dict[str, Any]],
    worlds: list[tuple[float, FloatArray]],
    outcome: str,
) -> SimulationLog:
    series: dict[str, FloatArray] = {}
    for system, port in logged_ports(_names(diagram)):
        sink: Any = diagram.GetSubsystemByName(log_name(system, port))
        log = sink.FindLog(context)
        series[port] = log.data().T.copy()
        series["time"] = log.sample_times().copy()
    count = len(series["time"])
    camera = scenario.scene.camera
    X_WC = np.eye(4)
    X_WC[:3, :3], X_WC[:3, 3] = camera.rotation(), camera.eye

    def stacked(key: str) -> Any:
        return np.array([frame[key] for frame in keyframes])

    return SimulationLog(
        time=series["time"],
        canonical_position=series["canonical_position"],
        canonical_reference=series["canonical_reference"],
        canonical_offset=series.get(
            "canonical_offset", np.zeros_like(series["canonical_reference"])
        ),
        stage=series["stage"][:, 0],
        phase=series["phase"][:, 0],
        standoff=series["standoff"][:, 0],
        guard_mode=series["guard_mode"][:, 0],
        guard_reason=series["guard_reason"][:, 0],
        checked_command=series["checked_command"],
        rejected_frames=series["rejected_frames"][:, 0],
        seen_through=series.get("camera_status", np.zeros((count, 1)))[:, 0],
        certificate_verdict=series["certificate_verdict"][:, 0],
        certificate_seconds=series["certificate_seconds"][:, 0],
        certified_start=series["certified_start"],
        arm_state=series["arm_state"],
        joint_command=series["joint_command"],
        # Where nothing can be touched nothing of it is logged.
        contact_wrench=series.get("contact_wrench", np.zeros((count, 6))),
        measured_wrench=series.get("wrench", np.zeros((count, 7)))[:, 1:],
        asked_force=series.get("asked_force", np.zeros((count, 1)))[:, 0],
        nozzle_pose=_nozzle_poses(scenario, series["arm_state"]),
        body_pose=series["body_pose"],
        guard_counts=_output(diagram, context, "joint_guard", "guard_counts").copy(),
        wall_time=np.array(wall_time),
        frames=np.array(_frames(scenario, wall_time[-1][0] - wall_time[0][0])),
        outcome=outcome,
        keyframe_time=stacked("time"),
        keyframe_colour=stacked("colour"),
        keyframe_depth=stacked("depth"),
        keyframe_mask=stacked("mask"),
        keyframe_robot=stacked("robot"),
        keyframe_map=stacked("map"),
        keyframe_areas=_numbered_rows(keyframes),
        keyframe_world=stacked("world"),
        keyframe_reach=stacked("reach"),
        world_time=np.array([time for time, _ in worlds]),
        worlds=np.array([world for _, world in worlds]),
        intrinsics=np.array(
            [getattr(camera, k) for k in ("width", "height", "fx", "fy", "cx", "cy")],
            dtype=np.float64,
        ),
        X_WC=X_WC,
    )


def _frames(scenario: Scenario, seconds: float) -> int:
    """How many frames the camera took: ideal perception takes none."""
    if scenario.perception.source == "ideal":
        return 0
    return int(seconds * scenario.perception.camera_rate) + 1


def _numbered_rows(keyframes: list[dict[str, Any]]) -> FloatArray:
    rows = [
        np.concatenate([[k], row])
        for k, frame in enumerate(keyframes)
        for row in frame["areas"]
    ]
    return np.array(rows).reshape(-1, 6)


def _nozzle_poses(scenario: Scenario, arm_state: FloatArray) -> FloatArray:
    """X_WE of each sample, from the joint positions: (T, 7)."""
    plant = make_control_plant(scenario.scene.arm)
    context = plant.CreateDefaultContext()
    frame = plant.GetFrameByName(NOZZLE_FRAME)
    poses = np.zeros((len(arm_state), 7))
    for row, state in zip(poses, arm_state, strict=True):
        plant.SetPositions(context, drake_vector(state[:7]))
        row[:] = _pose_row(frame.CalcPoseInWorld(context))
    return poses


def _pose_row(X: RigidTransform) -> FloatArray:
    return np.concatenate([X.rotation().ToQuaternion().wxyz(), X.translation()])
