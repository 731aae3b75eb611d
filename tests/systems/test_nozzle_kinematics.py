"""The nozzle's frame: at its tip, z along the jet."""

import numpy as np
import pytest
from pydrake.math import RotationMatrix
from pydrake.multibody.plant import MultibodyPlant

from bath_drake.scene.arm import ArmGeometry, home_position, make_control_plant
from bath_drake.scene.config import ArmConfig
from bath_drake.systems.nozzle_kinematics import NozzleKinematics

HOME = home_position(ArmConfig())


@pytest.fixture(scope="module")
def plant():
    return make_control_plant(ArmConfig())


def pose(plant, q):
    dut = NozzleKinematics(plant=plant)
    context = dut.CreateDefaultContext()
    state = np.concatenate([q, np.ones(7)])
    dut.GetInputPort("arm_state").FixValue(context, state)
    return dut.GetOutputPort("nozzle_pose").Eval(context)


def test_it_is_the_plants_forward_kinematics(plant):
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, HOME)
    expected = plant.GetFrameByName("nozzle_tip").CalcPoseInWorld(context)
    assert pose(plant, HOME).IsExactlyEqualTo(expected)


def test_no_part_of_the_arm_lies_in_the_jet(plant):
    X_WE = pose(plant, HOME)
    for hull in ArmGeometry(ArmConfig()).hulls_in_world(HOME):
        p_E = (hull - X_WE.translation()) @ X_WE.rotation().matrix()
        # Nothing reaches beyond the tip's plane near the jet's axis.
        near = np.hypot(p_E[:, 0], p_E[:, 1]) < 0.1
        assert (p_E[near, 2] < 1e-9).all()


def test_the_tip_is_the_middle_of_the_heads_face(plant):
    X_WE = pose(plant, HOME)
    head = ArmGeometry(ArmConfig()).hulls_in_world(HOME)[-1]
    p_E = (head - X_WE.translation()) @ X_WE.rotation().matrix()
    face = p_E[np.isclose(p_E[:, 2], p_E[:, 2].max(), atol=1e-5)]
    # Exact but for the six digits the model file is written with.
    np.testing.assert_allclose(face.mean(axis=0), 0.0, atol=1e-5)


def test_the_handle_hangs_below_when_x_points_up(plant):
    X_WE = pose(plant, HOME)
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, HOME)
    flange = plant.GetFrameByName("fr3_link8").CalcPoseInWorld(context)
    p_EF = X_WE.inverse().multiply(flange.translation())
    assert p_EF[0] < -0.1  # against E's x axis, the patient's up
    assert p_EF[2] < -0.03  # behind the tip


def test_turning_the_base_turns_the_nozzle_about_it():
    turned = ArmConfig(base_yaw=0.7, base_position=[0.0, 0.0, 0.3])
    straight = ArmConfig(base_yaw=0.0, base_position=[0.0, 0.0, 0.3])
    X = [pose(make_control_plant(config), HOME) for config in (turned, straight)]
    turn = RotationMatrix.MakeZRotation(0.7)
    np.testing.assert_allclose(
        X[0].translation(), turn.multiply(X[1].translation()), atol=1e-12
    )


def test_another_plant_is_refused():
    empty = MultibodyPlant(0.0)
    empty.Finalize()
    with pytest.raises(ValueError, match="7 positions, the arm alone, got 0"):
        NozzleKinematics(plant=empty)
