"""The rasterised camera's ports tell what the pure function draws."""

import numpy as np
import pytest
from pydrake.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    PerceptionProperties,
    RenderLabel,
    Rgba,
    SceneGraph,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import RgbdSensor

from bath_drake.perception.camera import PinholeCamera
from bath_drake.rendering.rasteriser import Rasteriser
from bath_drake.scene.drawn import drawing
from bath_drake.systems.rasterised_camera import RasterisedCamera

CAMERA = PinholeCamera(80, 60, 60.0, 60.0, 40.0, 30.0)
NEAR, FAR = 0.8, 2.0


@pytest.fixture
def filmed():
    """A ball that moves, filmed; returns what is needed to ask."""
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    source = scene_graph.RegisterSource("ball")
    frame = scene_graph.RegisterFrame(source, GeometryFrame("ball"))
    instance = GeometryInstance(RigidTransform(), Sphere(0.2), "ball")
    seen = PerceptionProperties()
    seen.AddProperty("phong", "diffuse", Rgba(0.8, 0.2, 0.1))
    seen.AddProperty("label", "id", RenderLabel(5))
    instance.set_perception_properties(seen)
    scene_graph.RegisterGeometry(source, frame, instance)
    drawn = drawing(scene_graph.model_inspector())
    rasteriser = Rasteriser(
        camera=CAMERA,
        X_WC=np.eye(4),
        clipping=(0.1, 6.0),
        depth_range=(NEAR, FAR),
        lights=[],
        background=np.array([0.9, 0.9, 0.9]),
        moving=drawn.moving,
    )
    camera = RasterisedCamera(
        rasteriser=rasteriser,
        camera=CAMERA,
        geometries=drawn.geometries,
    )
    builder.AddNamedSystem("camera", camera)
    builder.Connect(
        scene_graph.get_query_output_port(), camera.query_object_input_port()
    )
    builder.ExportInput(scene_graph.get_source_pose_port(source), "pose")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()

    def place(p_WB):
        poses = FramePoseVector()
        poses.set_value(frame, RigidTransform(np.array(p_WB)))
        diagram.GetInputPort("pose").FixValue(context, poses)
        view = camera.GetMyContextFromRoot(context)
        return tuple(
            camera.GetOutputPort(name).Eval(view).data.copy()
            for name in ("color_image", "depth_image_32f", "label_image")
        )

    return place, rasteriser


def test_the_images_are_those_of_the_rasteriser(filmed):
    place, rasteriser = filmed
    for p_WB in ([0.0, 0.0, 1.5], [0.2, -0.1, 1.3], [0.0, 0.0, 1.5]):
        colour, depth, label = place(p_WB)
        X_WG = np.eye(4)[None, :3].copy()
        X_WG[0, :, 3] = p_WB
        picture = rasteriser.picture(X_WG)
        np.testing.assert_array_equal(colour, picture.colour)
        np.testing.assert_array_equal(depth[..., 0], picture.depth)
        np.testing.assert_array_equal(label[..., 0], picture.label)
        assert (label == 5).any()


def test_what_is_too_near_or_too_far_has_no_depth(filmed):
    place, _ = filmed
    _, depth, label = place([0.0, 0.0, 0.9])
    assert (depth[label == 5] == 0.0).any()
    # Its rim is beyond the nearest depth that is told.
    assert (depth[label == 5] > NEAR).any()
    _, depth, label = place([0.0, 0.0, 2.5])
    assert (label == 5).any()
    assert np.isinf(depth).all()


def test_its_ports_are_named_as_those_of_drakes_camera(filmed):
    assert RasterisedCamera.__doc__
    theirs = {
        name
        for name in dir(RgbdSensor)
        if name.endswith("put_port") and not name.startswith(("Get", "get"))
    }
    ours = {
        "query_object_input_port",
        "color_image_output_port",
        "depth_image_32F_output_port",
        "label_image_output_port",
    }
    assert ours <= theirs


def test_a_camera_of_no_scene_names_its_port():
    rasteriser = Rasteriser(
        camera=CAMERA,
        X_WC=np.eye(4),
        clipping=(0.1, 6.0),
        lights=[],
        background=np.zeros(3),
    )
    camera = RasterisedCamera(rasteriser=rasteriser, camera=CAMERA, geometries=())
    with pytest.raises(RuntimeError, match=r"'geometry_query'.* is not connected"):
        camera.color_image_output_port().Eval(camera.CreateDefaultContext())
