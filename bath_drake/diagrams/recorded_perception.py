"""Perception fed by a recording: no simulator, no robot, a real camera's files."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder

from bath_drake.demonstrations.rgbd.folder import RgbdFolder
from bath_drake.demonstrations.rgbd.writer import INTRINSICS
from bath_drake.diagrams.perception import add_perception, export_perception
from bath_drake.diagrams.wiring import connect
from bath_drake.errors import DemonstrationError
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.scenario import Scenario
from bath_drake.systems._poses import at, rotation_from
from bath_drake.systems.canonical_projector import FRAME_DELAY_S
from bath_drake.systems.rgbd_recording import RgbdRecording

# After the areas of the same frame.
_LAG_S = 3.0 * FRAME_DELAY_S
# Frames that follow each other faster than this are not all seen.
_SHORTEST_LOOK_S = 2.0 * _LAG_S

# (frames looked at, frames in all)
FrameProgress = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class PerceivedFrame:
    """What is known of the body after a frame.

    Attributes:
        t: When it was taken, s from the first frame.
        observation: Of this frame.
        canonical_map: As smoothed until now; says nothing before a back was found.
        areas: The restricted areas seen so far.
        rejected: How many frames' maps were no body's, so far.
    """

    t: float
    observation: BodyObservation
    canonical_map: CanonicalMap
    areas: ObstacleSet
    rejected: int


def look_period(recording: RgbdFolder) -> float:
    """Returns how often to look for a new frame, s: twice for each, usually."""
    steps = np.diff([files.t for files in recording.files])
    usual = float(np.median(steps)) if len(steps) > 0 else 1.0
    return max(0.5 * usual, _SHORTEST_LOOK_S)


def build_recorded_perception(recording: RgbdFolder, scenario: Scenario) -> Diagram:
    """The perception of `build_perception`, fed by a recorded folder.

    Args:
        recording: Its camera and pose are the camera's.
        scenario: Its workspace box and margin; its scene is not built.

    Raises:
        DemonstrationError: If the folder does not say where the camera stood.
    """
    if recording.X_WC is None:
        raise DemonstrationError(
            f"{recording.path / INTRINSICS}: X_WC: is missing, expected 4 rows of 4, "
            "the camera's pose in a world whose z points up"
        )
    R_WC, p_WC = recording.X_WC[:3, :3], recording.X_WC[:3, 3]
    builder = DiagramBuilder()
    player = builder.AddNamedSystem(
        "rgbd_recording", RgbdRecording(recording=recording)
    )
    systems = add_perception(
        builder,
        scenario,
        camera=recording.camera,
        X_WC=at(p_WC, rotation_from(R_WC)),
        robot=None,
        period=look_period(recording),
    )
    for port in ("colour_image", "depth_image", "frame_stamp"):
        connect(builder, player, port, [systems["body_segmenter"]])
    export_perception(builder, systems)
    diagram = builder.Build()
    diagram.set_name("recorded_perception")
    return diagram


def perceive(
    recording: RgbdFolder,
    scenario: Scenario,
    progress: FrameProgress | None = None,
) -> list[PerceivedFrame]:
    """Returns what is seen in each frame of a recording.

    Args:
        recording: The folder.
        scenario: Its workspace box and margin.
        progress: Called with frames looked at and frames in all as it goes on.

    Raises:
        DemonstrationError: If an image is damaged or there is no pose.
    """
    diagram = build_recorded_perception(recording, scenario)
    simulator = Simulator(diagram)
    context = simulator.get_context()
    ports = [
        diagram.GetOutputPort(name)
        for name in (
            "body_observation",
            "canonical_map",
            "sensed_obstacles",
            "rejected_frames",
        )
    ]
    period = look_period(recording)
    last = recording.files[-1].t - recording.files[0].t
    frames: list[PerceivedFrame] = []
    for look in range(int(np.ceil(last / period - 1e-6)) + 1):
        simulator.AdvanceTo(look * period + _LAG_S)
        values: list[Any] = [port.Eval(context) for port in ports]
        observation, canonical_map, areas, rejected = values
        assert isinstance(observation, BodyObservation)
        assert isinstance(canonical_map, CanonicalMap)
        assert isinstance(areas, ObstacleSet)
        if frames and observation.stamp <= frames[-1].t:
            continue
        frames.append(
            PerceivedFrame(
                observation.stamp, observation, canonical_map, areas, int(rejected[0])
            )
        )
        if progress is not None:
            progress(len(frames), len(recording))
    return frames
