"""The arm is followed as the loop's inverse kinematics would move it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pose_source import PoseSource
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from bath_drake.reach.follow import Poses, follow, joined, way_to
from bath_drake.reach.kinematics import ArmModel
from bath_drake.scene.arm import home_position, make_control_plant
from bath_drake.scene.config import ArmConfig
from bath_drake.systems.differential_ik import DifferentialIk

STEP = 0.005
CONFIG = ArmConfig()
ARM = ArmModel.of(CONFIG)
BACK = np.array([0.5, 0.0, 0.95])
CORNERS = BACK + np.array([[0.0, 0.0, 0.0], [0.0, 0.1, 0.05], [0.0, -0.1, 0.1]])
FORWARD = np.array([1.0, 0.0, 0.0])


def stroke(ends, seconds):
    """Poses along a polygon, square to a plane across W's x, one every step."""
    count = round(seconds / STEP)
    along = np.linspace(0.0, len(ends) - 1.0, count + 1)[1:]
    tips = [np.interp(along, range(len(ends)), column) for column in np.transpose(ends)]
    return Poses(
        np.column_stack(tips), np.tile(FORWARD, (count, 1)), np.full(count, STEP)
    )


def driven(poses):
    """Joint positions (n, 7) of the loop's own system, one every step."""
    builder = DiagramBuilder()
    turned = [RotationMatrix.MakeFromOneVector(jet, 2) for jet in poses.jets]
    wanted = [RigidTransform(R, p) for R, p in zip(turned, poses.tips, strict=True)]
    source = builder.AddSystem(PoseSource(wanted, STEP))
    ik = builder.AddSystem(
        DifferentialIk(
            plant=make_control_plant(CONFIG),
            home=home_position(CONFIG),
            posture=CONFIG.posture,
            joint_margin=0.12,
        )
    )
    for port in ("desired_nozzle_pose", "hold"):
        builder.Connect(source.GetOutputPort(port), ik.GetInputPort(port))
    log = LogVectorOutput(ik.GetOutputPort("joint_command"), builder, STEP)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(STEP * len(poses))
    return log.FindLog(simulator.get_context()).data()[:7].T


def test_it_goes_the_way_of_the_loops_own_inverse_kinematics():
    stay = Poses(BACK[None], FORWARD[None], np.array([0.5]))
    way = joined([way_to(ARM, ARM.home, BACK, FORWARD), stay])
    wash = stroke(CORNERS, 4.0)
    here = follow(ARM, joined([way, wash]))
    # The loop's system is given the end of its way at once and goes there by itself.
    waiting = round(way.seconds.sum() / STEP)
    dense = Poses(
        np.vstack([np.repeat(stay.tips, waiting, 0), wash.tips]),
        np.vstack([np.repeat(stay.jets, waiting, 0), wash.jets]),
        np.full(waiting + len(wash), STEP),
    )
    there = driven(dense)
    apart = np.abs(here.q[len(way) :] - there[-len(wash) :]).max(axis=1)
    # Its acceleration is bounded and it lags by some 2 mm: it gets there a bit later,
    # and its null space with it.
    assert apart.max() < 0.03
    assert apart[-1] < 0.01


def test_a_coarse_path_is_followed_as_a_fine_one():
    way = way_to(ARM, ARM.home, BACK, FORWARD)
    fine = stroke(CORNERS[:2], 3.0)
    every = slice(9, None, 10)
    coarse = Poses(fine.tips[every], fine.jets[every], np.full(60, 10 * STEP))
    a = follow(ARM, joined([way, fine])).q[-1]
    b = follow(ARM, joined([way, coarse])).q[-1]
    # The null space is drawn along in longer steps.
    np.testing.assert_allclose(a, b, atol=5e-3)


def test_what_is_near_is_met():
    found = follow(ARM, way_to(ARM, ARM.home, BACK, FORWARD))
    assert found.place_error[-1] < 1e-3
    assert found.jet_error[-1] < 1e-3
    p, R = ARM.nozzle(found.q[-1])
    np.testing.assert_allclose(p, BACK, atol=1e-3)
    np.testing.assert_allclose(R[:, 2], FORWARD, atol=1e-3)


@given(st.tuples(*[st.floats(-2.0, 2.0)] * 3))
def test_no_place_leads_a_joint_out_of_its_range(place):
    found = follow(ARM, way_to(ARM, ARM.home, np.array(place), FORWARD))
    assert np.isfinite(found.q).all()
    assert (found.q >= ARM.low - 1e-12).all()
    assert (found.q <= ARM.high + 1e-12).all()


def test_a_place_beyond_the_arms_length_is_missed_by_what_it_is_too_far():
    far = BACK + np.array([1.0, 0.0, 0.0])
    found = follow(ARM, way_to(ARM, ARM.home, far, FORWARD))
    assert found.place_error[-1] > 0.4


def test_nothing_to_follow_is_nothing():
    nothing = Poses(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    assert len(follow(ARM, nothing).q) == 0


@pytest.mark.parametrize("base", [[0.3, 0.2, 0.1], [-0.1, -0.4, 0.5]])
def test_where_the_base_stands_moves_everything_with_it(base):
    moved = ARM.at(base, 0.0)
    straight = ARM.at([0.0, 0.0, 0.0], 0.0)
    here = follow(straight, way_to(straight, ARM.home, BACK, FORWARD))
    there = follow(moved, way_to(moved, ARM.home, BACK + base, FORWARD))
    np.testing.assert_allclose(here.q, there.q, atol=1e-6)
