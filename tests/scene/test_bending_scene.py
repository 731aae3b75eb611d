"""A bending person: the camera sees the skin as it truly is at that instant."""

import shutil
from types import SimpleNamespace

import numpy as np
import open3d as o3d
import pytest
from pydrake.geometry import GeometryConfigurationVector
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from bath_drake.errors import ScenarioError
from bath_drake.patient.motion import MotionConfig, trunk_bend
from bath_drake.patient.people import load_person
from bath_drake.scene.arm import home_position
from bath_drake.scene.assembly import add_scene
from bath_drake.scene.config import SceneConfig, WoundConfig, check_scene
from bath_drake.scene.studio import PERSON_LABELS, WOUND_LABEL
from bath_drake.systems.skin_view import ROOT, DrawnPart, SkinView

BENDING = MotionConfig(
    flexion_amplitude=0.14,
    side_bend_amplitude=0.087,
    spine_twist_amplitude=0.21,
    chest_amplitude=0.006,
)
PERIOD = 0.1


@pytest.fixture(scope="module")
def scene_and_simulator():
    builder = DiagramBuilder()
    config = SceneConfig(motion=BENDING, wound=WoundConfig(centre=[0.3, 0.2]))
    scene = add_scene(builder, config, frame_period=PERIOD)
    command = np.concatenate([home_position(config.arm), np.zeros(7)])
    builder.ExportInput(
        scene.plant.get_desired_state_input_port(scene.arm), "joint_command"
    )
    diagram = builder.Build()
    simulator = Simulator(diagram)
    diagram.GetInputPort("joint_command").FixValue(
        simulator.get_mutable_context(), command
    )
    simulator.Initialize()
    simulator.AdvanceTo(7 * PERIOD)
    # 3.4 s on, when the person is bent in every way; an arm at rest is of no account.
    simulator.get_mutable_context().SetTime(41 * PERIOD - 0.5 * PERIOD)
    simulator.Initialize()
    simulator.AdvanceTo(41 * PERIOD)
    return scene, simulator


def ray_cast(scene, t):
    """Depth (H, W) of the bent skin's parts, by another way than the renderer's."""
    X_WM, bend = scene.true_person_pose(t), trunk_bend(t, scene.config.motion)
    cast = o3d.t.geometry.RaycastingScene()
    for part in scene.skin:
        points = part.shell.points(bend)[: len(part.shell) // 2]
        points = X_WM.multiply(points.T).T
        cast.add_triangles(
            o3d.core.Tensor(points.astype(np.float32)),
            o3d.core.Tensor(part.triangles.astype(np.uint32)),
        )
    camera = scene.config.camera.pinhole()
    R_WC = scene.X_WC.rotation().matrix()
    directions = camera.rays.reshape(-1, 3) @ R_WC.T
    origins = np.broadcast_to(scene.X_WC.translation(), directions.shape)
    rays = np.concatenate([origins, directions], axis=1).astype(np.float32)
    # Rays are as long as their depth along the optical axis.
    return cast.cast_rays(o3d.core.Tensor(rays))["t_hit"].numpy().reshape(camera.shape)


@pytest.mark.render
def test_the_camera_sees_the_skin_of_its_very_instant(scene_and_simulator):
    scene, simulator = scene_and_simulator
    camera = scene.camera.GetMyContextFromRoot(simulator.get_context())
    depth = scene.camera.depth_image_32F_output_port().Eval(camera).data[..., 0]
    label = scene.camera.label_image_output_port().Eval(camera).data[..., 0]
    back = label == PERSON_LABELS["back"]
    assert back.sum() > 4000
    now = simulator.get_context().get_time()
    error = np.abs(depth[back] - ray_cast(scene, now)[back])
    # Single precision; at a silhouette or a seam a pixel may show the one behind.
    assert np.median(error) < 5e-5
    assert np.quantile(error, 0.99) < 1e-3
    earlier = ray_cast(scene, now - PERIOD)[back]
    assert np.median(np.abs(depth[back] - earlier)) > 2e-4


@pytest.mark.render
def test_the_label_image_names_the_parts_of_a_bending_person(scene_and_simulator):
    scene, simulator = scene_and_simulator
    camera = scene.camera.GetMyContextFromRoot(simulator.get_context())
    label = scene.camera.label_image_output_port().Eval(camera).data
    seen = set(np.unique(label).tolist())
    assert {*PERSON_LABELS.values(), WOUND_LABEL} <= seen


def test_the_skin_is_where_the_pure_functions_put_it(scene_and_simulator):
    scene, simulator = scene_and_simulator
    motion = scene.patient_motion
    context = motion.GetMyContextFromRoot(simulator.get_context())
    skin = motion.GetOutputPort("skin_configuration").Eval(context)
    t = simulator.get_context().get_time()
    bend, X_WM = trunk_bend(t, scene.config.motion), scene.true_person_pose(t)
    for part, geometry in zip(scene.skin, scene.skin_geometries, strict=True):
        expected = X_WM.multiply(part.shell.points(bend).T).T
        # The time of the frame is a sum of periods, good to its rounding.
        np.testing.assert_allclose(
            skin.value(geometry).reshape(-1, 3), expected, atol=1e-9
        )


def test_a_person_without_a_rig_is_not_bent(tmp_path):
    folder = tmp_path / "somebody"
    shutil.copytree(load_person("f_avg").folder, folder)
    (folder / "rig.npz").unlink()
    with pytest.raises(ScenarioError, match="without a rig a person cannot bend"):
        add_scene(DiagramBuilder(), SceneConfig(person=str(folder), motion=BENDING))


@pytest.mark.parametrize("name", ["flexion_amplitude", "chest_amplitude"])
@pytest.mark.parametrize("value", [-0.1, 2.0, float("nan")])
def test_a_bend_no_spine_could_follow_is_refused(name, value):
    with pytest.raises(ValueError, match=name):
        check_scene(SceneConfig(motion=MotionConfig(**{name: value})))


def test_meshcat_shows_the_parts_it_is_given(scene_and_simulator):
    scene, simulator = scene_and_simulator
    shown = {}
    meshcat = SimpleNamespace(SetTriangleMesh=lambda *a: shown.update({a[0]: a[1:]}))
    drawn = zip(scene.skin, scene.skin_geometries, strict=True)
    view = SkinView(
        meshcat=meshcat,
        parts=[DrawnPart(p.name, g, p.triangles, p.rgba) for p, g in drawn],
        period=0.1,
    )
    context = view.CreateDefaultContext()
    motion = scene.patient_motion
    skin = motion.GetOutputPort("skin_configuration").Eval(
        motion.GetMyContextFromRoot(simulator.get_context())
    )
    assert isinstance(skin, GeometryConfigurationVector)
    view.GetInputPort("skin_configuration").FixValue(context, skin)
    Simulator(view, context).Initialize()
    assert set(shown) == {f"{ROOT}/{part.name}" for part in scene.skin}
    for part, geometry in zip(scene.skin, scene.skin_geometries, strict=True):
        points, faces, _ = shown[f"{ROOT}/{part.name}"]
        np.testing.assert_array_equal(faces.T, part.triangles)
        outside = skin.value(geometry).reshape(-1, 3)[: len(part.shell) // 2]
        np.testing.assert_array_equal(points.T, outside)
