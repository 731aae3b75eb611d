"""A made-up run is perfect but for one defect: exactly its own check must fail."""

import json
from dataclasses import replace

import numpy as np
import pytest
from made_up_run import PROMISED_METRICS, make_log, make_skill
from made_up_skill import with_branch
from pydrake.common.eigen_geometry import Quaternion

from bath_drake.control.approach import Phase
from bath_drake.control.certified_world import WorldVerdict
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.field.parameters import pack_field
from bath_drake.field.rollout import RolloutStatus, rollout
from bath_drake.patient.people import load_person
from bath_drake.safety.reasons import Mode
from bath_drake.scenario import Scenario
from bath_drake.scene.config import WoundConfig
from bath_drake.verification import evaluate, pose_from_row, versions, wound_outlines


@pytest.fixture(scope="module")
def skill():
    """A skill straight across the back; its demonstrations are its own roll-out."""
    made_up = make_skill(Scenario())
    field = replace(made_up.field, obstacles=ObstacleSet())
    rolled = rollout(made_up.start, field)
    assert rolled.status is RolloutStatus.ARRIVED
    return with_branch(made_up, field=field, mean=rolled.path)


@pytest.fixture(scope="module")
def make(skill):
    """Makes the log of a run along the skill's path, without small errors."""

    def made(scenario=None, *, up=0.0, **defects):
        path = skill.mean_demonstration + np.array([0.0, up])
        log = make_log(
            scenario or Scenario(), path=path, noise=0.0, images=False, **defects
        )
        return driven_in(log, skill.field)

    return made


@pytest.fixture(scope="module")
def perfect(make):
    return make()


def driven_in(log, world):
    rows = np.stack([pack_field(world, 4)] * len(log.keyframe_time))
    return replace(log, keyframe_world=rows, worlds=rows[:1])


def failed(log, skill, scenario=None):
    metrics = evaluate(log, scenario or Scenario(), skill).metrics
    names = {name for name, check in metrics["checks"].items() if not check["pass"]}
    assert metrics["verdict"] == ("fail" if names else "pass")
    # Strict JSON all the same.
    json.dumps(metrics, allow_nan=False)
    return names


def wounded(centre):
    scenario = Scenario()
    scenario.scene.wound = WoundConfig(centre=list(centre), semi_axes=[0.15, 0.1])
    return scenario


def test_a_perfect_run_passes_with_figures_near_zero(perfect, skill):
    evaluation = evaluate(perfect, Scenario(), skill)
    metrics = evaluation.metrics
    assert metrics["verdict"] == "pass"
    assert all(check["pass"] for check in metrics["checks"].values())
    assert metrics["checks"].keys() >= {"reached_goal", "frechet_executed"}
    # The nearest skin of a point on a normal may be a neighbouring triangle's.
    assert metrics["surface_error_mm"]["max"] < 1.0
    assert metrics["normal_error_deg"]["mean"] < 1.0
    # Samples of the log are up to 0.02 apart along the path.
    assert metrics["frechet"]["executed"] < 0.02
    assert metrics["frechet"]["learned"] == 0.0
    assert metrics["restricted_min_clearance_mm"] is None
    assert metrics["standoff_or_force"]["mean"] == pytest.approx(0.06, abs=1e-3)


def test_the_metrics_are_all_that_is_promised(perfect, skill):
    metrics = evaluate(perfect, Scenario(random_seed=5), skill).metrics
    assert metrics.keys() >= PROMISED_METRICS
    assert metrics["seed"] == 5
    assert metrics["frechet"].keys() >= {"learned", "executed"}
    for name in ("surface_error_mm", "normal_error_deg", "standoff_or_force"):
        assert metrics[name].keys() == {"mean", "max"}
    for check in metrics["checks"].values():
        assert check.keys() == {"value", "limit", "pass"}
    assert metrics["versions"] == versions()
    assert metrics["holds"]["body_lost"] == 1


def test_the_errors_run_from_the_first_standoff(perfect, skill):
    evaluation = evaluate(perfect, Scenario(), skill)
    first = perfect.time[perfect.phase == Phase.WASH][0]
    assert evaluation.time[0] == first
    assert evaluation.time[-1] == perfect.time[-1]
    # A wild approach is none of its business.
    poses = perfect.nozzle_pose.copy()
    poses[perfect.phase != Phase.WASH, 4:] += 0.5
    wild = replace(perfect, nozzle_pose=poses)
    assert evaluate(wild, Scenario(), skill).metrics == evaluation.metrics


def test_a_jet_over_its_stroke_covers_it_and_one_beside_it_does_not(make, skill):
    scenario = Scenario()
    scenario.limits.coverage = 0.95
    assert failed(make(), skill, scenario) == set()
    assert evaluate(make(), scenario, skill).metrics["coverage"] == 1.0
    # A tenth beside it is 24 mm: a third of the band and more stays dry.
    beside = make(up=0.1)
    metrics = evaluate(beside, scenario, skill).metrics
    assert 0.3 < metrics["coverage"] < 0.75
    assert "coverage" in failed(beside, skill, scenario)


def test_water_on_a_wound_fails_only_where_it_is_limited(make, skill):
    scenario = wounded([0.2, 0.2])
    log = make(scenario)
    wetted = evaluate(log, scenario, skill).metrics["washing"]["wound_wetted_cm2"]
    # The jet's axis keeps off, the jet does not.
    assert "restricted_entries" not in failed(log, skill, scenario)
    assert wetted > 1.0
    scenario.limits.wound_wetted_cm2 = 0.5
    assert "wound_wetted_cm2" in failed(log, skill, scenario)


@pytest.mark.parametrize("error", [0.006, -0.006])
def test_six_millimetres_off_the_standoff_fail(make, skill, error):
    log = make(standoff_error=error)
    assert failed(log, skill) == {"surface_error_mean_mm"}
    figures = evaluate(log, Scenario(), skill).metrics["surface_error_mm"]
    assert figures["mean"] == pytest.approx(6.0, abs=0.5)


def test_sixteen_millimetres_for_a_moment_fail(perfect, skill):
    poses = perfect.nozzle_pose.copy()
    X_WE = pose_from_row(poses[200])
    poses[200, 4:] -= 0.016 * X_WE.rotation().col(2)
    log = replace(perfect, nozzle_pose=poses)
    assert failed(log, skill) == {"surface_error_max_mm"}


def test_six_degrees_of_tilt_fail(make, skill):
    log = make(tilt=np.radians(6.0))
    assert failed(log, skill) == {"normal_error_mean_deg"}
    figures = evaluate(log, Scenario(), skill).metrics["normal_error_deg"]
    assert figures["mean"] == pytest.approx(6.0, abs=0.5)


def test_a_path_a_tenth_off_fails(make, skill):
    log = make(up=0.1 * skill.scale)
    assert failed(log, skill) == {"frechet_executed"}
    executed = evaluate(log, Scenario(), skill).metrics["frechet"]["executed"]
    # The sampling of both paths, as above.
    assert executed == pytest.approx(0.1, abs=0.02)


def test_a_skill_a_tenth_off_its_demonstrations_fails(make, skill):
    up = 0.11 * skill.scale
    moved = skill.mean_demonstration + np.array([0.0, up])
    other = with_branch(skill, mean=moved)
    assert failed(make(up=up), other) == {"frechet_learned"}


def test_the_goal_missed_fails(perfect, skill):
    for outcome in ("TIMED_OUT", "TOO_CLOSE"):
        assert failed(replace(perfect, outcome=outcome), skill) == {"reached_goal"}


def test_a_way_through_the_wound_fails_and_counts_once(make, skill):
    middle = skill.mean_demonstration[len(skill.mean_demonstration) // 2]
    scenario = wounded(middle)
    log = make(scenario)
    assert failed(log, skill, scenario) == {"restricted_entries"}
    evaluation = evaluate(log, scenario, skill)
    assert evaluation.metrics["restricted_entries"] == 1
    assert evaluation.metrics["restricted_min_clearance_mm"] < 0.0


def test_a_way_past_the_wound_passes_with_its_clearance(make, skill):
    beside = skill.mean_demonstration[len(skill.mean_demonstration) // 2] + [0.0, 0.45]
    scenario = wounded(beside)
    evaluation = evaluate(make(scenario), scenario, skill)
    assert evaluation.metrics["verdict"] == "pass"
    assert evaluation.metrics["restricted_entries"] == 0
    (outline,) = evaluation.wound_polygons_N
    half = np.array([0.18, 0.24])  # m, about a back's
    gaps = (evaluation.executed[:, None] - outline) * half
    nearest = 1e3 * np.linalg.norm(gaps, axis=2).min()
    # People differ from the half extents above by a quarter.
    assert evaluation.metrics["restricted_min_clearance_mm"] == pytest.approx(
        nearest, rel=0.3
    )


def test_a_jet_beside_the_body_fails(perfect, skill):
    poses = perfect.nozzle_pose.copy()
    X_WE = pose_from_row(poses[200])
    # Half a turn about its own x axis: one sample washes the room.
    half_turn = Quaternion([0.0, 1.0, 0.0, 0.0])
    poses[200, :4] = X_WE.rotation().ToQuaternion().multiply(half_turn).wxyz()
    log = replace(perfect, nozzle_pose=poses)
    assert failed(log, skill) == {"washed_off_the_body"}


def test_a_world_whose_goal_is_covered_is_refuted(perfect, skill):
    cover = np.array([[*skill.field.goal, 0.2, 0.2, 0.0]])
    world = skill.field.with_obstacles(ObstacleSet(cover))
    log = driven_in(perfect, world)
    assert failed(log, skill) == {"certificate"}


def test_a_world_that_traps_elsewhere_passes_by_the_proof_of_its_start(perfect, skill):
    # Broadside to the goal, beside the way: what starts behind it is trapped.
    wall = np.array([[-0.9, 0.75, 0.04, 0.35, 0.0]])
    log = driven_in(perfect, skill.field.with_obstacles(ObstacleSet(wall)))
    assert failed(log, skill) == set()
    certificate = evaluate(log, Scenario(), skill).metrics["certificate"]
    assert certificate["verdict"] == "proved"
    assert certificate["covers"] == "this start"


def test_a_move_without_proof_fails_and_a_hold_without_proof_does_not(perfect, skill):
    moving = perfect.guard_mode == Mode.PASS
    for samples, names in ((moving, {"moved_unproved"}), (~moving, set())):
        k = np.flatnonzero(samples)[3]
        verdict = perfect.certificate_verdict.copy()
        verdict[k] = WorldVerdict.REFUTED
        assert failed(replace(perfect, certificate_verdict=verdict), skill) == names


def test_beta_is_told_of_the_washed_point_and_of_where_the_field_is_asked(
    perfect, skill
):
    aside = np.array([[0.0, 0.8, 0.05, 0.05, 0.0]])
    perfect = driven_in(perfect, skill.field.with_obstacles(ObstacleSet(aside)))
    inside = aside[0, :2]
    betas = []
    for name in ("canonical_position", "canonical_reference"):
        moved = getattr(perfect, name).copy()
        moved[np.searchsorted(perfect.time, 10.0)] = inside
        metrics = evaluate(replace(perfect, **{name: moved}), Scenario(), skill).metrics
        betas.append((metrics["min_beta"], metrics["min_beta_reference"]))
    (washed, free), (also_free, asked) = betas
    # In the middle of an ellipse its beta is -1.
    assert washed == pytest.approx(-1.0)
    assert asked == pytest.approx(-1.0)
    assert min(free, also_free) > 0.0


def test_what_two_of_the_guards_limits_are_about_is_told_at_its_worst(perfect, skill):
    state = perfect.checked_command.copy()
    state[7, 3] -= 0.004
    state[9, 10] += 1.0  # a velocity
    seen = np.zeros(len(state))
    seen[5] = 0.012
    log = replace(perfect, arm_state=state, seen_through=seen)
    metrics = evaluate(log, Scenario(), skill).metrics
    assert metrics["following_error_rad"] == pytest.approx(0.004)
    assert metrics["seen_through"] == 0.012


def test_every_proof_of_the_run_is_counted_with_its_time(perfect, skill):
    certificate = evaluate(perfect, Scenario(), skill).metrics["certificate"]
    assert certificate["proofs"] == 2
    assert certificate["proof_seconds"] == {"mean": 0.005, "max": 0.006}
    unknown = np.full_like(perfect.certificate_verdict, WorldVerdict.UNKNOWN)
    log = replace(perfect, certificate_verdict=unknown)
    certificate = evaluate(log, Scenario(), skill).metrics["certificate"]
    assert certificate["proofs"] == 0
    assert certificate["proof_seconds"] == {"mean": None, "max": None}


def test_a_run_that_never_washed_fails_without_a_number(perfect, skill):
    log = replace(perfect, phase=np.zeros_like(perfect.phase), outcome="TIMED_OUT")
    names = failed(log, skill)
    assert names == {
        "reached_goal",
        "frechet_executed",
        "surface_error_mean_mm",
        "surface_error_max_mm",
        "normal_error_mean_deg",
    }


def test_a_limit_of_null_asks_for_the_figure_alone(make, skill):
    scenario = Scenario()
    scenario.limits.frechet_executed = None
    log = make(up=0.1 * skill.scale)
    assert failed(log, skill, scenario) == set()
    metrics = evaluate(log, scenario, skill).metrics
    assert "frechet_executed" not in metrics["checks"]
    assert metrics["frechet"]["executed"] > 0.08


def test_the_verdict_knows_the_body_where_it_truly_was(perfect, skill):
    """Nozzle and body moved alike is the same run; the body alone is not."""
    shift = np.array([0.05, -0.03, 0.02])
    body, nozzle = perfect.body_pose.copy(), perfect.nozzle_pose.copy()
    body[:, 4:] += shift
    nozzle[:, 4:] += shift
    together = evaluate(
        replace(perfect, body_pose=body, nozzle_pose=nozzle), Scenario(), skill
    ).metrics
    alone = evaluate(replace(perfect, body_pose=body), Scenario(), skill).metrics
    assert together["verdict"] == "pass"
    assert alone["verdict"] == "fail"


def test_wounds_are_outlined_on_the_skin_only_where_there_are_any():
    person = load_person("m_avg")
    assert wound_outlines(Scenario(), person) == []
    (outline,) = wound_outlines(wounded([0.2, 0.0]), person)
    assert outline.shape[1] == 3
