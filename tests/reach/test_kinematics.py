"""The reach's own kinematics are the model's, and its numbers the guard's."""

import numpy as np
import pytest
from pydrake.multibody.tree import JacobianWrtVariable

from bath_drake.reach.kinematics import ArmModel, condition_number, pose_and_jacobian
from bath_drake.safety import joint_command
from bath_drake.scene.arm import make_control_plant
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.scene.config import ArmConfig
from bath_drake.systems.nozzle_kinematics import NOZZLE_FRAME

CONFIG = ArmConfig(base_position=[0.1, -0.2, 0.3], base_yaw=0.4)
CHAIN = arm_chain(CONFIG)
# The model's file gives angles to eight digits.
FILE = 1e-7


@pytest.fixture(scope="module")
def plant():
    return make_control_plant(CONFIG)


@pytest.fixture(scope="module")
def positions():
    ends = ArmModel.of(CONFIG).ends
    return np.random.default_rng(3).uniform(*ends, size=(20, 7))


def jacobian_in_nozzle(plant, context):
    frame = plant.GetFrameByName(NOZZLE_FRAME)
    return plant.CalcJacobianSpatialVelocity(
        context,
        JacobianWrtVariable.kV,
        frame,
        np.zeros(3),
        plant.world_frame(),
        frame,
    )


def test_the_nozzle_is_where_the_plant_has_it(plant, positions):
    arm, context = ArmModel.of(CONFIG), plant.CreateDefaultContext()
    for q in positions:
        plant.SetPositions(context, q)
        X_WE = plant.GetFrameByName(NOZZLE_FRAME).CalcPoseInWorld(context)
        p, R = arm.nozzle(q)
        np.testing.assert_allclose(p, X_WE.translation(), atol=FILE)
        np.testing.assert_allclose(R, X_WE.rotation().matrix(), atol=FILE)


def test_the_jacobian_is_the_plants_without_the_turn_about_the_jet(plant, positions):
    context = plant.CreateDefaultContext()
    for q in positions:
        plant.SetPositions(context, q)
        expected = jacobian_in_nozzle(plant, context)[[0, 1, 3, 4, 5]]
        np.testing.assert_allclose(pose_and_jacobian(q, CHAIN)[2], expected, atol=FILE)


def test_the_condition_number_is_the_guards(plant, positions):
    context = plant.CreateDefaultContext()
    for q in positions:
        plant.SetPositions(context, q)
        J_E = jacobian_in_nozzle(plant, context)
        guards = joint_command.condition_number(J_E, np.eye(3))
        # The square root of an eigenvalue's rounding, and the file's.
        assert condition_number(q, CHAIN) == pytest.approx(guards, rel=1e-4)


def test_margin_is_that_of_the_joint_nearest_to_an_end():
    arm = ArmModel.of(CONFIG)
    q = arm.ends.mean(axis=0)
    q[4] = arm.ends[1, 4] - 0.2
    assert arm.margin(q) == pytest.approx(0.2)
    assert arm.margin(np.stack([q, q])).shape == (2,)


def test_positions_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"q must have shape \(7,\), got \(6,\)"):
        condition_number(np.zeros(6), CHAIN)
