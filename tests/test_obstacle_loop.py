"""The closed loop keeps the arm's links off the person, and washes all the same."""

import numpy as np
import pytest

from bath_drake.diagrams import build_reproduction
from bath_drake.patient.people import load_person
from bath_drake.patient.skin import TrueSkin
from bath_drake.reach.kinematics import ArmModel
from bath_drake.safety.limits import GuardLimits
from bath_drake.safety.obstacle_distance import link_gaps
from bath_drake.safety.obstacles import person_boxes
from bath_drake.scenario import load_scenario
from bath_drake.scene.obstacles import fixed_obstacles
from bath_drake.simulation import run
from bath_drake.strokes import scenario_skill
from bath_drake.systems import _joint_solver, obstacle_distance
from bath_drake.verification import evaluate, pose_from_row

LIMIT = GuardLimits().joints.obstacle_distance
# The wrist turned to the person's side: drawn to this, link 6 comes to the shoulder.
TURNED = [0.3, 0.944, -0.9, -2.318, -1.486, 2.242, 0.764]


def least_gap(log, scenario):
    """Of any link from the boxes where the person truly is, m."""
    arm = ArmModel.of(scenario.scene.arm)
    back = TrueSkin(load_person(scenario.scene.person)).canonical_map
    fixed = fixed_obstacles(scenario.scene)
    least = np.inf
    for pose, command in zip(log.body_pose[::5], log.checked_command[::5], strict=True):
        X = pose_from_row(pose).GetAsMatrix4()
        R, p = X[:3, :3], X[:3, 3]
        person = person_boxes(R @ back.R_WP, R @ back.p_WP + p, back.half_extents)
        boxes = person.seen_from(arm.X_WB) + fixed
        least = min(least, link_gaps(command[:7], arm.chain, boxes)[:, 0].min())
    return least


@pytest.mark.slow
@pytest.mark.parametrize(
    "watched", [pytest.param(False, marks=pytest.mark.exhaustive), True]
)
def test_a_wrist_that_would_come_to_the_shoulder_is_kept_off(watched, monkeypatch):
    scenario = load_scenario("reproduction")
    scenario.perception.source = "ideal"
    scenario.scene.arm.fidelity = "kinematic"
    scenario.scene.arm.posture = TURNED
    if not watched:
        monkeypatch.setattr(_joint_solver, "push_away", lambda r, c: np.zeros(7))
        monkeypatch.setattr(_joint_solver, "damped_share", lambda v, r, c: 1.0)
        monkeypatch.setattr(
            obstacle_distance, "obstacle_distance_ahead", lambda *_: 0.15
        )
    skill = scenario_skill(scenario)
    log = run(build_reproduction(scenario, skill), scenario)
    assert evaluate(log, scenario, skill).metrics["verdict"] == "pass"
    gap = least_gap(log, scenario)
    assert gap > LIMIT + 0.003 if watched else gap < 0.0
