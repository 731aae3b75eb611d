"""`bath-drake bench faults`: every row of the fault matrix, and what the guard did."""

import tempfile
from collections.abc import Sequence
from pathlib import Path

from bath_drake.benchmarks.figures import Figure, Progress, Report
from bath_drake.diagrams import build_reproduction
from bath_drake.errors import BathDrakeError
from bath_drake.faults.expectation import Expectation
from bath_drake.faults.touch import REACTION_S
from bath_drake.resources import diagrams_folder, models_folder
from bath_drake.scenario import find_skill, load_scenario
from bath_drake.simulation import run as simulate
from bath_drake.skill_file import load_skill
from bath_drake.verification import evaluate

Row = dict[str, str | float | bool]
DAMAGED_SKILL = 34


def fault_scenarios() -> list[Path]:
    """Returns the shipped scenarios with a fault each, in the order of their rows."""
    return sorted((diagrams_folder() / "faults").glob("*.yaml"))


def run(progress: Progress) -> Report:
    """Runs every row."""
    paths = fault_scenarios()
    rows = []
    for k, path in enumerate(paths):
        progress(path.stem, k / (len(paths) + 1))
        rows.append(fault_row(path))
    rows.append(damaged_skill_row())
    progress("done", 1.0)
    return Report(figures(rows), rows)


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Sums the rows up."""
    kept = sum(bool(row["as expected"]) for row in rows)
    # Of the others the fault itself takes a while to come up.
    sudden = [
        float(row["seconds"])
        for row in rows
        if row["expected"] in ("hold", "retreat", "stop") and row["sudden"]
    ]
    return [
        Figure("fault_rows", float(len(rows))),
        Figure("fault_rows_as_expected", float(kept), "", float(len(rows)), "at least"),
        Figure("fault_slowest_reaction", max(sudden), "s", REACTION_S),
    ]


def fault_row(path: Path) -> Row:
    """Runs one scenario with a fault, and says what the guard did.

    Raises:
        BathDrakeError: If the scenario has no `expect`.
    """
    scenario = load_scenario(path)
    expected = scenario.expect
    if expected is None:
        raise BathDrakeError(f"{path}: expect: is missing, expected a mapping")
    skill = load_skill(find_skill(scenario.skill))
    log = simulate(build_reproduction(scenario, skill), scenario)
    metrics = evaluate(log, scenario, skill).metrics
    found = metrics["reaction"]
    seconds = found["seconds"]
    return {
        **row_of(expected),
        "first reason": found["reason"] or "",
        "seconds": float("nan") if seconds is None else round(float(seconds), 3),
        "as expected": metrics["verdict"] == "pass",
    }


def row_of(expected: Expectation) -> Row:
    """Returns the columns that are written down before the run."""
    return {
        "row": float(expected.row),
        "fault": expected.fault,
        "expected": expected.reaction,
        "reasons": " or ".join(expected.reasons),
        "resumes": expected.resumes,
        "sudden": expected.within <= 0.1,
    }


def damaged_skill_row() -> Row:
    """A skill file whose content is another than was signed; nothing ever moves."""
    expected = Expectation(row=DAMAGED_SKILL, fault="skill file damaged")
    row = row_of(expected) | {"expected": "refused, exit code 2", "sudden": False}
    whole = (models_folder() / "skills" / "back_sinusoid.yaml").read_text("utf-8")
    with tempfile.TemporaryDirectory() as folder:
        damaged = Path(folder) / "skill.yaml"
        damaged.write_text(whole.replace("kappa: ", "kappa: 1", 1), "utf-8")
        try:
            load_skill(damaged)
        except BathDrakeError as error:
            told = str(damaged) in str(error)
        else:
            told = False
    return row | {"first reason": "", "seconds": 0.0, "as expected": told}
