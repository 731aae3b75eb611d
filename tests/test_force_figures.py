"""The force's figures, their checks and their picture, of a made-up run."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_run import make_log, make_skill

from bath_drake.control.approach import Phase
from bath_drake.report.force_figure import draw_force
from bath_drake.scenario import Limits, Scenario
from bath_drake.scene.config import ArmConfig
from bath_drake.verification import evaluate
from bath_drake.verification.force_figures import (
    force_figures,
    normal_force,
    stroke_samples,
)
from bath_drake.verification.limit_checks import limit_checks

SET = 4.0
NAMES = {
    "force_mean_error",
    "force_within_2_n",
    "force_peak",
    "force_contact_share",
    "approach_speed_m_per_s",
    "skin_speed_m_per_s",
    "touched_skin_mean_mm",
}


@pytest.fixture(scope="module")
def scenario():
    scenario = Scenario()
    scenario.scene.arm = ArmConfig(fidelity="contact", tool="sponge")
    return scenario


@pytest.fixture(scope="module")
def log(scenario):
    """Presses with 4.2 N wherever it washes, 0.6 N of it sideways besides."""
    log = make_log(scenario, images=False)
    wrench = np.zeros((len(log.time), 6))
    washing = log.phase == Phase.WASH
    wrench[washing, 5], wrench[washing, 3] = -4.2, 0.6
    return replace(log, contact_wrench=wrench, measured_wrench=wrench + 0.1)


def test_the_figures_are_those_of_the_stroke_alone(log):
    figures = force_figures(log, SET)
    assert figures["set"] == SET
    assert figures["mean"] == pytest.approx(4.2)
    assert figures["mean_error"] == pytest.approx(0.2)
    assert figures["within_2_n"] == figures["contact_share"] == 1.0
    # In any direction.
    assert figures["peak"] == pytest.approx(np.hypot(4.2, 0.6))


def test_a_break_in_the_stroke_is_part_of_it(log):
    first, last = np.flatnonzero(log.phase == Phase.WASH)[[0, -1]]
    lost = slice(first + 10, first + 10 + (last - first) // 10)
    phase, wrench = log.phase.copy(), log.contact_wrench.copy()
    phase[lost], wrench[lost] = Phase.DESCEND, 0.0
    broken = replace(log, phase=phase, contact_wrench=wrench)
    assert stroke_samples(broken)[lost].all()
    figures = force_figures(broken, SET)
    assert figures["contact_share"] == pytest.approx(0.9, abs=0.02)
    assert figures["within_2_n"] == figures["contact_share"]
    assert normal_force(broken)[lost].max() == 0.0


def test_without_a_stroke_nothing_is_told_of_it(log):
    never = replace(log, phase=np.zeros_like(log.phase))
    figures = force_figures(never, SET)
    told = {k: v for k, v in figures.items() if v is None}
    assert set(told) == {"mean", "mean_error", "within_2_n", "contact_share"}


def test_a_run_in_contact_is_judged_by_its_force(scenario, log):
    metrics = evaluate(log, scenario, make_skill(scenario)).metrics
    assert metrics["checks"].keys() >= NAMES
    assert metrics["standoff_or_force"]["mean"] == pytest.approx(4.2)
    assert metrics["touched_skin_mm"]["mean"] < 2.0
    metrics["force"]["within_2_n"], metrics["force"]["mean_error"] = 0.98, None
    failed = {
        k for k, c in limit_checks(metrics, Limits()).items() if not c["pass"]
    } & NAMES
    assert failed == {"force_within_2_n", "force_mean_error"}


def test_a_run_without_contact_has_no_force_to_judge():
    scenario = Scenario()
    metrics = evaluate(
        make_log(scenario, images=False), scenario, make_skill(scenario)
    ).metrics
    assert metrics["force"] is None
    assert not metrics["checks"].keys() & NAMES


def test_the_force_is_drawn_where_there_is_one(scenario, log):
    figure = draw_force(SimpleNamespace(scenario=scenario, log=log))
    upper, lower = figure.axes
    assert "force" in upper.get_ylabel()
    assert {line.get_label() for line in upper.lines} == {
        "measured",
        "true",
        "asked for",
    }
    assert upper.get_ylim()[1] > SET + 2.0
    assert len(lower.lines) == 1
    assert draw_force(SimpleNamespace(scenario=Scenario(), log=log)) is None
