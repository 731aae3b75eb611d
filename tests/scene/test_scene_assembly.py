"""The assembled scene: who is seen where, and the arm that stands still."""

import numpy as np
import pytest
from pydrake.geometry import Role
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from bath_drake.patient.skin import TrueSkin
from bath_drake.scene.arm import ArmGeometry, home_position
from bath_drake.scene.assembly import add_scene
from bath_drake.scene.config import ArmConfig, SceneConfig, WoundConfig, check_scene
from bath_drake.scene.studio import PERSON_LABELS, WOUND_LABEL

TIME = 7.3  # s, when the person has moved in every way


@pytest.fixture(scope="module")
def scene_and_diagram():
    builder = DiagramBuilder()
    config = SceneConfig(wound=WoundConfig(centre=[0.3, 0.2]))
    scene = add_scene(builder, config)
    command = np.concatenate([home_position(config.arm), np.zeros(7)])
    builder.ExportInput(
        scene.plant.get_desired_state_input_port(scene.arm), "joint_command"
    )
    diagram = builder.Build()
    return scene, diagram, command


@pytest.fixture
def context(scene_and_diagram):
    _, diagram, command = scene_and_diagram
    context = diagram.CreateDefaultContext()
    diagram.GetInputPort("joint_command").FixValue(context, command)
    return context


def project(scene, p_W):
    camera = scene.config.camera
    p_C = scene.X_WC.inverse().multiply(np.atleast_2d(p_W).T).T
    u = camera.fx * p_C[:, 0] / p_C[:, 2] + camera.cx
    v = camera.fy * p_C[:, 1] / p_C[:, 2] + camera.cy
    return np.stack([u, v], axis=1), p_C[:, 2]


@pytest.mark.render
def test_the_moving_persons_mesh_is_where_it_should_be(scene_and_diagram, context):
    scene, _, _ = scene_and_diagram
    context.SetTime(TIME)
    grid = np.stack(np.meshgrid([-0.5, 0.0, 0.5], [-0.4, 0.0, 0.4]), -1)
    skin_M, _ = TrueSkin(scene.person).under(grid.reshape(-1, 2))
    pixels, expected = project(scene, scene.true_person_pose(TIME).multiply(skin_M.T).T)
    camera = scene.camera.GetMyContextFromRoot(context)
    depth = scene.camera.depth_image_32F_output_port().Eval(camera).data[..., 0]
    column, row = np.floor(pixels).astype(int).T
    # A pixel is 3.6 mm wide here, on skin that slopes by up to its own width.
    np.testing.assert_allclose(depth[row, column], expected, atol=0.008)


@pytest.mark.render
def test_the_label_image_names_the_persons_parts(scene_and_diagram, context):
    scene, _, _ = scene_and_diagram
    camera = scene.camera.GetMyContextFromRoot(context)
    label = scene.camera.label_image_output_port().Eval(camera).data
    seen = set(np.unique(label).tolist())
    assert {PERSON_LABELS["body"], PERSON_LABELS["back"], WOUND_LABEL} <= seen
    assert min(PERSON_LABELS.values()) >= 100
    # In its home posture the arm leaves the whole back free.
    assert np.count_nonzero(label == PERSON_LABELS["back"]) > 4000


@pytest.mark.render
def test_the_wound_is_dark_where_its_outline_says(scene_and_diagram, context):
    scene, _, _ = scene_and_diagram
    camera = scene.camera.GetMyContextFromRoot(context)
    colour = scene.camera.color_image_output_port().Eval(camera).data[..., :3]
    X_WM = scene.true_person_pose(0.0)
    centre = project(scene, X_WM.multiply(scene.wound.outline.mean(axis=0)))[0][0]
    column, row = np.floor(centre).astype(int)
    assert colour[row, column].max() < 60
    (beside,), _ = TrueSkin(scene.person).under(np.array([[-0.3, 0.2]]))
    column, row = np.floor(project(scene, X_WM.multiply(beside))[0][0]).astype(int)
    assert colour[row, column, 0] > 120  # skin: bright and red


@pytest.mark.render
def test_all_that_the_camera_sees_of_the_arm_lies_in_its_hulls(
    scene_and_diagram, context
):
    import cv2

    scene, _, command = scene_and_diagram
    camera = scene.camera.GetMyContextFromRoot(context)
    label = scene.camera.label_image_output_port().Eval(camera).data[..., 0]
    silhouette = np.zeros(label.shape, dtype=np.uint8)
    for hull in ArmGeometry(scene.config.arm).hulls_in_world(command[:7]):
        pixels, _ = project(scene, hull)
        outline = cv2.convexHull((pixels - 0.5).astype(np.float32)[:, None])
        cv2.fillConvexPoly(silhouette, np.round(outline).astype(np.int32), 1)
    arm = label < 100
    outside = arm & (cv2.dilate(silhouette, np.ones((3, 3), np.uint8)) == 0)
    assert arm.any()
    assert not outside.any()


def test_gravity_does_not_let_the_nozzle_droop(scene_and_diagram):
    scene, diagram, command = scene_and_diagram
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.GetInputPort("joint_command").FixValue(context, command)
    simulator.AdvanceTo(0.5)
    plant = scene.plant
    own = plant.GetMyContextFromRoot(context)
    tip = plant.GetFrameByName("nozzle_tip").CalcPoseInWorld(own).translation()
    commanded = plant.CreateDefaultContext()
    plant.SetPositions(commanded, command[:7])
    wanted = plant.GetFrameByName("nozzle_tip").CalcPoseInWorld(commanded)
    assert np.linalg.norm(tip - wanted.translation()) < 1e-4  # m, a tenth of the limit


def test_the_camera_sees_hulls_and_the_display_the_full_meshes(scene_and_diagram):
    scene, _, _ = scene_and_diagram
    inspector = scene.scene_graph.model_inspector()
    for link in range(8):
        body = scene.plant.GetBodyByName(f"fr3_link{link}")
        frame = scene.plant.GetBodyFrameIdOrThrow(body.index())
        for role, suffix in (
            (Role.kPerception, "silhouette"),
            (Role.kIllustration, "visual"),
        ):
            (geometry,) = inspector.GetGeometries(frame, role)
            assert inspector.GetName(geometry).endswith(suffix)


@pytest.mark.parametrize(
    ("config", "message"),
    [
        (SceneConfig(time_step=0.0), "time_step must be positive"),
        (SceneConfig(person_position=[0.0, 1.0]), "person_position must be 3 finite"),
        (SceneConfig(arm=ArmConfig(home=[0.0] * 6)), r"arm\.home must be 7 finite"),
        (SceneConfig(arm=ArmConfig(damping=[0.0] * 7)), r"arm\.damping must be"),
        (SceneConfig(person_yaw=float("nan")), "person_yaw must be finite"),
        (SceneConfig(wound=WoundConfig(semi_axes=[0.1, 0.0])), r"wound\.semi_axes"),
        (SceneConfig(wound=WoundConfig(centre=[0.1])), r"wound\.centre"),
    ],
)
def test_numbers_that_make_no_scene_are_refused_by_name(config, message):
    with pytest.raises(ValueError, match=message):
        check_scene(config)
