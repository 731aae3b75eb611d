"""What stands between the rendering camera and those who use its images."""

from pathlib import Path

import numpy as np
from pydrake.systems.framework import DiagramBuilder, OutputPort

from bath_drake.demonstrations.rgbd.writer import RgbdWriter
from bath_drake.scene.config import CameraConfig
from bath_drake.systems.frame_recorder import FrameRecorder, WriteFrame
from bath_drake.systems.kinect_noise import KinectNoise


def begin_recording(folder: Path, config: CameraConfig) -> RgbdWriter:
    """Begins a recording of a scene's camera; DemonstrationError if it cannot be."""
    X_WC = np.eye(4)
    X_WC[:3, :3], X_WC[:3, 3] = config.rotation(), config.eye
    return RgbdWriter(folder, config.pinhole(), X_WC)


def add_depth_noise(
    builder: DiagramBuilder,
    depth: OutputPort,
    config: CameraConfig,
    *,
    seed: int,
    period: float,
) -> OutputPort:
    """Returns the depth image that a real camera of this kind would give.

    Args:
        builder: Holds the camera.
        depth: The perfect depth image.
        config: Of the camera; with noise `none` the perfect image it stays.
        seed: Of the noise.
        period: Of the camera, s.
    """
    if config.noise == "none":
        return depth
    noise = KinectNoise(camera=config.pinhole(), seed=seed, period=period)
    builder.AddNamedSystem("kinect_noise", noise)
    builder.Connect(depth, noise.GetInputPort("depth_image"))
    return noise.GetOutputPort("noisy_depth_image")


def add_frame_recorder(
    builder: DiagramBuilder,
    *,
    colour: OutputPort,
    depth: OutputPort,
    config: CameraConfig,
    period: float,
    write: WriteFrame,
) -> FrameRecorder:
    """Adds the system `frame_recorder`: every frame, as the loop sees it, to `write`.

    Args:
        builder: Holds the camera.
        colour: The colour image.
        depth: The depth image.
        config: Of the camera.
        period: Of the camera, s.
        write: Takes the frames.
    """
    recorder = FrameRecorder(
        width=config.width, height=config.height, period=period, write=write
    )
    builder.AddNamedSystem("frame_recorder", recorder)
    builder.Connect(colour, recorder.GetInputPort("colour_image"))
    builder.Connect(depth, recorder.GetInputPort("depth_image"))
    return recorder
