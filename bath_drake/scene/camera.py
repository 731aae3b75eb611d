"""The camera of a scene: our own rasteriser's, or Drake's RgbdSensor."""

from collections.abc import Mapping

import numpy as np
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    GeometryId,
    LightParameter,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
    SceneGraph,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo, RgbdSensor

from bath_drake.patient.skin_parts import SkinPart
from bath_drake.rendering.rasteriser import Light, Rasteriser
from bath_drake.scene.config import CameraConfig
from bath_drake.scene.drawn import drawing
from bath_drake.systems._poses import at
from bath_drake.systems.rasterised_camera import RasterisedCamera

Camera = RasterisedCamera | RgbdSensor

# What the camera can see at all, m; its depth range is CameraConfig's.
_CLIPPING = (0.1, 6.0)
_BACKGROUND = (0.90, 0.95, 0.97)
_LIGHTS = (
    Light((0.0, 0.0, 1.0), 1.4, of_camera=True),
    Light((0.35, 0.45, -0.82), 1.2),
    Light((0.45, -0.75, -0.5), 0.7),
)


def camera_pose(config: CameraConfig) -> RigidTransform:
    """Returns X_WC."""
    return at(config.eye, RotationMatrix(config.rotation()))


def add_camera(
    builder: DiagramBuilder,
    scene_graph: SceneGraph,
    config: CameraConfig,
    skin: Mapping[GeometryId, SkinPart] | None = None,
) -> Camera:
    """Adds the system `camera`, as the last: it sees what is in the scene by now.

    Args:
        builder: Gets it.
        scene_graph: In the builder, complete.
        config: Of the camera; its `renderer` chooses who draws.
        skin: The parts of a person that bends, by their geometries.

    Raises:
        ScenarioError: If there is something in the scene that the rasteriser does not
            draw; names it.
    """
    camera: Camera
    if config.renderer == "vtk":
        camera = _rendered(scene_graph, config)
    else:
        camera = _rasterised(scene_graph, config, skin or {})
    builder.AddNamedSystem("camera", camera)
    builder.Connect(
        scene_graph.get_query_output_port(), camera.query_object_input_port()
    )
    return camera


def _rasterised(
    scene_graph: SceneGraph,
    config: CameraConfig,
    skin: Mapping[GeometryId, SkinPart],
) -> RasterisedCamera:
    seen = drawing(scene_graph.model_inspector(), skin)
    rasteriser = Rasteriser(
        camera=config.pinhole(),
        X_WC=np.array(camera_pose(config).GetAsMatrix4()),
        clipping=_CLIPPING,
        depth_range=(config.near, config.far),
        lights=_LIGHTS,
        background=np.array(_BACKGROUND),
        still=seen.still,
        moving=seen.moving,
    )
    return RasterisedCamera(
        rasteriser=rasteriser,
        camera=config.pinhole(),
        geometries=seen.geometries,
        bending={g: len(part.shell) // 2 for g, part in skin.items()},
    )


def _rendered(scene_graph: SceneGraph, config: CameraConfig) -> RgbdSensor:
    scene_graph.AddRenderer("vtk", MakeRenderEngineVtk(_vtk()))
    core = RenderCameraCore(
        "vtk",
        CameraInfo(
            config.width, config.height, config.fx, config.fy, config.cx, config.cy
        ),
        ClippingRange(*_CLIPPING),
        RigidTransform(),
    )
    return RgbdSensor(
        scene_graph.world_frame_id(),
        camera_pose(config),
        ColorRenderCamera(core, False),
        DepthRenderCamera(core, DepthRange(config.near, config.far)),
    )


def _vtk() -> RenderEngineVtkParams:
    return RenderEngineVtkParams(
        # As with glTF parts, so that a bending person is lit as a rigid one is.
        force_to_pbr=True,
        default_clear_color=np.array(_BACKGROUND),
        lights=[
            LightParameter(
                type="directional",
                direction=np.array(light.direction),
                intensity=light.intensity,
                frame="camera" if light.of_camera else "world",
            )
            for light in _LIGHTS
        ],
    )
