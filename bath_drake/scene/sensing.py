"""What stands between the rendering camera and those who use its images."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pydrake.systems.framework import DiagramBuilder, OutputPort

from bath_drake.demonstrations.rgbd.writer import RgbdWriter
from bath_drake.perception.depth_sensor import CAMERA_MODELS
from bath_drake.scene.camera import Camera
from bath_drake.scene.config import CameraConfig
from bath_drake.systems.camera_faults import CameraFaults
from bath_drake.systems.colour_noise import ColourNoise
from bath_drake.systems.depth_noise import DepthNoise
from bath_drake.systems.frame_recorder import FrameRecorder, WriteFrame


@dataclass(frozen=True)
class CameraPorts:
    """Where a camera's images come from.

    Attributes:
        colour: The colour image.
        depth: The depth image.
        arm_position: The arm's joint positions when they were taken, or None where
            that is now.
        stamp: When they were taken, or None where that is now.
    """

    colour: OutputPort
    depth: OutputPort
    arm_position: OutputPort | None = None
    stamp: OutputPort | None = None


def camera_ports(camera: Camera | None) -> CameraPorts:
    """Returns the images of a scene's camera; RuntimeError if it has none."""
    if camera is None:
        raise RuntimeError("the scene has no camera")
    return CameraPorts(
        camera.color_image_output_port(), camera.depth_image_32F_output_port()
    )


def begin_recording(folder: Path, config: CameraConfig) -> RgbdWriter:
    """Begins a recording of a scene's camera; DemonstrationError if it cannot be."""
    X_WC = np.eye(4)
    X_WC[:3, :3], X_WC[:3, 3] = config.rotation(), config.eye
    return RgbdWriter(folder, config.pinhole(), X_WC)


def add_camera_noise(
    builder: DiagramBuilder,
    perfect: CameraPorts,
    config: CameraConfig,
    *,
    seed: int,
    period: float,
) -> CameraPorts:
    """Returns the images that a real camera of this kind would give.

    Args:
        builder: Holds the camera.
        perfect: The rendered images.
        config: Of the camera; what has no noise stays perfect.
        seed: Of the noise.
        period: Of the camera, s.
    """
    ports, camera = perfect, config.pinhole()
    if config.noise != "none":
        depth_noise = DepthNoise(
            camera=camera,
            sensor=CAMERA_MODELS[config.noise].sensor,
            seed=seed,
            period=period,
        )
        builder.AddNamedSystem("depth_noise", depth_noise)
        builder.Connect(ports.depth, depth_noise.GetInputPort("depth_image"))
        ports = replace(ports, depth=depth_noise.GetOutputPort("noisy_depth_image"))
    if config.colour_noise is not None:
        colour_noise = ColourNoise(
            camera=camera, config=config.colour_noise, seed=seed, period=period
        )
        builder.AddNamedSystem("colour_noise", colour_noise)
        builder.Connect(ports.colour, colour_noise.GetInputPort("colour_image"))
        ports = replace(ports, colour=colour_noise.GetOutputPort("noisy_colour_image"))
    return ports


def add_camera_faults(
    builder: DiagramBuilder,
    ports: CameraPorts,
    arm_position: OutputPort,
    config: CameraConfig,
    *,
    seed: int,
    period: float,
) -> CameraPorts:
    """Returns what comes of the camera's frames; without faults, the ports given.

    Args:
        builder: Holds the camera.
        ports: Its images.
        arm_position: The arm's joint positions now.
        config: Of the camera.
        seed: Of what happens by chance.
        period: Of the camera, s.
    """
    if not config.faults.any:
        return ports
    faults = CameraFaults(
        camera=config.pinhole(), config=config.faults, seed=seed, period=period
    )
    builder.AddNamedSystem("camera_faults", faults)
    builder.Connect(ports.colour, faults.GetInputPort("colour_image"))
    builder.Connect(ports.depth, faults.GetInputPort("depth_image"))
    builder.Connect(arm_position, faults.GetInputPort("arm_position"))
    return CameraPorts(
        colour=faults.GetOutputPort("colour_image"),
        depth=faults.GetOutputPort("depth_image"),
        arm_position=faults.GetOutputPort("arm_position"),
        stamp=faults.GetOutputPort("frame_stamp"),
    )


def add_frame_recorder(
    builder: DiagramBuilder,
    *,
    ports: CameraPorts,
    config: CameraConfig,
    period: float,
    write: WriteFrame,
) -> FrameRecorder:
    """Adds the system `frame_recorder`: every frame the camera takes, to `write`.

    Args:
        builder: Holds the camera.
        ports: Its images, before any faults: a lost frame is recorded too.
        config: Of the camera.
        period: Of the camera, s.
        write: Takes the frames.
    """
    recorder = FrameRecorder(
        width=config.width, height=config.height, period=period, write=write
    )
    builder.AddNamedSystem("frame_recorder", recorder)
    builder.Connect(ports.colour, recorder.GetInputPort("colour_image"))
    builder.Connect(ports.depth, recorder.GetInputPort("depth_image"))
    return recorder
