"""A made-up run of a real person: the loop's log without the loop."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import open3d as o3d
from made_up_skill import single_branch
from scipy.spatial.transform import Rotation

from bath_drake.certificate.certify import certify
from bath_drake.composition.rollout import chain_rollout
from bath_drake.control.certified_world import WorldVerdict
from bath_drake.demonstrations.processing import (
    arc_length_mean,
    canonical_demonstrations,
)
from bath_drake.demonstrations.recording import read_recording
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.parameters import pack_field
from bath_drake.learning.skill import Skill
from bath_drake.patient.people import LABEL_BACK, load_person
from bath_drake.patient.skin import TrueSkin
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.safety.reasons import Mode, Reason
from bath_drake.scenario import Scenario, dump_scenario, find_demonstration
from bath_drake.simulation_log import SimulationLog
from bath_drake.skill_file import certified, save_skill
from bath_drake.verification import evaluate

SKIN = np.array([0.80, 0.60, 0.50])
WOUND = (0.3, -0.05, 0.16, 0.1, 0.3)
# The keys of metrics.json that others lean on.
PROMISED_METRICS = {
    "verdict",
    "checks",
    "frechet",
    "stages",
    "certificate",
    "reached_goal",
    "time_to_goal_s",
    "surface_error_mm",
    "normal_error_deg",
    "standoff_or_force",
    "restricted_entries",
    "restricted_min_clearance_mm",
    "min_beta",
    "coverage",
    "frames",
    "dropped_frames",
    "holds",
    "real_time_factor",
    "versions",
    "seed",
}


def _pose_row(R, p):
    x, y, z, w = Rotation.from_matrix(R).as_quat()
    return np.array([w, x, y, z, *p])


def demonstrate(scenario: Scenario):
    """Demonstrations, their frame and their mean."""
    return _demonstrated(tuple(scenario.demonstrations))


@cache
def _demonstrated(names: tuple[str, ...]):
    paths = [find_demonstration(name) for name in names]
    demonstrations, frame = canonical_demonstrations([read_recording(p) for p in paths])
    return demonstrations, frame, arc_length_mean(demonstrations)


def make_skill(scenario: Scenario) -> Skill:
    return _learned(tuple(scenario.demonstrations))


@cache
def _learned(names: tuple[str, ...]) -> Skill:
    demonstrations, frame, mean = _demonstrated(names)
    field = NavigationField(
        workspace=Workspace(np.zeros(2), np.array([1.6, 1.6])),
        goal=mean[-1],
        kappa=3.0,
        obstacles=ObstacleSet(
            np.array([[-0.4, 0.1, 0.1, 0.06, 0.4], [0.2, -0.25, 0.12, 0.07, -0.3]])
        ),
    )
    box = np.concatenate([d.points for d in demonstrations])
    skill = Skill(
        branches=(single_branch(field, mean[0], mean),),
        seed=7,
        config={"obstacles": 2},
        demonstration_hashes=tuple(d.sha256 for d in demonstrations),
        canonical=frame,
        scale=float(np.ptp(box, axis=0).max()),
        frechet={"mean": 0.021, "cost": 0.06, "floor": 0.055},
    )
    return certified(skill, certify(field))


def make_log(
    scenario: Scenario,
    *,
    path: np.ndarray | None = None,
    standoff_error: float = 0.0,
    tilt: float = 0.0,
    noise: float = 1.0,
    images: bool = True,
) -> SimulationLog:
    """A path washed with small errors, three frames ray-cast.

    Args:
        scenario: Whose person is washed, at rest.
        path: (n, 2) in N; None for the mean demonstration.
        standoff_error: Of the nozzle along the true normal, m.
        tilt: Of the nozzle axis against the true normal, rad.
        noise: Share of the small errors there are anyway.
        images: Whether key frames are ray-cast; else they are black.
    """
    rng = np.random.default_rng(5)
    person = load_person(scenario.scene.person)
    skin = TrueSkin(person)
    yaw = Rotation.from_euler("z", scenario.scene.person_yaw).as_matrix()
    p_WM = np.array(scenario.scene.person_position)

    time = np.arange(0.0, 16.0, 0.05)
    phase = np.where(time < 2.0, 0, np.where(time < 4.0, 1, 2)).astype(float)
    share = np.clip((time - 4.0) / 11.5, 0.0, 1.0) ** 1.2
    path = demonstrate(scenario)[2] if path is None else path
    knots = np.linspace(0.0, 1.0, len(path))
    p_N = np.column_stack([np.interp(share, knots, path[:, k]) for k in (0, 1)])
    p_N += noise * 0.006 * np.sin(3.0 * time)[:, None]
    true = skin.canonical_map
    plane = true.world_from_canonical(p_N) + 0.5 * true.normal_W
    hits, _ = skin.hit(plane, np.tile(-true.normal_W, (len(plane), 1)))
    _, points, normals = skin.nearest(hits)
    standoff = np.interp(time, [0.0, 2.0, 4.0, 16.0], [0.14, 0.14, 0.06, 0.06])
    wobble = 0.002 * np.sin(2.0 * time) + rng.normal(0.0, 2e-4, len(time))
    off = standoff + standoff_error + noise * wobble
    tips = (points + normals * off[:, None]) @ yaw.T + p_WM
    axes = -normals @ yaw.T
    side = np.cross(np.array([0.0, 0.0, 1.0]), axes)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    axes = np.cos(tilt) * axes + np.sin(tilt) * side
    side = np.cos(tilt) * side - np.sin(tilt) * (-normals @ yaw.T)
    rotations = np.stack([side, np.cross(axes, side), axes], axis=2)
    held = (time > 7.0) & (time < 7.4)

    camera = scenario.scene.camera
    model = PinholeCamera()
    X_WC = np.eye(4)
    X_WC[:3, :3], X_WC[:3, 3] = camera.rotation(), camera.eye
    if images:
        colour, depth, mask = render(person, model, X_WC, yaw, p_WM, skin, scenario)
    else:
        colour = np.zeros((*model.shape, 3), dtype=np.uint8)
        depth, mask = np.zeros(model.shape), np.zeros(model.shape, dtype=bool)
    robot = np.zeros(model.shape, dtype=bool)
    robot[280:, 300:352] = True
    depth[robot], colour[robot] = 0.7, (70, 74, 80)
    row = CanonicalMap(yaw @ true.R_WP, yaw @ true.p_WP + p_WM, true.half_extents)
    keyframe_map = np.concatenate([row.R_WP.ravel(), row.p_WP, row.half_extents])
    sensed = scenario.scene.wound is not None
    areas = np.array([[k, *WOUND] for k in range(3)]) if sensed else np.empty((0, 6))
    world = make_skill(scenario).field.with_obstacles(ObstacleSet(areas[:1, 1:]))
    count = len(time)
    return SimulationLog(
        time=time,
        canonical_position=p_N + rng.normal(0.0, 1e-3, (count, 2)),
        canonical_reference=p_N + 0.01,
        rejected_frames=np.zeros(count),
        seen_through=np.where(time < 1.0, 0.0, 0.002),
        guard_mode=held * float(Mode.HOLD),
        guard_reason=held * float(Reason.BODY_LOST),
        checked_command=np.zeros((count, 14)),
        canonical_offset=np.zeros((count, 2)),
        stage=np.zeros(count),
        phase=phase,
        standoff=standoff,
        certificate_verdict=np.full(count, float(WorldVerdict.PROVED)),
        certificate_seconds=np.where(time < 2.0, 0.004, 0.006),
        certified_start=np.tile(p_N[0], (count, 1)),
        arm_state=np.zeros((count, 14)),
        joint_command=np.zeros((count, 14)),
        contact_wrench=np.zeros((count, 6)),
        measured_wrench=np.zeros((count, 6)),
        asked_force=np.zeros(count),
        nozzle_pose=np.array(
            [_pose_row(R, p) for R, p in zip(rotations, tips, strict=True)]
        ),
        body_pose=np.tile(_pose_row(yaw, p_WM), (count, 1)),
        guard_counts=np.eye(len(Reason))[Reason.BODY_LOST],
        wall_time=np.column_stack([time, 1.3 * time + 0.1 * np.sin(time)]),
        frames=np.array(480),
        outcome="GOAL_REACHED",
        keyframe_time=np.array([5.0, 9.0, 15.0]),
        keyframe_colour=np.stack([colour] * 3),
        keyframe_depth=np.stack([depth] * 3),
        keyframe_mask=np.stack([mask & ~robot] * 3),
        keyframe_robot=np.stack([robot] * 3),
        keyframe_map=np.stack([keyframe_map] * 3),
        keyframe_areas=areas,
        keyframe_world=np.stack([pack_field(world, 16)] * 3),
        world_time=np.zeros(1),
        worlds=pack_field(world, 16)[None],
        keyframe_reach=np.array([[0.99, 0.0], [0.97, 0.03], [0.95, 0.05]]),
        intrinsics=np.array([512, 424, model.fx, model.fy, model.cx, model.cy]),
        X_WC=X_WC,
    )


def make_composed_log(scenario: Scenario, skill: Skill) -> SimulationLog:
    """The log of a run along a composed skill's own path, its worlds the skill's."""
    found = chain_rollout(skill.start, skill.chain)
    log = make_log(scenario, path=found.path)
    # As `make_log` goes along the path.
    share = np.clip((log.time - 4.0) / 11.5, 0.0, 1.0) ** 1.2
    at = np.minimum((share * len(found.path)).astype(int), len(found.path) - 1)
    stage = found.stages[at]
    rows = [pack_field(field, 16) for field in skill.chain.fields]
    begun = [log.time[np.argmax(stage == k)] for k in range(len(rows))]
    seen = stage[np.searchsorted(log.time, log.keyframe_time)]
    return replace(
        log,
        stage=stage.astype(float),
        world_time=np.array(begun),
        worlds=np.array(rows),
        keyframe_areas=np.empty((0, 6)),
        keyframe_world=np.array([rows[k] for k in seen]),
    )


def render(person, model, X_WC, yaw, p_WM, skin, scenario):
    """Colour, depth and the back's mask by ray casting."""
    scene = o3d.t.geometry.RaycastingScene()
    vertices = (person.vertices @ yaw.T + p_WM).astype(np.float32)
    scene.add_triangles(
        o3d.core.Tensor(vertices), o3d.core.Tensor(person.triangles.astype(np.uint32))
    )
    rays = model.rays @ X_WC[:3, :3].T
    origin = np.broadcast_to(X_WC[:3, 3], rays.shape)
    cast = scene.cast_rays(
        o3d.core.Tensor(np.concatenate([origin, rays], axis=2).astype(np.float32))
    )
    depth = cast["t_hit"].numpy().astype(np.float64)
    hit = np.isfinite(depth)
    normals = cast["primitive_normals"].numpy()
    facing = np.abs((normals * rays).sum(axis=2)) / np.linalg.norm(rays, axis=2)
    image = np.where(hit[..., None], SKIN * (0.4 + 0.6 * facing)[..., None], 0.85)
    corners = person.triangles[np.where(hit, cast["primitive_ids"].numpy(), 0)]
    on_back = hit & (person.labels[corners] == LABEL_BACK).all(axis=2)
    if scenario.scene.wound is not None:
        points = np.where(hit[..., None], origin + rays * depth[..., None], 0.0)
        p_N = skin.canonical_map.canonical_from_world((points - p_WM) @ yaw)
        x, y, a, b, angle = WOUND
        c, s = np.cos(angle), np.sin(angle)
        local = (p_N - [x, y]) @ np.array([[c, -s], [s, c]])
        image[on_back & (((local / [a, b]) ** 2).sum(axis=2) < 1.0)] = 0.1
    return (255 * image).astype(np.uint8), depth, on_back


def write_run(folder: Path, scenario: Scenario, skill: Skill | None = None) -> Path:
    skill = skill or make_skill(scenario)
    log = make_log(scenario) if skill.is_single else make_composed_log(scenario, skill)
    folder.mkdir(parents=True)
    (folder / "scenario.yaml").write_text(dump_scenario(scenario))
    save_skill(folder / "skill.yaml", skill)
    log.save(folder / "log.npz")
    metrics = evaluate(log, scenario, skill).metrics
    (folder / "metrics.json").write_text(json.dumps(metrics))
    return folder
