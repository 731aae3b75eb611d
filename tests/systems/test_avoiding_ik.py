"""Inverse kinematics among things: the links keep off, and the nozzle gets there."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from bath_drake.control.avoidance import AvoidanceConfig
from bath_drake.safety.obstacle_distance import link_gaps
from bath_drake.safety.obstacles import Boxes, upright_box
from bath_drake.safety.self_distance import capsule_ends, self_distance
from bath_drake.scene.arm import make_control_plant
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.scene.config import ArmConfig
from bath_drake.systems.differential_ik import DifferentialIk

CHAIN = arm_chain(ArmConfig())
PLANT = make_control_plant(ArmConfig())
POSTURE = np.array(ArmConfig().posture)
STOP = AvoidanceConfig().stop
STEP = 0.005


def nozzle(q):
    context = PLANT.CreateDefaultContext()
    PLANT.SetPositions(context, q)
    return PLANT.GetFrameByName("nozzle_tip").CalcPoseInWorld(context)


def follow(shift, boxes, seconds=6.0, avoidance=None):
    """Goes from the posture to a shifted pose; joint commands (n, 14), place error."""
    dut = DifferentialIk(
        plant=PLANT,
        home=POSTURE,
        joint_acceleration=8.0,
        arm=CHAIN,
        avoidance=avoidance,
    )
    X = nozzle(POSTURE)
    goal = RigidTransform(X.rotation(), X.translation() + shift)
    simulator = Simulator(dut, dut.CreateDefaultContext())
    context = simulator.get_mutable_context()
    dut.GetInputPort("desired_nozzle_pose").FixValue(context, Value(goal))
    dut.GetInputPort("hold").FixValue(context, [0.0])
    dut.GetInputPort("obstacles").FixValue(context, Value(boxes))
    port, commands = dut.GetOutputPort("joint_command"), []
    for k in range(round(seconds / STEP)):
        simulator.AdvanceTo((k + 0.5) * STEP)
        commands.append(port.Eval(context).copy())
    end = nozzle(commands[-1][:7]).translation()
    return np.array(commands), np.linalg.norm(end - goal.translation())


def gaps(commands, boxes):
    return np.array([link_gaps(row[:7], CHAIN, boxes)[:, 0].min() for row in commands])


def in_the_way_of(capsule, commands):
    """A box of 0.1 m, 5 mm ahead of where a link comes to rest."""
    first, last = (
        capsule_ends(row[:7], CHAIN)[capsule].mean(axis=0) for row in commands[[0, -1]]
    )
    ahead = (last - first) / np.linalg.norm(last - first)
    centre = last + ahead * (CHAIN.capsules[capsule, 7] + 0.055)
    return upright_box(centre - 0.05, centre + 0.05, (capsule, capsule))


@pytest.mark.parametrize("shift", [(0.0, 0.2, 0.0), (0.0, -0.2, 0.0), (0.0, 0.0, 0.2)])
@pytest.mark.parametrize("capsule", [4, 5])
def test_a_link_goes_round_what_it_would_run_into_and_the_nozzle_gets_there(
    capsule, shift
):
    free, _ = follow(shift, Boxes())
    boxes = in_the_way_of(capsule, free)
    assert gaps(free, boxes).min() < 0.0
    commands, error = follow(shift, boxes)
    # A tick's way of what is told once a tick.
    assert gaps(commands, boxes).min() > STOP - 1e-3
    assert error < 1e-3


def test_where_there_is_no_way_round_it_stands_before_it():
    """A wall before all links, the nozzle's too."""
    tip = nozzle(POSTURE).translation()
    R_WB = ArmConfig().base_yaw
    inverse = np.array(
        [[np.cos(R_WB), np.sin(R_WB), 0], [-np.sin(R_WB), np.cos(R_WB), 0], [0, 0, 1]]
    )
    ahead = inverse @ nozzle(POSTURE).rotation().col(2)
    tip_B = inverse @ (tip - np.array(ArmConfig().base_position))
    centre = tip_B + 0.25 * ahead
    wall = upright_box(centre - 0.1, centre + 0.1, (1, 8))
    commands, error = follow(0.3 * nozzle(POSTURE).rotation().col(2), wall)
    assert gaps(commands, wall).min() > STOP - 1e-3
    assert error > 0.05
    assert np.abs(commands[-1, 7:]).max() < 0.01


def test_nothing_near_changes_nothing():
    far = upright_box([5.0, 5.0, 5.0], [6.0, 6.0, 6.0], (0, 8))
    alone, _ = follow((0.0, 0.1, 0.0), Boxes(), 1.0)
    beside, _ = follow((0.0, 0.1, 0.0), far, 1.0)
    np.testing.assert_array_equal(alone, beside)


def test_what_it_adds_keeps_to_the_joints_speed_and_acceleration():
    shift = (0.0, 0.0, 0.2)
    free, _ = follow(shift, Boxes())
    commands, _ = follow(shift, in_the_way_of(5, free))
    v = commands[:, 7:]
    assert (np.abs(v) <= 0.5 * PLANT.GetVelocityUpperLimits() + 1e-6).all()
    # 1 %: the solver's tolerance.
    assert np.abs(np.diff(v, axis=0)).max() <= STEP * 8.0 * 1.01


def to_the_base(way, up):
    """A shift of the nozzle towards the arm's own base, which folds the elbow."""
    away = np.array(ArmConfig().base_position) - nozzle(POSTURE).translation()
    away[2] = 0.0
    return way * away / np.linalg.norm(away) + [0.0, 0.0, up]


def own_gap(commands):
    return min(self_distance(row[:7], CHAIN) for row in commands)


@pytest.mark.parametrize("up", [-0.1, 0.0, 0.1])
def test_links_keep_off_each_other_and_the_nozzle_gets_there(up):
    heedless = AvoidanceConfig(stop=5e-4, near=1e-3, self_stop=1e-3)
    shift = to_the_base(0.2, up)
    free, _ = follow(shift, Boxes(), avoidance=heedless)
    assert own_gap(free) < 0.01
    commands, error = follow(shift, Boxes())
    # A tick's way of what is told once a tick.
    assert own_gap(commands) > AvoidanceConfig().self_stop - 1e-3
    assert error < 1e-3


def test_where_they_cannot_it_stands():
    commands, error = follow(to_the_base(0.3, 0.1), Boxes())
    assert own_gap(commands) > AvoidanceConfig().self_stop - 1e-3
    assert error > 0.05
    assert np.abs(commands[-1, 7:]).max() < 0.01
