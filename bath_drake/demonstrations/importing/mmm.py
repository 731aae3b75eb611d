"""MMM XML of the KIT whole-body motion database: one segment's path.

A motion file holds the root's pose and the joints' angles over time (lengths in mm,
angles in rad), no positions of segments: those are found by the kinematics of the
model file (see `mmm_model`), scaled by the subject's height. Read are the first version
(`MotionFrames`) and the second (`Sensors` of the kinds ModelPose and Kinematic).
Without a model file the one segment that can be told is the root.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.demonstrations.importing.mmm_model import (
    MmmModel,
    read_model,
    rotation_rpy,
)
from bath_drake.demonstrations.importing.source import (
    ImportOptions,
    Track,
    listed,
)
from bath_drake.demonstrations.importing.xml_file import numbers, read_xml, text_of
from bath_drake.errors import DemonstrationError
from bath_drake.notation import FloatArray

ROOT = "root"
_MM = 1e-3
# Where the joints of either version are.
_JOINTS = ("JointOrder/Joint", "Sensors/Sensor/Configuration/Joint")
# No subject is taller, m: centimetres are no metres.
MAX_HEIGHT = 3.0
_MAX_FRAMES = 1_000_000
_SAME_TIME = 1e-6


@dataclass(frozen=True, eq=False)
class MmmMotion:
    """A motion as its file has it.

    Attributes:
        t: (n,) s.
        p_WR: (n, 3) of the root, m.
        rpy_WR: (n, 3) its roll, pitch and yaw, rad.
        joints: Names, in the order of `angles`.
        angles: (n, m) rad; of sliding joints mm.
        height: The subject's, m; None if the file does not tell.
    """

    t: FloatArray
    p_WR: FloatArray
    rpy_WR: FloatArray
    joints: tuple[str, ...]
    angles: FloatArray
    height: float | None


def read_mmm(path: Path, options: ImportOptions) -> Track:
    """Reads one segment of an MMM file, or its root.

    Raises:
        DemonstrationError: Naming the file and what is wrong or missing in it.
    """
    motion = read_motion(path, options.motion, options.metres("mm"))
    if not options.model:
        if options.segment not in ("", ROOT):
            raise DemonstrationError(
                f"{path}: --segment: {options.segment!r} takes the kinematics of the "
                f"model file (--model); without it the one segment is {ROOT}"
            )
        if not options.segment:
            raise DemonstrationError(
                f"{path}: say which segment is the hand's with --segment, and the "
                f"model file with --model; without one there is --segment {ROOT}"
            )
        return Track(motion.t, motion.p_WR, f"segment {ROOT}", frame="world")
    model = read_model(Path(options.model))
    if not options.segment:
        raise DemonstrationError(
            f"{path}: say which segment is the hand's with --segment; {options.model} "
            f"has: {listed(model.names)}"
        )
    points = segment_path(path, motion, model, options.segment)
    return Track(motion.t, points, f"segment {options.segment}", frame="world")


def read_motion(path: Path, name: str = "", unit: float = _MM) -> MmmMotion:
    """Reads one motion of a file of either version.

    Args:
        path: The file.
        name: Of the motion; empty: the only one, or the only one with joints (files of
            manipulation hold motions of objects, too).
        unit: Of lengths, m.

    Raises:
        DemonstrationError: Naming the file and what is wrong or missing in it.
    """
    tree = read_xml(path)
    motion = _chosen(
        path, [tree] if tree.tag == "Motion" else tree.findall("Motion"), name
    )
    height = motion.find("ModelProcessorConfig/Height")
    tall = None if height is None else float(numbers(path, height, 1)[0])
    if tall is not None and not 0.0 < tall < MAX_HEIGHT:
        raise DemonstrationError(
            f"{path}: Height: found {tall:g}, allowed: 0 to {MAX_HEIGHT:g} m"
        )
    if motion.find("MotionFrames") is not None:
        return _first_version(path, motion, tall, unit)
    if motion.find("Sensors") is not None:
        return _second_version(path, motion, tall, unit)
    raise DemonstrationError(
        f"{path}: found neither MotionFrames nor Sensors in the motion: no MMM file"
    )


def _chosen(path: Path, motions: list[Any], name: str) -> Any:
    if not motions:
        raise DemonstrationError(f"{path}: found no Motion: no MMM file")
    found = [m for m in motions if m.get("name", "") == name] if name else motions
    if not name and len(found) > 1:
        found = [m for m in motions if any(m.find(way) is not None for way in _JOINTS)]
    if len(found) != 1:
        how = f"{len(found)} motions {name!r}" if name else f"{len(motions)} motions"
        raise DemonstrationError(
            f"{path}: found {how}; say which with --motion; there are: "
            f"{listed(tuple(m.get('name', '') for m in motions))}"
        )
    return found[0]


def segment_path(
    path: Path, motion: MmmMotion, model: MmmModel, segment: str
) -> FloatArray:
    """Positions (n, 3) of a segment in the world, m.

    Raises:
        DemonstrationError: The model has no such segment, or the motion lacks a joint
            on the way to it.
    """
    if segment not in model.names:
        raise DemonstrationError(
            f"{path}: --segment: found {segment!r}; allowed: {listed(model.names)}"
        )
    angles = {name: motion.angles[:, k] for k, name in enumerate(motion.joints)}
    if len(angles) < len(motion.joints):
        raise DemonstrationError(f"{path}: names a joint twice")
    missing = [joint for joint in model.joints_to(segment) if joint not in angles]
    if missing:
        raise DemonstrationError(
            f"{path}: has no angles of joint {missing[0]!r}, which the model has on "
            f"the way to {segment!r}"
        )
    if motion.height is None and model.is_normalised:
        raise DemonstrationError(
            f"{path}: tells no Height of the subject, which the normalised model needs"
        )
    scale = 1.0 if motion.height is None else motion.height
    p_RS = model.position(segment, angles, len(motion.t), scale)
    R_WR = rotation_rpy(motion.rpy_WR)
    return np.asarray(motion.p_WR + np.einsum("nij,nj->ni", R_WR, p_RS))


def _first_version(
    path: Path, motion: Any, height: float | None, unit: float
) -> MmmMotion:
    joints = tuple(j.get("name", "") for j in motion.findall("JointOrder/Joint"))
    frames = motion.findall("MotionFrames/MotionFrame")
    _check_count(path, len(frames))
    rows = [
        (
            numbers(path, _part(path, frame, "Timestep", k), 1),
            numbers(path, _part(path, frame, "RootPosition", k), 3),
            numbers(path, _part(path, frame, "RootRotation", k), 3),
            _angles(path, frame, len(joints)),
        )
        for k, frame in enumerate(frames)
    ]
    t, p, rpy, angles = (np.array(column) for column in zip(*rows, strict=True))
    return MmmMotion(t[:, 0], unit * p, rpy, joints, angles, height)


def _second_version(
    path: Path, motion: Any, height: float | None, unit: float
) -> MmmMotion:
    sensors = {s.get("type", ""): s for s in motion.findall("Sensors/Sensor")}
    if "ModelPose" not in sensors:
        raise DemonstrationError(f"{path}: has no sensor of type ModelPose")
    t, p = _measured(path, sensors["ModelPose"], "RootPosition", 3)
    _, rpy = _measured(path, sensors["ModelPose"], "RootRotation", 3)
    joints: tuple[str, ...] = ()
    angles = np.zeros((len(t), 0))
    kinematic = sensors.get("Kinematic")
    if kinematic is not None:
        joints = tuple(
            j.get("name", "") for j in kinematic.findall("Configuration/Joint")
        )
        times, measured = _measured(path, kinematic, "JointPosition", len(joints))
        angles = _at(path, t, times, measured)
    return MmmMotion(t, unit * p, rpy, joints, angles, height)


def _at(
    path: Path, t: FloatArray, times: FloatArray, measured: FloatArray
) -> FloatArray:
    """Angles at the times of the poses; NaN where none were measured."""
    if len(times) == len(t) and np.all(np.abs(times - t) <= _SAME_TIME):
        return measured
    if not np.all(np.diff(times) > 0.0):
        raise DemonstrationError(
            f"{path}: sensor Kinematic: timesteps must be finite and increase"
        )
    columns = [np.interp(t, times, c, left=np.nan, right=np.nan) for c in measured.T]
    return np.stack(columns, axis=-1) if columns else measured[:0]


def _measured(
    path: Path, sensor: Any, tag: str, width: int
) -> tuple[FloatArray, FloatArray]:
    found = sensor.findall("Data/Measurement")
    _check_count(path, len(found))
    times, rows = [], []
    for k, measurement in enumerate(found):
        try:
            times.append(float(measurement.get("timestep", "")))
        except ValueError:
            raise DemonstrationError(
                f"{path}: measurement {k + 1}: found timestep "
                f"{measurement.get('timestep')!r}, expected a number"
            ) from None
        rows.append(numbers(path, _part(path, measurement, tag, k), width))
    return np.array(times), np.array(rows)


def _angles(path: Path, frame: Any, count: int) -> FloatArray:
    part = frame.find("JointPosition")
    if part is None and count == 0:
        return np.zeros(0)
    return numbers(path, text_of(path, frame, "JointPosition"), count)


def _part(path: Path, parent: Any, tag: str, k: int) -> Any:
    part = parent.find(tag)
    if part is None:
        raise DemonstrationError(f"{path}: frame {k + 1}: has no {tag}")
    return part


def _check_count(path: Path, count: int) -> None:
    if not 1 <= count <= _MAX_FRAMES:
        raise DemonstrationError(
            f"{path}: found {count} frames, allowed: 1 to {_MAX_FRAMES}"
        )
