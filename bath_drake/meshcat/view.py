"""Path, normals, obstacles and body box on the recorded person in Meshcat.

Everything is drawn once in the person's frame M, under one Meshcat path that the
recording moves with the person. Lines are thin tubes: browsers draw a line one
pixel wide, whatever width is asked for.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.geometry import Meshcat, Rgba
from pydrake.math import RigidTransform

from bath_drake.composition.chain import Chain
from bath_drake.control.approach import Phase
from bath_drake.errors import RunFolderError
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.files import write_atomically
from bath_drake.learning.skill import Skill
from bath_drake.notation import FloatArray, IntArray
from bath_drake.report import style
from bath_drake.report.keyframe import Keyframe
from bath_drake.simulation_log import SimulationLog
from bath_drake.verification import Evaluation, pose_from_row

ROOT = "/overlays"
_FRAMES_PER_SECOND = 15.0
_SIDES = 6
_LIFT = 0.004  # m off the skin, so that nothing sinks into it
_NORMAL_LENGTH, _NORMAL_SPACING = 0.05, 0.025  # m
_OUTLINE_POINTS = 96
_BOX_POINTS = 40
_OBSTACLE, _WAITING = "#23272e", "#9aa4af"


@dataclass(frozen=True, eq=False)
class Overlay:
    """Lines of one kind, to be drawn as tubes.

    Attributes:
        name: Below `ROOT`.
        lines: (n, 3) points each, in M, m.
        colour: As #rrggbb.
        radius: Of the tubes, m.
        stage: If not None, it is seen only while that field of the chain is followed,
            or, where `waits`, only while it is not.
        waits: See `stage`.
    """

    name: str
    lines: tuple[FloatArray, ...]
    colour: str
    radius: float
    stage: int | None = None
    waits: bool = False

    def is_seen(self, stage: int) -> bool:
        """Whether it is seen while a field of the chain is followed."""
        return self.stage is None or (stage == self.stage) != self.waits


# Gives X_MMr at a time, s: how a bending person's back has moved within M from rest.
BackMotion = Callable[[float], RigidTransform]


def at_rest(t: float) -> RigidTransform:
    """The motion of a back that does not bend."""
    return RigidTransform()


def overlays_of_run(
    log: SimulationLog,
    evaluation: Evaluation,
    skill: Skill,
    back: BackMotion = at_rest,
) -> list[Overlay]:
    """Returns what there is to draw of a run; kinds without lines are left out."""
    path = evaluation.washed_points_M + _LIFT * evaluation.normals_M
    overlays = [
        Overlay("path", _whole(path), style.REPRODUCTION, 0.003),
        Overlay("normals", normal_lines(evaluation), style.NORMAL, 0.0012),
    ]
    frame = _clearest_frame(log)
    if frame is not None:
        overlays += _seen_in(frame, skill, back)
    return [overlay for overlay in overlays if overlay.lines]


def _whole(path: FloatArray) -> tuple[FloatArray, ...]:
    return (path,) if len(path) > 1 else ()


def normal_lines(evaluation: Evaluation) -> tuple[FloatArray, ...]:
    """Short lines (2, 3) along the skin's normals, evenly along the washed path."""
    points, normals = evaluation.washed_points_M, evaluation.normals_M
    if len(points) < 2:
        return ()
    length = np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))
    count = int(length[-1] / _NORMAL_SPACING) + 1
    chosen = np.searchsorted(length, _NORMAL_SPACING * np.arange(count))
    chosen = np.minimum(chosen, len(points) - 1)
    return tuple(
        np.array([points[k], points[k] + _NORMAL_LENGTH * normals[k]]) for k in chosen
    )


def _clearest_frame(log: SimulationLog) -> Keyframe | None:
    """The key frame with a back that the robot hides least."""
    usable = [k for k in range(len(log.keyframe_time)) if log.keyframe_mask[k].any()]
    if not usable:
        return None
    return Keyframe(log, min(usable, key=lambda k: float(log.keyframe_reach[k, 1])))


def _seen_in(frame: Keyframe, skill: Skill, back: BackMotion) -> list[Overlay]:
    """Obstacles, restricted areas, box, start and goal, on the skin of one frame."""
    X_WM = pose_from_row(_at(frame.log, frame.time)) @ back(float(frame.time))
    X_MW = X_WM.inverse()
    R_MW = np.asarray(X_MW.rotation().matrix())

    def in_M(p_W: FloatArray) -> FloatArray:
        lifted = p_W + _LIFT * frame.canonical_map.normal_W
        return np.asarray(lifted @ R_MW.T + X_MW.translation())

    def draped(p_N: FloatArray) -> tuple[FloatArray, ...]:
        return split_at_gaps(in_M(frame.on_skin(p_N)[1]))

    def outlines(obstacles: ObstacleSet) -> tuple[FloatArray, ...]:
        rings = obstacles.boundary(_OUTLINE_POINTS)
        return sum((draped(np.vstack([r, r[:1]])) for r in rings), ())

    box = in_M(frame.canonical_map.world_from_canonical(square(_BOX_POINTS)))
    overlays = [
        Overlay("restricted_areas", outlines(frame.areas), style.RESTRICTED, 0.0035),
        Overlay("canonical_box", (box,), style.BOX, 0.0015),
    ]
    overlays += _stage_overlays(skill.chain, outlines, draped)
    for name, p_N in (("start", skill.start), ("goal", skill.chain.goal)):
        at = frame.on_skin(p_N)[1]
        if np.isfinite(at).all():
            # A short, thick tube along the normal is a pin's head.
            pin = in_M(np.vstack([at, at + 0.012 * frame.canonical_map.normal_W]))
            colour = "#ffffff" if name == "start" else style.INK
            overlays.append(Overlay(name, (pin,), colour, 0.009))
    return overlays


def _stage_overlays(
    chain: Chain,
    outlines: Callable[[ObstacleSet], tuple[FloatArray, ...]],
    draped: Callable[[FloatArray], tuple[FloatArray, ...]],
) -> list[Overlay]:
    """Obstacles and gates: of the field that is followed strong, of the others faint.

    Args:
        chain: The skill's.
        outlines: Lays obstacles onto the skin.
        draped: Lays a line (n, 2) in N onto the skin.
    """
    if len(chain) == 1:
        lines = outlines(chain.fields[0].obstacles)
        return [Overlay("virtual_obstacles", lines, _OBSTACLE, 0.002)]
    overlays = []
    for k, field in enumerate(chain.fields):
        lines = outlines(field.obstacles)
        name = f"virtual_obstacles/field_{k}"
        overlays += [
            Overlay(f"{name}/followed", lines, _OBSTACLE, 0.002, k),
            Overlay(f"{name}/waiting", lines, _WAITING, 0.0008, k, waits=True),
        ]
    for k, gate in enumerate(chain.gates):
        line = draped(gate.outline())
        overlays.append(Overlay(f"gates/gate_{k}", line, style.NORMAL, 0.0008))
    return overlays


def _at(log: SimulationLog, time: float) -> FloatArray:
    """The row of the body's pose at a time."""
    return np.asarray(log.body_pose[_sample(log, time)])


def _sample(log: SimulationLog, time: float) -> int:
    """The sample nearest to a time."""
    return int(np.argmin(np.abs(log.time - time)))


def square(points_a_side: int) -> FloatArray:
    """The outline (n, 2) of [-1, 1]^2, closed."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]], dtype=float)
    knots = np.linspace(0.0, 4.0, 4 * points_a_side + 1)
    return np.column_stack([np.interp(knots, range(5), corners[:, k]) for k in (0, 1)])


def split_at_gaps(points: FloatArray) -> tuple[FloatArray, ...]:
    """Cuts a line (n, 3) where points are not finite; pieces have 2 points or more."""
    finite = np.isfinite(points).all(axis=1)
    edges = np.flatnonzero(np.diff(finite.astype(int))) + 1
    pieces = np.split(points, edges)
    return tuple(p for p in pieces if len(p) > 1 and np.isfinite(p).all())


def tubes(lines: Sequence[FloatArray], radius: float) -> tuple[FloatArray, IntArray]:
    """Turns lines (n, 3) into one mesh: vertices (v, 3) and triangles (t, 3)."""
    vertices, triangles, offset = [], [], 0
    for line in lines:
        rings = _rings(line, radius)
        count = len(line)
        vertices.append(rings.reshape(-1, 3))
        triangles.append(_tube_triangles(count) + offset)
        offset += count * _SIDES
    return np.concatenate(vertices), np.concatenate(triangles)


def _rings(line: FloatArray, radius: float) -> FloatArray:
    """Rings (n, sides, 3) around a line, square to it."""
    along = np.gradient(line, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    # Any direction far from the line's own will do: the tube is round.
    helper = np.eye(3)[np.argmin(np.abs(along), axis=1)]
    across = np.cross(along, helper)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
    third = np.cross(along, across)
    t = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    offsets = (
        np.cos(t)[:, None] * across[:, None, :] + np.sin(t)[:, None] * third[:, None, :]
    )
    return np.asarray(line[:, None, :] + radius * offsets)


def _tube_triangles(count: int) -> IntArray:
    side = np.arange(_SIDES)
    after = (side + 1) % _SIDES
    base = _SIDES * np.arange(count - 1)[:, None]
    low, low_after = base + side, base + after
    high, high_after = low + _SIDES, low_after + _SIDES
    walls = np.stack(
        [low, low_after, high, low_after, high_after, high], axis=-1
    ).reshape(-1, 3)
    fan = np.array([[0, k + 1, k] for k in range(1, _SIDES - 1)])
    cap = fan[:, ::-1] + _SIDES * (count - 1)
    return np.concatenate([walls, fan, cap]).astype(np.int64)


def draw_overlays(meshcat: Meshcat, overlays: Sequence[Overlay]) -> None:
    """Draws overlays below `ROOT`, in place of earlier ones."""
    meshcat.Delete(ROOT)
    for overlay in overlays:
        vertices, triangles = tubes(overlay.lines, overlay.radius)
        faces: Any = triangles.T.astype(np.int32)
        corners: Any = vertices.T
        meshcat.SetTriangleMesh(
            f"{ROOT}/{overlay.name}",
            corners,
            faces,
            Rgba(*style.rgb(overlay.colour), 1),
        )


def record_overlays(
    meshcat: Meshcat,
    log: SimulationLog,
    evaluation: Evaluation,
    skill: Skill,
    back: BackMotion = at_rest,
) -> None:
    """Adds a run's overlays to what Meshcat recorded of it.

    To be called after StopRecording and before PublishRecording.

    Args:
        meshcat: Holds the recording, its time that of the log.
        log: The run; its true body poses carry the overlays along.
        evaluation: Where the skin was washed.
        skill: What was reproduced.
        back: How it bends.
    """
    overlays = overlays_of_run(log, evaluation, skill, back)
    draw_overlays(meshcat, overlays)
    by_stage = [overlay for overlay in overlays if overlay.stage is not None]
    animation = meshcat.get_mutable_recording()
    last, shown = -1, -1
    for time in np.arange(0.0, log.time[-1], 1.0 / _FRAMES_PER_SECOND):
        X_WM = pose_from_row(_at(log, float(time))) @ back(float(time))
        frame = animation.frame(float(time))
        if frame != last:
            animation.SetTransform(frame, ROOT, X_WM)
            stage = int(log.stage[_sample(log, float(time))])
            if stage != shown:
                for overlay in by_stage:
                    seen = overlay.is_seen(stage)
                    path = f"{ROOT}/{overlay.name}"
                    animation.SetProperty(frame, path, "visible", seen)
            shown = stage
        last = frame
    last_pose = pose_from_row(log.body_pose[-1]) @ back(float(log.time[-1]))
    meshcat.SetTransform(ROOT, last_pose)
    for overlay in by_stage:
        seen = overlay.is_seen(int(log.stage[-1]))
        meshcat.SetProperty(f"{ROOT}/{overlay.name}", "visible", seen)
    look_at_the_back(meshcat, log)


def look_at_the_back(meshcat: Meshcat, log: SimulationLog) -> None:
    """Puts the viewer above the robot's free side, looking at the back; no grid.

    The arm comes from the person's left and from above: from the right it hides least.
    """
    washing = log.nozzle_pose[log.phase == Phase.WASH]
    nozzle = (washing if len(washing) else log.nozzle_pose)[:, 4:].mean(axis=0)
    back = nozzle - log.X_WC[:3, 3]
    level = np.array([back[0], back[1], 0.0])
    level /= np.linalg.norm(level)
    side = np.array([level[1], -level[0], 0.0])
    eye = nozzle - 0.6 * level + 0.8 * side + np.array([0.0, 0.0, 0.3])
    meshcat.SetCameraPose(eye, nozzle)
    for helper in ("/Grid", "/Axes"):
        meshcat.SetProperty(helper, "visible", False)


def write_static_page(meshcat: Meshcat, path: Path) -> None:
    """Writes the scene and its recording as one page that loads nothing.

    Raises:
        RunFolderError: If the file cannot be written.
    """
    write_atomically(path, meshcat.StaticHtml(), error=RunFolderError)
