"""The skin that can be touched, in Drake's plant."""

import numpy as np
import pytest
from pydrake.geometry import (
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from bath_drake.patient.motion import MotionConfig, trunk_bend
from bath_drake.patient.segment_motion import SegmentedSkin
from bath_drake.patient.skin_segments import (
    DEPTH,
    STEP,
    segmented_skin,
    skin_segment,
)
from bath_drake.scene import add_scene
from bath_drake.scene.config import ArmConfig, SceneConfig
from bath_drake.scene.touched_skin import STIFFNESS, add_touched_skin
from bath_drake.systems.kinematic_arm import KinematicArm
from bath_drake.verification import pose_from_row

RADIUS = 0.05


def flat_skin(rows):
    """Slabs in the plane z = 0, those of the given rows of nodes."""
    x = STEP * np.arange(-8, 9)
    segments = []
    for first, last in rows:
        y = STEP * np.arange(first, last + 1)
        grid = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((17, len(y)))], -1)
        there = np.ones(grid.shape[:2], dtype=bool)
        segments.append(skin_segment(grid, there, np.array([0.0, 0.0, 1.0])))
    return SegmentedSkin(tuple(segments), None, np.arange(len(rows)))


def pressed(skin, depth, y):
    """The force, N, on a ball so deep in the skin, at rest, along the normal."""
    builder = DiagramBuilder()
    # The contact of now, not that of the last step.
    config = MultibodyPlantConfig(time_step=0.002, use_sampled_output_ports=False)
    plant, graph = AddMultibodyPlant(config, builder)
    add_touched_skin(plant, graph, skin, RigidTransform())
    body = plant.AddRigidBody(
        "ball",
        plant.AddModelInstance("tool"),
        SpatialInertia.SolidSphereWithMass(1.0, RADIUS),
    )
    properties = ProximityProperties()
    AddRigidHydroelasticProperties(0.004, properties)
    AddContactMaterial(friction=CoulombFriction(0.3, 0.3), properties=properties)
    plant.RegisterCollisionGeometry(
        body, RigidTransform(), Sphere(RADIUS), "ball", properties
    )
    plant.WeldFrames(
        plant.world_frame(),
        body.body_frame(),
        RigidTransform([0.003, y, RADIUS - depth]),
    )
    plant.Finalize()
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    own = plant.GetMyMutableContextFromRoot(context)
    instance = plant.GetModelInstanceByName("skin")
    plant.get_desired_state_input_port(instance).FixValue(
        own, np.zeros(12 * len(skin.segments))
    )
    results = plant.get_contact_results_output_port().Eval(own)
    forces = [
        abs(results.hydroelastic_contact_info(k).F_Ac_W().translational()[2])
        for k in range(results.num_hydroelastic_contacts())
    ]
    assert results.num_point_pair_contacts() == 0
    return sum(forces)


ONE, TWO = flat_skin([(-12, 12)]), flat_skin([(-12, 1), (0, 12)])


@pytest.mark.parametrize("depth", [0.003, 0.006])
def test_the_force_is_that_of_an_elastic_foundation(depth):
    # Of a sphere: the pressure times the cap's volume. Both meshes are coarse.
    expected = STIFFNESS * np.pi * RADIUS * depth**2 * (1.0 - depth / (3.0 * RADIUS))
    assert pressed(ONE, depth, 0.0) == pytest.approx(expected, rel=0.15)


@pytest.mark.parametrize("y", [-0.03, -0.008, 0.0, 0.008, 0.016, 0.03])
def test_no_seam_is_felt(y):
    # Where they overlap, a product of two ramps is cut into pieces that are straight.
    whole = pressed(ONE, 0.005, y)
    assert whole > 1.0
    assert pressed(TWO, 0.005, y) == pytest.approx(whole, rel=0.12)


def contact_scene():
    motion = MotionConfig(
        flexion_amplitude=0.07, chest_amplitude=0.006, flexion_period=3.0, ramp=0.0
    )
    builder = DiagramBuilder()
    config = SceneConfig(
        arm=ArmConfig(fidelity="contact", tool="sponge"), motion=motion, time_step=0.005
    )
    scene = add_scene(builder, config, films=False, draws=False)
    home = builder.AddSystem(KinematicArm())
    builder.Connect(home.GetOutputPort("arm_state"), scene.arm_command)
    return scene, home, builder.Build(), motion


def test_the_slabs_follow_the_bending_person_and_the_arm_does_not_droop():
    scene, home, diagram, motion = contact_scene()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    rest = np.concatenate([scene.config.arm.home, np.zeros(7)])
    home.GetInputPort("arm_desired_state").FixValue(
        home.GetMyMutableContextFromRoot(context), rest
    )
    simulator.AdvanceTo(0.6)
    t, plant = context.get_time(), scene.plant
    own = plant.GetMyContextFromRoot(context)
    pose = scene.patient_motion.GetOutputPort("body_pose")
    X_WM = pose_from_row(pose.Eval(scene.patient_motion.GetMyContextFromRoot(context)))
    skin = segmented_skin(scene.person, bends=True)
    R_MS, p_MS = skin.poses(trunk_bend(t, motion))
    for k in range(len(skin.segments)):
        X_WS = plant.EvalBodyPoseInWorld(own, plant.GetBodyByName(f"skin{k + 1}"))
        # 20 um and 0.1 mrad: what their joints lag behind.
        p_WS = X_WM.multiply(p_MS[k])
        np.testing.assert_allclose(X_WS.translation(), p_WS, atol=2e-5)
        R_WS = X_WM.rotation().matrix() @ R_MS[k]
        np.testing.assert_allclose(X_WS.rotation().matrix(), R_WS, atol=1e-4)
    q = scene.arm_state.Eval(own)[:7]
    np.testing.assert_allclose(q, scene.config.arm.home, atol=1e-4)
    assert DEPTH == STEP


@pytest.mark.parametrize(
    ("arm", "words"),
    [
        (ArmConfig(fidelity="contact"), "allowed: sponge"),
        (ArmConfig(tool="brush"), "allowed: nozzle, sponge"),
        (ArmConfig(fidelity="soft"), "allowed: dynamic, kinematic, contact"),
    ],
)
def test_a_tool_that_does_not_fit_is_refused(arm, words):
    with pytest.raises(ValueError, match=words):
        add_scene(DiagramBuilder(), SceneConfig(arm=arm))
