"""Whole closed loops in contact: a sponge washes people who breathe and bend."""

from dataclasses import replace

import numpy as np
import pytest

from bath_drake.control.approach import Phase
from bath_drake.diagrams import build_reproduction, control
from bath_drake.patient.motion import DepartureConfig
from bath_drake.patient.people import shipped_people
from bath_drake.safety.reasons import Mode, Reason
from bath_drake.scenario import find_skill, load_scenario
from bath_drake.simulation import run
from bath_drake.skill_file import load_skill
from bath_drake.verification import evaluate
from bath_drake.verification.force_figures import normal_force, stroke_samples


def washed(scenario):
    skill = load_skill(find_skill(scenario.skill))
    log = run(build_reproduction(scenario, skill), scenario)
    return log, evaluate(log, scenario, skill)


# The stoutest; all the others by `make test MARKERS=`.
PEOPLE = ["m_heavy"]
PEOPLE += [
    pytest.param(name, marks=pytest.mark.exhaustive)
    for name in shipped_people()
    if name not in PEOPLE
]


@pytest.fixture(scope="module", params=PEOPLE)
def judged(request):
    scenario = load_scenario("wash_contact")
    scenario.scene.person = request.param
    return scenario, *washed(scenario)


@pytest.mark.slow
def test_the_run_in_contact_passes_its_verification(judged):
    _, log, evaluation = judged
    failed = {k: c for k, c in evaluation.metrics["checks"].items() if not c["pass"]}
    assert failed == {}
    assert log.outcome == "GOAL_REACHED"
    assert not log.guard_mode[log.time > 0.5].any()


@pytest.mark.slow
def test_the_force_is_as_asked_for(judged):
    scenario, log, evaluation = judged
    force = evaluation.metrics["force"]
    assert force["set"] == scenario.control.force == 4.0
    assert force["mean_error"] <= 0.5
    assert force["within_2_n"] >= 0.99
    assert force["peak"] <= 10.0
    assert force["contact_share"] >= 0.98
    assert evaluation.metrics["standoff_or_force"]["mean"] == pytest.approx(
        force["mean"], abs=0.01
    )
    # The sensor's bias and noise are between the two: a few tenths of a newton.
    measured = -log.measured_wrench[:, 5]
    assert np.abs(measured - normal_force(log))[stroke_samples(log)].mean() < 0.5


@pytest.mark.slow
def test_the_tool_comes_down_before_it_is_felt_and_washes_after(judged):
    _, log, evaluation = judged
    first = int(np.argmax(log.phase == Phase.WASH))
    touched = int(np.argmax(normal_force(log) > 0.05))
    assert 0 < touched < first
    before = log.canonical_reference[:first]
    np.testing.assert_array_equal(before, np.tile(before[0], (first, 1)))
    assert evaluation.metrics["force"]["approach_speed_m_per_s"] <= 0.05


@pytest.mark.slow
def test_the_touched_skin_is_the_true_one_within_two_millimetres(judged):
    assert judged[2].metrics["touched_skin_mm"]["mean"] <= 2.0


def shoved(speed):
    """Log and evaluation of a person who moves backwards, out of the blue.

    Faster than the nozzle may follow; nor does the monitor end the run before the
    sponge is pressed flat.
    """
    scenario = load_scenario("wash_contact")
    scenario.duration = 11.0
    scenario.control.min_clearance = 0.005
    scenario.scene.motion.departure = DepartureConfig(
        begin=9.5, seconds=0.35, velocity=[0.0, speed, 0.0]
    )
    log, evaluation = washed(scenario)
    first = int(np.argmax(log.guard_mode >= Mode.RETREAT))
    assert 9.5 < log.time[first] < 10.0
    # From then on it is away, as far as the others know, and nothing is washed.
    assert (log.phase[first + 2 :] != Phase.WASH).all()
    assert (log.guard_mode[first:] >= Mode.HOLD).all()
    assert evaluation.metrics["verdict"] == "fail"
    return log, first


@pytest.mark.slow
def test_skin_that_comes_nearer_makes_the_guard_retreat_below_its_force_limit():
    log, first = shoved(0.2)
    assert log.guard_reason[first] == Reason.SKIN_NEAR
    size = np.linalg.norm(log.measured_wrench[:, 3:], axis=1)
    assert size.max() < 15.0


@pytest.mark.slow
@pytest.mark.exhaustive
def test_force_alone_makes_the_guard_retreat_as_well(monkeypatch):
    limits = control.guard_limits

    def without_clearance(scenario):
        found = limits(scenario)
        return replace(found, nozzle=replace(found.nozzle, clearance=0.0))

    monkeypatch.setattr(control, "guard_limits", without_clearance)
    log, first = shoved(0.3)
    size = np.linalg.norm(log.measured_wrench[:, 3:], axis=1)
    felt = log.time[np.argmax(size > 15.0)]
    assert log.guard_reason[first] in (Reason.FORCE_HIGH, Reason.FORCE_STOP)
    # A tick of the sensor, one of the guard and one of the log.
    assert log.time[first] - felt <= 0.02
