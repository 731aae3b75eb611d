"""Restricted areas and a learned field make one sound world."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from bath_drake.certificate.certify import certify_from
from bath_drake.control.areas import GAP, contain, inflated, make_room
from bath_drake.control.world import CLEARANCE, join_areas, left_aside, skims
from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.field.obstacles import ObstacleSet, Workspace, pair_gaps
from bath_drake.field.rollout import RolloutStatus, rollout
from bath_drake.scenario import find_skill
from bath_drake.skill_file import load_skill

START = np.array([-0.7, 0.0])
FIELD = NavigationField(
    workspace=Workspace(np.zeros(2), np.full(2, 2.0)),
    goal=np.array([0.7, 0.0]),
    kappa=10.0,
    obstacles=ObstacleSet(
        np.array([[-0.2, 0.2, 0.2, 0.1, -1.0], [0.3, -0.2, 0.2, 0.1, 1.2]])
    ),
)
NONE = ObstacleSet()


def area(x, y, a, b, angle):
    return ObstacleSet(np.array([[x, y, a, b, angle]]))


AREAS = st.builds(
    area,
    st.floats(-0.25, 0.25),
    st.floats(-0.3, 0.3),
    st.floats(0.1, 0.3),
    st.floats(0.1, 0.3),
    st.floats(0.0, 3.1),
)


def test_without_areas_the_learned_field_stays_as_it_is():
    world = join_areas(FIELD, NONE, START)
    assert world.virtual is FIELD
    assert world.certificate.passed


@settings(max_examples=30)  # each makes up to eighteen worlds and proves some
@given(areas=AREAS)
def test_an_area_in_the_way_is_gone_round_to_the_goal(areas):
    # Start, area and goal in one line: the flow leads onto the saddle before the
    # area and stays there. Any nudge frees it; a world of measure zero.
    assume(abs(areas.theta[0, 1]) > 0.02)
    world = join_areas(FIELD, areas, START)
    assert world.certificate.passed
    path = rollout(START, world.field)
    assert path.status is RolloutStatus.ARRIVED
    only = NavigationField(FIELD.workspace, FIELD.goal, FIELD.kappa, areas)
    assert min_beta(path.path, only).min() > 0.0
    # The area is real: nothing made it smaller.
    np.testing.assert_array_equal(world.sensed.theta, areas.theta)


@given(areas=AREAS)
def test_virtual_obstacles_make_room_and_only_ever_shrink(areas):
    kept = make_room(FIELD.obstacles, areas)
    assert len(kept) <= len(FIELD.obstacles)
    if len(kept):
        # 1e-9: the gap is found by a search over directions, twice the same.
        assert pair_gaps(kept + areas)[: len(kept), len(kept) :].min() >= GAP - 1e-9
        centres = FIELD.obstacles.theta[:, :2].tolist()
        for row in kept.theta:
            whole = FIELD.obstacles.theta[centres.index(row[:2].tolist())]
            assert (row[2:4] <= whole[2:4]).all()


def test_an_area_on_the_goal_is_refuted_with_the_plain_union():
    areas = area(0.7, 0.0, 0.2, 0.2, 0.0)
    world = join_areas(FIELD, areas, START)
    assert not world.certificate.passed
    assert "goal" in world.certificate.reason
    assert world.certificate.verdict == certify_from(world.field, START).verdict


def test_a_trap_the_start_cannot_reach_is_no_reason_to_hold():
    # A wall broadside to the goal traps what comes from behind it, whatever gives
    # way; beyond it the motion from the start is proved all the same.
    wall, beyond = area(-0.3, 0.0, 0.05, 0.6, 0.0), np.array([0.2, 0.4])
    world = join_areas(FIELD, wall, beyond)
    assert world.certificate.passed
    assert world.certificate.region is not None
    assert rollout(beyond, world.field).status is RolloutStatus.ARRIVED
    before = join_areas(FIELD, wall, np.array([-0.9, 0.0]))
    assert not before.certificate.passed
    assert before.changed == "nothing: no sound world was found"


def test_a_path_left_nowhere_is_left_by_nothing():
    path = rollout(START, FIELD).path
    assert left_aside(path, path, NONE) == 0.0
    # All of it is 0.1 aside.
    moved = left_aside(path[:1], path[:1] + np.array([0.0, 0.1]), NONE)
    assert moved == pytest.approx(0.1)


@given(areas=AREAS, slack=st.floats(0.001, 0.1))
def test_slack_makes_areas_that_contain_the_given_ones(areas, slack):
    assert contain(inflated(areas, slack), areas)
    assert not contain(areas, inflated(areas, slack))


def test_areas_of_another_number_are_not_contained():
    assert not contain(NONE, area(0, 0, 0.1, 0.1, 0))
    assert contain(NONE, NONE)


BODY = Workspace(np.zeros(2), np.array([0.9, 1.0]), 6)


def test_the_bodys_rim_takes_the_learned_ones_place():
    world = join_areas(FIELD, NONE, START, BODY)
    assert world.learned == FIELD
    assert world.field.workspace == BODY
    assert world.certificate.passed


def test_the_motion_then_stays_within_the_body():
    world = join_areas(FIELD, NONE, START, BODY)
    rng = np.random.default_rng(3)
    starts = rng.uniform(-0.95, 0.95, (60, 2))
    for start in starts[BODY.beta(starts) > 0.05]:
        assert (BODY.beta(rollout(start, world.field).path) > 0.0).all()


def test_where_the_start_is_not_on_the_body_the_learned_rim_stays():
    narrow = Workspace(np.zeros(2), np.array([0.5, 1.0]), 6)
    outside = np.array([-0.7, 0.0])
    assert narrow.beta(outside) < 0.0
    assert join_areas(FIELD, NONE, outside, narrow).field == FIELD


def past(distance, begin=-0.6, end=0.6):
    """A straight path by a disc's boundary, at a distance from it, and that world."""
    world = NavigationField(
        Workspace(np.zeros(2), np.ones(2)),
        np.array([end, 0.0]),
        5.0,
        area(0.0, -0.3 - distance, 0.3, 0.3, 0.0),
    )
    x = np.linspace(begin, end, 400)
    return np.column_stack([x, np.zeros(400)]), world


@pytest.mark.parametrize(("share", "expected"), [(1.05, False), (0.95, True)])
def test_a_path_nearer_than_the_clearance_to_a_boundary_skims_it(share, expected):
    assert skims(*past(share * CLEARANCE)) == expected
    # A rim of radius one, along which a chord goes.
    _, world = past(0.4)
    turns = np.linspace(0.3, 2.0, 200)
    round_it = (1.0 - share * CLEARANCE) * np.column_stack(
        [np.cos(turns), np.sin(turns)]
    )
    inwards = np.linspace(0.2, 1.0, 50)[:, None] * round_it[0]
    way = np.vstack(
        [inwards, round_it, round_it[-1] * np.linspace(1.0, 0.2, 50)[:, None]]
    )
    assert skims(way, world) == expected


def test_where_a_path_begins_and_ends_it_may_be_near():
    assert not skims(*past(0.001, begin=0.0))
    assert not skims(*past(0.001, end=0.0))
    assert skims(*past(0.001, begin=0.0, end=0.01))


def test_of_sound_worlds_one_is_taken_that_leaves_the_guard_its_margin():
    # The nearest to the learned path goes between both areas 0.005 N from one of them:
    # the guard held there for good.
    skill = load_skill(find_skill("scrubbing.yaml"))
    areas = area(-0.006, 0.425, 0.327, 0.228, 0.004) + area(
        0.113, -0.487, 0.349, 0.282, 0.011
    )
    world = join_areas(skill.chain.fields[0], areas, skill.start)
    assert world.certificate.passed
    path = rollout(skill.start, world.field)
    assert path.status is RolloutStatus.ARRIVED
    assert not skims(path.path, world.field)
