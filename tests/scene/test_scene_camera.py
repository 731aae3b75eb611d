"""Our rasteriser and Drake's own renderer see the same scene."""

import functools

import numpy as np
import pytest
from pydrake.common import MemoryFile
from pydrake.geometry import (
    Convex,
    GeometryInstance,
    HalfSpace,
    InMemoryMesh,
    Mesh,
    PerceptionProperties,
    Rgba,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from bath_drake.errors import ScenarioError
from bath_drake.patient.motion import MotionConfig
from bath_drake.scene.assembly import add_scene
from bath_drake.scene.config import (
    ArmConfig,
    CameraConfig,
    SceneConfig,
    VisitorConfig,
    WoundConfig,
    check_scene,
)
from bath_drake.scene.drawn import drawing
from bath_drake.scene.studio import PERSON_LABELS

BENDING = MotionConfig(
    flexion_amplitude=0.14,
    side_bend_amplitude=0.087,
    spine_twist_amplitude=0.21,
    chest_amplitude=0.006,
)
SCENES = {
    "rigid": {"wound": WoundConfig(centre=[0.3, 0.2])},
    "bending": {"person": "f_avg", "motion": BENDING, "wound": WoundConfig()},
    "clutter": {"person": "f_heavy", "background": "clutter"},
    "two people and a visitor": {
        "background": "second_person",
        "visitor": VisitorConfig(position=[1.0, 0.6, 0.0]),
    },
}


@functools.cache
def filmed(name, renderer):
    """Colour, depth and labels after 1.2 s, the arm before the back."""
    config = SceneConfig(
        arm=ArmConfig(fidelity="kinematic"),
        camera=CameraConfig(renderer=renderer),
        **SCENES[name],
    )
    builder = DiagramBuilder()
    scene = add_scene(builder, config)
    command = np.concatenate([config.arm.posture, np.zeros(7)])
    source = builder.AddSystem(ConstantVectorSource(command))
    builder.Connect(source.get_output_port(), scene.arm_command)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(1.2)
    view = scene.camera.GetMyContextFromRoot(simulator.get_context())
    colour = scene.camera.color_image_output_port().Eval(view).data[..., :3]
    depth = scene.camera.depth_image_32F_output_port().Eval(view).data[..., 0]
    label = scene.camera.label_image_output_port().Eval(view).data[..., 0]
    return colour.astype(int), depth.copy(), label.copy()


@pytest.mark.render
@pytest.mark.parametrize("name", SCENES)
def test_labels_and_depth_are_those_of_drakes_renderer(name):
    _, depth, label = filmed(name, "rasteriser")
    _, expected, theirs = filmed(name, "vtk")
    same = label == theirs
    # Pixels whose ray grazes an outline go either way: 1 in 20,000 of them.
    assert same.mean() > 0.9998
    assert (np.isfinite(depth) == np.isfinite(expected)).mean() > 0.9999
    seen = same & np.isfinite(depth) & np.isfinite(expected)
    error = np.abs(depth[seen] - expected[seen])
    # Single precision, but where one mesh covers another within a pixel, and on round
    # solids, of which each has its own number of facets.
    assert np.median(error) < 1e-6
    assert np.quantile(error, 0.99) < 2e-4


@pytest.mark.render
@pytest.mark.parametrize("name", SCENES)
def test_colours_are_those_of_drakes_renderer(name):
    colour, _, label = filmed(name, "rasteriser")
    expected, _, theirs = filmed(name, "vtk")
    back = (label == theirs) & (label == PERSON_LABELS["back"])
    error = np.abs(colour - expected).max(axis=-1)
    # Of 255: light is worked out at vertices here, at every pixel there; and theirs
    # blends the pixels of an outline.
    assert error[back].mean() < 1.5
    assert np.quantile(error[back], 0.9) <= 3
    assert error.mean() < 1.5


def scene_with(shape, rgba=None):
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource("thing")
    instance = GeometryInstance(RigidTransform(), shape, "the_thing")
    properties = PerceptionProperties()
    if rgba is not None:
        properties.AddProperty("phong", "diffuse", rgba)
    instance.set_perception_properties(properties)
    scene_graph.RegisterAnchoredGeometry(source, instance)
    return scene_graph


def mesh(text, extension):
    return Mesh(InMemoryMesh(mesh_file=MemoryFile(text, extension, "thing")), 1.0)


OBJ = "v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n"


@pytest.mark.parametrize(
    ("shape", "rgba", "told"),
    [
        (
            mesh("mtllib a.mtl\n" + OBJ, ".obj"),
            None,
            "the_thing: found materials in a file.*renderer: vtk",
        ),
        (mesh(OBJ.replace("3\n", "9\n"), ".obj"), Rgba(1, 0, 0), "the_thing: line 4"),
        (mesh("{}", ".gltf"), None, "the_thing: found a glTF in memory"),
        (HalfSpace(), Rgba(1, 0, 0), "the_thing: found a HalfSpace"),
    ],
)
def test_what_only_drakes_renderer_draws_is_named(shape, rgba, told):
    scene_graph = scene_with(shape, rgba)
    with pytest.raises(ScenarioError, match=told):
        drawing(scene_graph.model_inspector())


def test_another_gltf_than_a_persons_part_is_named_with_who_draws_it(tmp_path):
    (tmp_path / "link.gltf").write_text('{"meshes": []}')
    scene_graph = scene_with(Mesh(tmp_path / "link.gltf"))
    with pytest.raises(ScenarioError, match=r"the_thing: .*link\.gltf.*renderer: vtk"):
        drawing(scene_graph.model_inspector())


def test_a_convex_hull_is_drawn_in_drakes_colour_for_what_has_none():
    corners = np.array(np.meshgrid(*[[-0.1, 0.2]] * 3)).reshape(3, -1)
    scene_graph = scene_with(Convex(points=corners, label="hull"))
    (surface,) = drawing(scene_graph.model_inspector()).still
    a, b, c = (surface.shape.vertices[surface.shape.triangles[:, k]] for k in range(3))
    # A closed cube of 0.3 m, outside out.
    assert (np.cross(a, b) * c).sum() / 6.0 == pytest.approx(0.027, rel=1e-9)
    np.testing.assert_allclose(surface.rgb, [0.9, 0.7, 0.2])


def test_a_renderer_that_there_is_not_is_refused():
    config = SceneConfig(camera=CameraConfig(renderer="gl"))
    with pytest.raises(ValueError, match=r"camera\.renderer: found 'gl'"):
        check_scene(config)
