"""What is said of a path and of a back holds, and is said the same again."""

import json
from dataclasses import replace

import numpy as np
import pytest

from bath_drake.patient.motion import MotionConfig, person_displacement, trunk_bend
from bath_drake.patient.people import load_person, shipped_people
from bath_drake.reach.along_path import Manner, along, even
from bath_drake.reach.back import extreme_motions, nozzle_poses, true_back
from bath_drake.reach.clearance import body_points, clearance, pedestal_clearance
from bath_drake.reach.follow import Poses, follow, way_to
from bath_drake.reach.judge import Cause, judge
from bath_drake.reach.kinematics import ArmModel
from bath_drake.reach.over_back import grid, over
from bath_drake.reach.placement import PlacementGrid, placement_map, search_placement
from bath_drake.reach.precheck import not_reached, reachability
from bath_drake.safety.limits import load_limits
from bath_drake.safety.obstacle_distance import FAR
from bath_drake.scenario import Scenario, find_skill, load_scenario
from bath_drake.scene.config import ArmConfig, SceneConfig
from bath_drake.skill_file import load_skill
from bath_drake.strokes import scenario_skill

STILL = MotionConfig(breath_amplitude=0.0, twist_amplitude=0.0, lean_amplitude=0.0)
SCENE = SceneConfig(motion=STILL)
MANNER = Manner(limits=load_limits())
ARM = ArmModel.of(ArmConfig())
MIDDLE = np.array([0.5, 0.0, 0.95]), np.array([1.0, 0.0, 0.0])
STROKE = np.array([[-0.3, -0.2], [0.3, 0.1]])
# What washes in a closed loop, as other tests show.
WASHED = [
    "reproduction",
    "restricted_area",
    "coverage",
    "bending",
    "wash_contact",
    "other_arm",
]
# Drawn to this the iiwa's wrist comes to the shoulder of some people.
WRIST_NEAR = [1.645, -1.420, -1.351, -1.303, -2.247, -1.322, 0.304]
HALF_METRE_BACK = ARM.at(ARM.X_WB[:3, 3] - [0.6, 0.0, 0.0], 0.0)


@pytest.fixture(scope="module")
def person():
    return load_person(SCENE.person)


@pytest.fixture(scope="module")
def back(person):
    return true_back(SCENE, person)


@pytest.fixture(scope="module")
def body(person):
    return body_points(SCENE, person)


def test_a_stroke_over_the_middle_of_the_back_is_reached(back):
    (places,) = along(ARM, back, STROKE, MANNER)
    assert places.reached
    assert places.share == 1.0
    np.testing.assert_allclose(places.p_N[[0, -1]], STROKE)
    assert (places.place_error < 1e-3).all()


def test_from_too_far_away_none_of_it_is_and_it_is_said_why(back):
    (places,) = along(HALF_METRE_BACK, back, STROKE, MANNER)
    assert not places.reached
    assert places.share == 0.0
    causes = {part["cause"] for part in not_reached(places)}
    assert causes <= {"too far", "joint limit", "singular"}
    assert places.place_error.min() > 0.1


def test_the_map_is_the_same_again(back):
    points = grid(0.8, 0.4)
    first, again = (over(ARM, back, MANNER, points) for _ in range(2))
    for name, value in vars(first).items():
        np.testing.assert_array_equal(value, getattr(again, name))


def test_the_maps_middle_is_reached_and_what_is_no_skin_is_not_judged(back):
    points = grid(1.6, 0.4)
    places = over(ARM, back, MANNER, points)
    cause = places.cause.reshape(points.shape[:2])
    assert cause[4, 4] == Cause.NONE
    assert cause[0, 0] == Cause.NO_SKIN
    assert np.isnan(places.condition[0])


def test_the_map_agrees_with_a_path_that_leads_there(back):
    points = grid(0.4, 0.4)
    middle_right = over(ARM, back, MANNER, points).condition.reshape(3, 3)[1, 2]
    (places,) = along(ARM, back, np.array([[0.0, 0.0], [0.4, 0.0]]), MANNER)
    # The path's null space has been drawn along in other steps.
    assert places.condition[-1] == pytest.approx(middle_right, rel=0.05)


def test_the_search_brings_back_a_base_that_stands_too_far_away(back, body):
    places = PlacementGrid(x=[0.0, 0.3, 0.6], y=[0.0], z=[0.0], yaw=[0.0])
    here, best = search_placement(HALF_METRE_BACK, back, STROKE, body, MANNER, places)
    assert here.path_share == 0.0
    assert best.path_share == 1.0
    assert best.position[0] > here.position[0]
    assert best.clearance > 0.03
    _, again = search_placement(HALF_METRE_BACK, back, STROKE, body, MANNER, places)
    np.testing.assert_array_equal(best.position, again.position)


def test_no_base_stands_in_the_person(back, body):
    seat = np.array([0.75, 0.0, 0.5])
    assert pedestal_clearance(ARM.at(seat, 0.0), body) < 0.0
    assert pedestal_clearance(ARM, body) > 0.05


def test_clearance_is_less_where_the_arm_is_nearer(body):
    here = clearance(ARM, body, ARM.posture[None])
    yaw = ArmConfig().base_yaw
    nearer = ARM.at(ARM.X_WB[:3, 3] + [0.1, 0.0, 0.0], yaw)
    assert clearance(nearer, body, ARM.posture[None]) < here
    assert clearance(ARM, body, ARM.home[None]) > 0.2


def test_extreme_motions_are_the_ends_of_the_motion(person):
    motion = MotionConfig()
    found = extreme_motions(motion)
    assert len(found) == 4
    turns = set()
    for extreme in found:
        R, _ = person_displacement(0.0, extreme, person.hips, person.back_normal)
        twist, lean = np.arctan2(R[1, 0], R[0, 0]), np.arctan2(R[2, 1], R[2, 2])
        turns.add((np.round(twist, 6), np.round(lean, 6)))
    ends = {round(a * 0.0873, 6) for a in (1, -1)}
    assert turns == {(twist, lean) for twist in ends for lean in ends}
    assert extreme_motions(STILL) == []
    bending = MotionConfig(flexion_amplitude=0.1, side_bend_amplitude=0.2)
    bends = {
        (round(bend.flexion, 6), round(bend.side_bend, 6))
        for bend in (trunk_bend(0.0, extreme) for extreme in extreme_motions(bending))
    }
    assert bends == {(0.1, 0.2), (0.1, -0.2), (-0.1, 0.2), (-0.1, -0.2)}


def test_the_nozzle_stands_off_squared_to_the_skin():
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.07, 0.0]])
    normals = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    poses = nozzle_poses(points, normals, 0.06, 0.07)
    np.testing.assert_allclose(poses.tips, points + 0.06 * normals)
    np.testing.assert_allclose(poses.jets, -normals)
    # A quarter turn takes longer than the way: the tracking turns with 1 rad/s.
    np.testing.assert_allclose(poses.seconds, [0.0, np.pi / 2.0])


def test_a_path_keeps_its_ends_and_its_length():
    path = np.array([[0.0, 0.0], [0.3, 0.0], [0.3, 0.1]])
    points = even(path, 0.03)
    np.testing.assert_allclose(points[[0, -1]], path[[0, -1]])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.max() < 0.0301


def test_the_metrics_are_plain_and_the_line_says_how_it_is():
    scenario = load_scenario("reproduction")
    scenario.scene.motion = STILL
    skill = load_skill(find_skill(scenario.skill))
    found = reachability(scenario, skill, back=False)
    metrics = json.loads(json.dumps(found.metrics(), allow_nan=False))
    assert metrics["path"]["reached"]
    assert metrics["better_base"] is None
    (line,) = found.lines()
    assert line.startswith("reach:   the whole path is reached; condition number")
    assert found.rest.reached


def found_of(name, person, posture=None):
    scenario = load_scenario(name)
    scenario.scene.person = person
    if posture is not None:
        scenario.scene.arm.posture = posture
    skill = scenario_skill(scenario)
    return reachability(scenario, skill, back=False, search=False)


def check_that_no_link_is_in_the_way(name, person):
    found = found_of(name, person)
    near = found.path.obstacle_distance
    assert not (found.path.cause == Cause.LINK_NEAR).any()
    assert near.min() > found.limits.joints.obstacle_distance


@pytest.mark.parametrize("name", WASHED)
def test_what_the_loop_washes_is_not_refused_for_a_link(name):
    check_that_no_link_is_in_the_way(name, "m_avg")


# The thinnest and the heaviest here, the six between them where all is run.
@pytest.mark.slow
@pytest.mark.parametrize(
    "person",
    [
        person
        if person in ("f_thin", "m_heavy")
        else pytest.param(person, marks=pytest.mark.exhaustive)
        for person in shipped_people()
    ],
)
@pytest.mark.parametrize("name", WASHED)
def test_what_the_loop_washes_is_not_refused_for_a_link_on_anybody(name, person):
    check_that_no_link_is_in_the_way(name, person)


@pytest.mark.parametrize("person", ["f_avg", "f_thin"])
def test_a_wrist_that_stays_before_the_person_is_refused_and_told(person):
    found = found_of("other_arm", person, WRIST_NEAR)
    assert found.rest.share < 0.95
    causes = {part["cause"] for part in not_reached(found.path)}
    assert causes == {Cause.LINK_NEAR.words}
    (line,) = found.lines()
    assert "a link would come too near to person, stool or pedestal" in line


def test_a_nozzle_that_makes_way_for_a_link_but_little_is_told_and_not_refused():
    found = found_of("other_arm", "m_thin")
    lag = MANNER.leash * 0.25  # no back is 0.5 m high or wide
    assert found.path.reached
    assert 0.005 < found.path.place_error.max() < lag
    (line,) = found.lines()
    assert "(the nozzle up to " in line


@pytest.mark.slow
@pytest.mark.exhaustive
def test_a_base_from_which_no_link_is_in_the_way_is_told():
    scenario = load_scenario("other_arm")
    scenario.scene.person = "f_thin"
    scenario.scene.arm.posture = WRIST_NEAR
    scenario.scene.motion = STILL
    skill = scenario_skill(scenario)
    found = reachability(scenario, skill, back=False)
    assert found.best is not None
    assert found.best.path_share > found.here.path_share


def test_the_pedestal_is_kept_off_as_high_as_the_base_stands(back):
    (posed,) = back.poses
    low, high = (ARM.at([0.0, 0.0, z], 0.0) for z in (0.0, 0.5))
    boxes = [posed.boxes(arm) for arm in (low, high)]
    assert len(boxes[1].centres) == len(boxes[0].centres) + 1
    assert boxes[1].halves[-1, 2] == pytest.approx(0.25)


def test_a_nozzle_that_lags_behind_a_link_counts_once_the_reference_waits_for_it(back):
    (posed,) = back.poses
    followed = follow(ARM, Poses(np.zeros((3, 3)), np.eye(3), np.full(3, 0.1)))
    n = len(followed.q)
    lag = MANNER.lag(posed.canonical_map.half_extents)
    slowed = replace(
        followed,
        condition=np.full(n, 5.0),
        place_error=lag * np.array([0.5, 0.9, 1.1]),
        jet_error=np.zeros(n),
        slowed=np.ones(n, dtype=bool),
        obstacle_distance=np.full(n, FAR),
    )
    cause = judge(ARM, np.zeros((n, 2)), slowed, MANNER.limits, lag).cause
    assert (cause == Cause.LINK_NEAR).tolist() == [False, False, True]


@pytest.mark.parametrize("over", [-1e-4, 1e-4])
def test_nearer_than_the_guard_allows_is_not_reached(over):
    followed = follow(ARM, way_to(ARM, ARM.home, *MIDDLE))
    limit = MANNER.limits.joints.obstacle_distance
    near = replace(followed, obstacle_distance=np.full(len(followed.q), limit + over))
    cause = judge(ARM, np.zeros((len(near.q), 2)), near, MANNER.limits, 0.02).cause
    assert (cause[-1] == Cause.LINK_NEAR) == (over < 0.0)


@pytest.mark.slow
def test_a_base_too_far_away_is_told_with_the_part_the_cause_and_a_better_one():
    scenario = Scenario(skill="back_sinusoid.yaml")
    scenario.scene.motion = STILL
    scenario.scene.arm.base_position[0] -= 0.25
    skill = load_skill(find_skill(scenario.skill))
    found = reachability(scenario, skill, back=False)
    first, second = found.lines()
    assert "of the path is reached; from (" in first
    assert second.startswith("base:    at [")
    better = found.metrics()["better_base"]
    assert better["path_share"] > found.metrics()["path"]["share"]


@pytest.mark.slow
def test_the_floors_map_has_the_base_where_it_stands(back, body):
    plan = placement_map(ARM, back, STROKE, body, MANNER)
    assert plan.share.shape == (len(plan.y), len(plan.x))
    i, j = len(plan.y) // 2, len(plan.x) // 2
    np.testing.assert_allclose([plan.x[j], plan.y[i]], ARM.X_WB[:2, 3], atol=1e-3)
    assert plan.path_share[i, j] == 1.0
    known = plan.share[np.isfinite(plan.share)]
    assert ((known >= 0.0) & (known <= 1.0)).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", shipped_people())
def test_the_back_up_to_its_top_is_reached_on_everybody(name):
    x, y = np.linspace(-0.75, 0.75, 11), np.linspace(-0.8, 0.8, 11)
    region = np.stack(np.meshgrid(x, y), axis=-1)
    everyone = true_back(SceneConfig(person=name), load_person(name))
    places = over(ARM, everyone, MANNER, region)
    joints = MANNER.limits.joints
    # Low at the left edge an arm's link comes to the person's side.
    failed = places.cause != Cause.NONE
    assert (places.cause[failed] == Cause.LINK_NEAR).all()
    assert (places.p_N[failed] < [-0.7, -0.3]).all()
    assert places.share > 0.97
    assert places.condition.max() < 0.9 * joints.condition_stop
    assert np.mean(places.condition < joints.condition_slow) >= 0.94
    assert places.self_distance.min() > joints.self_distance
