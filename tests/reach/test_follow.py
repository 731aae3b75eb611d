"""The arm is followed as the loop's inverse kinematics would move it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pose_source import PoseSource
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource, LogVectorOutput

from bath_drake.reach.follow import Poses, follow, joined, way_to
from bath_drake.reach.kinematics import ArmModel
from bath_drake.safety.obstacle_distance import FAR, link_gaps
from bath_drake.safety.obstacles import upright_box
from bath_drake.safety.self_distance import capsule_ends
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


def gaps(q, boxes):
    """Of the links from the boxes at positions (n, 7), m."""
    return np.array([link_gaps(row, ARM.chain, boxes)[:, 0].min() for row in q])


def in_the_way_of(capsule, q):
    """A box of 0.1 m, 5 mm ahead of where a link comes to on a way (n, 7)."""
    first, last = (capsule_ends(row, ARM.chain)[capsule].mean(0) for row in q[[0, -1]])
    ahead = (last - first) / np.linalg.norm(last - first)
    centre = last + ahead * (ARM.chain.capsules[capsule, 7] + 0.055)
    return upright_box(centre - 0.05, centre + 0.05, (capsule, capsule))


def shifted(shift):
    """Poses from where the nozzle is in the posture to a shift, and some rest."""
    p, R = ARM.nozzle(ARM.posture)
    ends = np.stack([p, p + shift, p + shift])
    poses = stroke(ends, 6.0)
    return Poses(poses.tips, np.tile(R[:, 2], (len(poses), 1)), poses.seconds)


def driven(poses, boxes=None, home=None):
    """Joint positions (n, 7) of the loop's own system, one every step."""
    builder = DiagramBuilder()
    turned = [RotationMatrix.MakeFromOneVector(jet, 2) for jet in poses.jets]
    wanted = [RigidTransform(R, p) for R, p in zip(turned, poses.tips, strict=True)]
    source = builder.AddSystem(PoseSource(wanted, STEP))
    ik = builder.AddSystem(
        DifferentialIk(
            plant=make_control_plant(CONFIG),
            home=home_position(CONFIG) if home is None else home,
            posture=CONFIG.posture,
            joint_margin=0.12,
            arm=ARM.chain,
            avoidance=ARM.avoidance,
        )
    )
    if boxes is not None:
        things = builder.AddSystem(ConstantValueSource(Value(boxes)))
        builder.Connect(things.get_output_port(), ik.GetInputPort("obstacles"))
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


@pytest.mark.parametrize("shift", [(0.0, 0.2, 0.0), (0.0, -0.2, 0.0), (0.0, 0.0, 0.2)])
@pytest.mark.parametrize("capsule", [4, 5])
def test_it_goes_round_a_box_as_the_loops_own_inverse_kinematics(capsule, shift):
    fine = shifted(np.array(shift))
    free = follow(ARM, fine, q=ARM.posture)
    boxes = in_the_way_of(capsule, free.q)
    assert gaps(free.q, boxes).min() < 0.01
    loops = driven(fine, boxes, home=ARM.posture)
    every = slice(9, None, 10)
    coarse = Poses(fine.tips[every], fine.jets[every], np.full(120, 10 * STEP))
    found = follow(ARM, coarse, boxes, ARM.posture)
    # A step's way of what is told once a step.
    assert found.obstacle_distance.min() > ARM.avoidance.stop - 2e-3
    assert found.place_error[-1] < 1e-3
    # Along a box they slide apart: the loop's joints are bounded in acceleration.
    np.testing.assert_allclose(
        gaps(found.q, boxes), gaps(loops[every], boxes), atol=8e-3
    )


def test_before_a_wall_it_stands_and_tells_what_for():
    p, R = ARM.nozzle(ARM.posture)
    (ahead,) = ARM.into_base(np.zeros((0, 3)), R[None, :, 2])[1]
    (tip,) = ARM.into_base(p[None], np.zeros((0, 3)))[0]
    centre = tip + 0.25 * ahead
    wall = upright_box(centre - 0.1, centre + 0.1, (1, 8))
    found = follow(ARM, shifted(0.3 * R[:, 2]), wall, ARM.posture)
    assert found.obstacle_distance.min() > ARM.avoidance.stop - 1e-3
    assert found.place_error[-1] > 0.05
    assert found.slowed[-1]
    assert not found.slowed[0]


def test_what_is_far_away_changes_nothing():
    way = way_to(ARM, ARM.home, BACK, FORWARD)
    far = upright_box([5.0, 5.0, 5.0], [6.0, 6.0, 6.0])
    alone, beside = follow(ARM, way), follow(ARM, way, far)
    np.testing.assert_array_equal(alone.q, beside.q)
    assert not beside.slowed.any()
    np.testing.assert_array_equal(beside.obstacle_distance, FAR)


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
