"""`bath-drake bench washing`: pouring, a whole back and contact, on everybody.

Each scenario as it ships: `pour` and `coverage` through the camera, with an arm driven
by torques, `wash_contact` with ideal perception; and `wash_contact_seen`, the same
through the camera. With `--quick` the first two have ideal perception and an arm that
follows exactly, and the last is left out: the control alone, in a third of the time.
One process a person.
"""

import os
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Any, Literal

import numpy as np

from bath_drake.benchmarks.figures import Figure, Progress, Report, Settings
from bath_drake.diagrams import build_reproduction
from bath_drake.patient.people import shipped_people
from bath_drake.scenario import load_scenario
from bath_drake.simulation import run as simulate
from bath_drake.strokes import scenario_skill
from bath_drake.verification import evaluate

SCENARIOS = ("pour", "coverage", "wash_contact")
# `wash_contact` through the camera.
SEEN = "wash_contact_seen"
Row = dict[str, str | float | bool]
Bound = Literal["at most", "at least"]
# Figure: scenario and column, unit, target and on which side of it.
ASKED: dict[str, tuple[str, str, str, float, Bound]] = {
    "pour_coverage": ("pour", "coverage", "", 0.95, "at least"),
    "coverage_share": ("coverage", "coverage", "", 0.95, "at least"),
    "coverage_wound_wetted": ("coverage", "wound wetted, cm2", "cm2", 0.0, "at most"),
    "coverage_entries": ("coverage", "entries", "", 0.0, "at most"),
    "contact_force_error": ("wash_contact", "error, N", "N", 0.5, "at most"),
    "contact_within_2_n": ("wash_contact", "within 2 N", "", 0.99, "at least"),
    "contact_peak": ("wash_contact", "peak, N", "N", 10.0, "at most"),
    "contact_share": ("wash_contact", "contact", "", 0.98, "at least"),
    "contact_touched_skin": ("wash_contact", "touched skin, mm", "mm", 2.0, "at most"),
    "contact_speed": ("wash_contact", "speed, m/s", "m/s", 0.10, "at most"),
    "seen_force_error": (SEEN, "error, N", "N", 0.5, "at most"),
    "seen_within_2_n": (SEEN, "within 2 N", "", 0.99, "at least"),
    "seen_peak": (SEEN, "peak, N", "N", 10.0, "at most"),
    "seen_contact_share": (SEEN, "contact", "", 0.98, "at least"),
}


def run(settings: Settings, progress: Progress) -> Report:
    """Washes everybody."""
    people = list(shipped_people())
    found: dict[str, list[Row]] = {}
    with ProcessPoolExecutor(
        max_workers=max(1, min(os.cpu_count() or 1, len(people))),
        # Some versions of Drake free no Diagram with Systems written in Python.
        mp_context=get_context("spawn"),
        max_tasks_per_child=1,
    ) as pool:
        started = {
            pool.submit(washed, person, settings.quick): person for person in people
        }
        for k, done in enumerate(as_completed(started)):
            found[started[done]] = done.result()
            progress("washing", (k + 1) / len(people))
    rows = [row for person in people for row in found[person]]
    rows.sort(key=lambda row: (*SCENARIOS, SEEN).index(str(row["scenario"])))
    return Report(figures(rows), rows)


def washed(person: str, quick: bool) -> list[Row]:
    """Runs each scenario on one person."""
    names = SCENARIOS if quick else (*SCENARIOS, SEEN)
    return [wash_row(name, person, quick=quick) for name in names]


def wash_row(name: str, person: str, *, quick: bool) -> Row:
    """Runs one scenario; returns what came of it, lengths in mm and areas in cm²."""
    scenario = load_scenario(name.removesuffix("_seen"))
    scenario.scene.person = person
    if name == SEEN:
        scenario.perception.source = "camera"
    elif quick and name != "wash_contact":
        scenario.perception.source = "ideal"
        scenario.scene.arm.fidelity = "kinematic"
    skill = scenario_skill(scenario)
    log = simulate(build_reproduction(scenario, skill), scenario)
    metrics = evaluate(log, scenario, skill).metrics
    return row_of(name, person, metrics)


def row_of(name: str, person: str, metrics: dict[str, Any]) -> Row:
    """Returns a run's row of the table; NaN where there is no figure."""
    force, touched = metrics["force"] or {}, metrics["touched_skin_mm"] or {}
    told: dict[str, Any] = {
        "coverage": metrics["coverage"],
        "target, cm2": metrics["washing"]["target_cm2"],
        "wound wetted, cm2": metrics["washing"]["wound_wetted_cm2"],
        "entries": metrics["restricted_entries"],
        "seconds": metrics["time_to_goal_s"],
        "force, N": force.get("mean"),
        "error, N": force.get("mean_error"),
        "within 2 N": force.get("within_2_n"),
        "peak, N": force.get("peak"),
        "contact": force.get("contact_share"),
        "touched skin, mm": touched.get("mean"),
        "speed, m/s": metrics["speed_m_per_s"]["max"],
    }
    values = {
        key: float("nan") if value is None else round(float(value), 4)
        for key, value in told.items()
    }
    passed = metrics["verdict"] == "pass"
    return {"scenario": name, "person": person, "passed": passed, **values}


def figures(rows: list[Row]) -> list[Figure]:
    """Sums the rows up: how many passed, and of each figure the worst."""
    people = float(len({row["person"] for row in rows}))
    run_names = {str(row["scenario"]) for row in rows}
    passed = {
        name: sum(bool(row["passed"]) for row in rows if row["scenario"] == name)
        for name in (*SCENARIOS, SEEN)
        if name in run_names
    }
    found = [
        Figure(f"{name}_passed", float(count), "", people, "at least")
        for name, count in passed.items()
    ]
    for figure, (name, key, unit, target, bound) in ASKED.items():
        if name not in run_names:
            continue
        # NumPy's: a figure that is missing is the worst.
        worst = np.max if bound == "at most" else np.min
        values = [float(row[key]) for row in rows if row["scenario"] == name]
        found.append(Figure(figure, float(worst(values)), unit, target, bound))
    return found
