"""The systems between what is seen of a person and the distance the guard takes."""

import numpy as np
import pytest
from pydrake.common.value import Value

from bath_drake.perception.canonical import CanonicalMap
from bath_drake.safety.obstacle_distance import obstacle_distance_ahead
from bath_drake.safety.obstacles import person_boxes
from bath_drake.scene.arm import base_pose
from bath_drake.scene.arm_chain import arm_chain
from bath_drake.scene.config import ArmConfig, SceneConfig
from bath_drake.scene.obstacles import fixed_obstacles
from bath_drake.systems.body_obstacles import BodyObstacles
from bath_drake.systems.canonical_projector import unknown_map
from bath_drake.systems.obstacle_distance import ObstacleDistance

CHAIN = arm_chain(ArmConfig())
POSTURE = np.array(ArmConfig().posture)
X_WB = np.array(base_pose(ArmConfig()).GetAsMatrix4())
FIXED = fixed_obstacles(SceneConfig())
# x right, y up and to the head, z out of the back, which faces the arm.
SEEN = CanonicalMap(
    np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    np.array([0.64, 0.0, 0.85]),
    np.array([0.17, 0.24]),
)


def obstacles(canonical_map):
    dut = BodyObstacles(X_WB=X_WB, fixed=FIXED)
    context = dut.CreateDefaultContext()
    dut.GetInputPort("canonical_map").FixValue(context, Value(canonical_map))
    return dut.GetOutputPort("obstacles").Eval(context)


def distance(q, v, boxes):
    dut = ObstacleDistance(arm=CHAIN)
    context = dut.CreateDefaultContext()
    dut.GetInputPort("joint_command").FixValue(context, np.concatenate([q, v]))
    dut.GetInputPort("obstacles").FixValue(context, Value(boxes))
    (told,) = dut.GetOutputPort("obstacle_distance").Eval(context)
    return told


def test_before_a_body_is_seen_there_are_the_fixed_things_alone():
    boxes = obstacles(unknown_map())
    np.testing.assert_array_equal(boxes.centres, FIXED.centres)
    assert len(boxes.centres) == 2  # pedestal and stool


def test_a_body_that_is_seen_joins_them():
    boxes = obstacles(SEEN)
    person = person_boxes(SEEN.R_WP, SEEN.p_WP, SEEN.half_extents).seen_from(X_WB)
    np.testing.assert_array_equal(boxes.centres, (person + FIXED).centres)
    np.testing.assert_array_equal(boxes.axes, (person + FIXED).axes)


def test_the_distance_is_that_of_the_pure_function():
    v, boxes = np.linspace(-0.2, 0.2, 7), obstacles(SEEN)
    told = distance(POSTURE, v, boxes)
    assert told == obstacle_distance_ahead(POSTURE, v, CHAIN, boxes)
    assert np.isnan(distance(POSTURE, np.full(7, np.nan), boxes))


def test_home_and_posture_are_clear_of_the_fixed_things():
    for q in (np.array(ArmConfig().home), POSTURE):
        assert distance(q, np.zeros(7), FIXED) > 0.08


@pytest.mark.parametrize("bad", [np.eye(3), np.full((4, 4), np.nan)])
def test_a_base_that_is_no_pose_is_refused(bad):
    with pytest.raises(ValueError, match="X_WB must be"):
        BodyObstacles(X_WB=bad, fixed=FIXED)


def test_a_lookahead_that_is_none_is_refused():
    with pytest.raises(ValueError, match="lookahead"):
        ObstacleDistance(arm=CHAIN, lookahead=-1.0)
