"""Wires what is made of a camera's images: the back, its map, restricted areas."""

from pathlib import Path
from typing import Any

from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder

from bath_drake.diagrams.wiring import add_all, connect
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.config import map_follower, segmentation
from bath_drake.perception.neural_segmenter import NeuralSegmenter
from bath_drake.perception.onnx_segmenter import OnnxSegmenter
from bath_drake.perception.segmenter import ClassicSegmenter, Segmenter
from bath_drake.perception.self_filter import RobotGeometry
from bath_drake.resources import models_folder
from bath_drake.safety.arm_chain import ArmChain
from bath_drake.scenario import Scenario
from bath_drake.systems.body_monitor import BodyMonitor
from bath_drake.systems.body_segmenter import BodySegmenter
from bath_drake.systems.camera_monitor import CameraMonitor
from bath_drake.systems.canonical_projector import CanonicalProjector
from bath_drake.systems.frame_monitor import FrameMonitor
from bath_drake.systems.ideal_areas import IdealAreas
from bath_drake.systems.ideal_projector import IdealProjector
from bath_drake.systems.ideal_segmenter import IdealSegmenter, Sight
from bath_drake.systems.restricted_area_detector import RestrictedAreaDetector


def add_perception(
    builder: DiagramBuilder,
    scenario: Scenario,
    *,
    camera: PinholeCamera,
    X_WC: RigidTransform,
    robot: RobotGeometry | None,
    period: float,
    arm: ArmChain | None = None,
    X_WB: RigidTransform | None = None,
    watched: bool = False,
) -> dict[str, Any]:
    """Adds the systems and joins them; the inputs for images are left open.

    Args:
        builder: Gets them.
        scenario: Its workspace box and margin.
        camera: Whose images come.
        X_WC: Where it stands.
        robot: What may hide the back; None where there is no robot.
        period: Between looks, s.
        arm: The robot's chain of links, for whoever watches the camera by it.
        X_WB: Pose of its base.
        watched: Whether a guard wants to know of frames, bodies and the camera.

    Returns:
        The systems by name.
    """
    systems = add_all(
        builder,
        {
            "body_segmenter": BodySegmenter(
                camera=camera,
                X_WC=X_WC,
                robot=robot,
                config=segmentation(scenario.perception),
                period=period,
                segmenter=make_segmenter(scenario),
            ),
            "canonical_projector": CanonicalProjector(
                period=period, follower=map_follower(scenario.perception)
            ),
            "restricted_area_detector": RestrictedAreaDetector(
                margin=scenario.perception.area_margin,
                period=period,
                given=scenario.perception.restricted_areas,
            ),
        },
    )
    if watched:
        systems |= add_all(
            builder,
            {
                "frame_monitor": FrameMonitor(
                    camera=camera,
                    period=period,
                    watch_frozen=scenario.scene.camera.noise != "none",
                ),
                "body_monitor": BodyMonitor(
                    camera=camera,
                    X_WC=X_WC,
                    low_W=segmentation(scenario.perception).box_low_W,
                    high_W=segmentation(scenario.perception).box_high_W,
                    period=period,
                ),
            },
        )
        monitor = systems["body_monitor"]
        connect(builder, systems["body_segmenter"], "body_observation", [monitor])
        for port in ("canonical_map", "map_status"):
            connect(builder, systems["canonical_projector"], port, [monitor])
    if watched and arm is not None and X_WB is not None:
        sight = builder.AddNamedSystem(
            "camera_monitor",
            CameraMonitor(camera=camera, X_WC=X_WC, arm=arm, X_WB=X_WB, period=period),
        )
        connect(builder, systems["body_segmenter"], "body_observation", [sight])
        systems["camera_monitor"] = sight
    projector = systems["canonical_projector"]
    detector = systems["restricted_area_detector"]
    connect(
        builder, systems["body_segmenter"], "body_observation", [projector, detector]
    )
    connect(builder, projector, "canonical_map", [detector])
    return systems


def add_ideal_perception(
    builder: DiagramBuilder, sight: Sight, *, period: float
) -> dict[str, Any]:
    """Adds what tells the truth in perception's stead, under the same names and ports.

    Args:
        builder: Gets the systems; the first one's inputs are left open.
        sight: Knows the true back.
        period: Between looks, s.

    Returns:
        The systems by name.
    """
    systems = add_all(
        builder,
        {
            "body_segmenter": IdealSegmenter(sight=sight, period=period),
            "canonical_projector": IdealProjector(rim=sight.rim),
            "restricted_area_detector": IdealAreas(areas=sight.areas),
        },
    )
    followers = [
        systems[k] for k in ("canonical_projector", "restricted_area_detector")
    ]
    connect(builder, systems["body_segmenter"], "body_observation", followers)
    return systems


def make_segmenter(scenario: Scenario) -> Segmenter:
    """Returns what tells skin from the rest in a scenario.

    Raises:
        SegmenterError: If its network cannot be used.
    """
    perception, config = scenario.perception, segmentation(scenario.perception)
    if perception.segmenter == "classic":
        return ClassicSegmenter(config)
    if perception.segmenter.endswith(".onnx"):
        path = Path(perception.segmenter)
        return OnnxSegmenter(path, config, mask=perception.onnx_mask)
    return NeuralSegmenter(
        models_folder() / "segmenters" / "selfie_segmentation.tflite",
        config,
        with_colour=perception.segmenter == "neural",
    )


def export_perception(builder: DiagramBuilder, systems: dict[str, Any]) -> None:
    """Exports what perception makes, under the ports' own names."""
    for system, port in (
        ("body_segmenter", "body_observation"),
        ("canonical_projector", "canonical_map"),
        ("canonical_projector", "rejected_frames"),
        ("restricted_area_detector", "sensed_obstacles"),
    ):
        builder.ExportOutput(systems[system].GetOutputPort(port), port)
