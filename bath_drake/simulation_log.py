"""What one closed-loop run recorded, as arrays; saved as one .npz file."""

import io
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.errors import RunFolderError
from bath_drake.files import read_archive, write_atomically
from bath_drake.notation import BoolArray, ByteArray, FloatArray, IntArray
from bath_drake.safety.reasons import Reason

_MAX_BYTES = 512 * 1024 * 1024


@dataclass(frozen=True, eq=False, kw_only=True)
class SimulationLog:
    """The series of a run (T samples), its key frames (K) and its counts.

    Attributes:
        time: (T,) s.
        canonical_position: (T, 2) of the washed point, as the loop saw it, in N.
        canonical_reference: (T, 2) what the discrete motion aimed at, in N.
        canonical_offset: (T, 2) the periodic motion on it; zero without one.
        stage: (T,) which field of the skill's chain was followed, from 0.
        phase: (T,) a `bath_drake.control.approach.Phase` each.
        standoff: (T,) commanded distance off the skin, m.
        guard_mode: (T,) a `bath_drake.safety.reasons.Mode` each, of the joint guard;
            zero in older logs.
        guard_reason: (T,) a `bath_drake.safety.reasons.Reason` each, likewise.
        checked_command: (T, 14) what the joint guard emitted, rad and rad/s; in older
            logs what it was told.
        rejected_frames: (T,) how many frames showed a map that no body can have come
            to; zero in older logs.
        seen_through: (T,) share of the arm's pixels that showed what is behind it, as
            some frames agreed; zero without a camera and in older logs.
        certificate_verdict: (T,) a `bath_drake.control.certified_world.WorldVerdict`
            each: of the world in force.
        certificate_seconds: (T,) what its proof took, s.
        certified_start: (T, 2) where the reference was then, in N.
        arm_state: (T, 14) joint positions and velocities, rad and rad/s.
        joint_command: (T, 14) the commanded ones.
        contact_wrench: (T, 6) the true one on the tool, in E: torque, N m, and force,
            N; zero where nothing can be touched.
        measured_wrench: (T, 6) what the force sensor said, likewise.
        asked_force: (T,) that the tool was to press with, N; zero while it was away.
        nozzle_pose: (T, 7) X_WE as quaternion w, x, y, z and position, m.
        body_pose: (T, 7) the true X_WM likewise; for verification only.
        guard_counts: (number of reasons,) how often each of the joint guard's began;
            zero in older logs.
        wall_time: (S, 2) simulated and wall-clock seconds, as the run went on.
        frames: Camera frames taken.
        outcome: Name of a `bath_drake.safety.outcome.LoopOutcome`.
        keyframe_time: (K,) s.
        keyframe_colour: (K, H, W, 3) what the camera saw.
        keyframe_depth: (K, H, W) m, not finite where nothing is.
        keyframe_mask: (K, H, W) the segmented back.
        keyframe_robot: (K, H, W) the robot's own pixels.
        keyframe_map: (K, 14) the canonical map: R_WP row by row, p_WP, half extents.
        keyframe_areas: (n, 6) index of the key frame, then the ellipse in N.
        keyframe_world: (K, n) the field that was driven in, sensed areas included,
            packed (`bath_drake.field.parameters`).
        world_time: (W,) s, when a world was first driven in, to a tenth of a second.
        worlds: (W, n) these worlds, packed likewise.
        keyframe_reach: (K, 3) visible fraction of the back, share of it that the
            robot hides, and how far the skin filled in for that can be believed; in
            older logs (K, 2), without the last.
        intrinsics: (6,) of the camera: width, height, fx, fy, cx, cy.
        X_WC: (4, 4) pose of the camera.
    """

    time: FloatArray
    canonical_position: FloatArray
    canonical_reference: FloatArray
    canonical_offset: FloatArray
    stage: FloatArray
    phase: FloatArray
    standoff: FloatArray
    guard_mode: FloatArray
    guard_reason: FloatArray
    checked_command: FloatArray
    rejected_frames: FloatArray
    seen_through: FloatArray
    certificate_verdict: FloatArray
    certificate_seconds: FloatArray
    certified_start: FloatArray
    arm_state: FloatArray
    joint_command: FloatArray
    contact_wrench: FloatArray
    measured_wrench: FloatArray
    asked_force: FloatArray
    nozzle_pose: FloatArray
    body_pose: FloatArray
    guard_counts: FloatArray
    wall_time: FloatArray
    frames: IntArray
    outcome: str
    keyframe_time: FloatArray
    keyframe_colour: ByteArray
    keyframe_depth: FloatArray
    keyframe_mask: BoolArray
    keyframe_robot: BoolArray
    keyframe_map: FloatArray
    keyframe_areas: FloatArray
    keyframe_world: FloatArray
    world_time: FloatArray
    worlds: FloatArray
    keyframe_reach: FloatArray
    intrinsics: FloatArray
    X_WC: FloatArray

    def save(self, path: Path) -> None:
        """Writes the log; a reader never sees half of it."""
        content = io.BytesIO()
        arrays: dict[str, Any] = {
            f.name: np.asarray(getattr(self, f.name)) for f in fields(self)
        }
        np.savez_compressed(content, **arrays)
        write_atomically(path, content.getvalue(), error=RunFolderError)

    @staticmethod
    def load(path: Path) -> "SimulationLog":
        """Reads a log; raises RunFolderError naming file and key."""
        archive = read_archive(path, limit=_MAX_BYTES, error=RunFolderError)
        names = [f.name for f in fields(SimulationLog)]
        arrays: dict[str, Any] = {k: archive[k] for k in names if k in archive}
        if "canonical_reference" in arrays:
            # Logs from before there were such series.
            none = np.zeros_like(arrays["canonical_reference"])
            arrays.setdefault("canonical_offset", none)
            arrays.setdefault("rejected_frames", np.zeros(len(none)))
            arrays.setdefault("seen_through", np.zeros(len(none)))
            arrays.setdefault("guard_mode", np.zeros(len(none)))
            arrays.setdefault("guard_reason", np.zeros(len(none)))
            arrays.setdefault("contact_wrench", np.zeros((len(none), 6)))
            arrays.setdefault("measured_wrench", np.zeros((len(none), 6)))
            arrays.setdefault("asked_force", np.zeros(len(none)))
        if "joint_command" in arrays:
            arrays.setdefault("checked_command", arrays["joint_command"])
        counts = arrays.setdefault("guard_counts", np.zeros(0))
        if counts.ndim == 1 and len(counts) < len(Reason):
            # And those from when there were fewer reasons.
            more = np.zeros(len(Reason) - len(counts))
            arrays["guard_counts"] = np.append(counts, more)
        missing = [name for name in names if name not in arrays]
        if missing:
            raise RunFolderError(f"{path}: lacks {', '.join(missing)}")
        return SimulationLog(**{**arrays, "outcome": str(arrays["outcome"])})

    @property
    def real_time_factor(self) -> float:
        """Simulated over wall-clock seconds, after the first stretch.

        In that one kernels are compiled and the renderer loads its shaders.
        """
        # A run of one stretch has nothing else to tell.
        first = 1 if len(self.wall_time) > 2 else 0
        simulated, wall = self.wall_time[-1] - self.wall_time[first]
        return float(simulated / wall) if wall > 0.0 else 0.0
