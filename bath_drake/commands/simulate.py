"""`bath-drake simulate`: a scenario, closed-loop, judged."""

import argparse
from pathlib import Path

from bath_drake.commands._scenario import add_scenario_arguments, chosen_scenario
from bath_drake.errors import ScenarioError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the scenario and what may stand in for its choices."""
    add_scenario_arguments(parser)
    parser.add_argument("--seconds", type=float, metavar="S", help="longest run")
    parser.add_argument("--meshcat", action="store_true", help="show it live")
    parser.add_argument(
        "--record", type=Path, metavar="FOLDER", help="the camera's frames, as RGB-D"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="the run's folder")


def run(options: argparse.Namespace) -> int:
    """Returns 0 if the verification passes, 1 if not; 0 if a carer was filmed."""
    from bath_drake.commands._options import record_and_report, run_and_report
    from bath_drake.scenario import check_scenario, find_scenario
    from bath_drake.strokes import scenario_skill

    scenario = chosen_scenario(options)
    if options.seconds is not None:
        scenario.duration = options.seconds
        try:
            check_scenario(scenario)
        except ValueError as error:
            raise ScenarioError(f"--seconds: {error}") from error
    if scenario.scene.carer is not None:
        _check_filming(options)
        return record_and_report(options.record, scenario)
    skill = scenario_skill(scenario, options.skill)
    folder = options.out or Path("runs") / find_scenario(options.scenario).stem
    return run_and_report(folder, scenario, skill, options.meshcat, options.record)


def _check_filming(options: argparse.Namespace) -> None:
    """A carer is filmed, and nothing else can be asked for."""
    if options.record is None:
        raise ScenarioError(
            f"{options.scenario}: a carer washes here, no robot; give --record FOLDER "
            "to film it"
        )
    for name in ("skill", "meshcat", "out"):
        if getattr(options, name):
            raise ScenarioError(
                f"{options.scenario}: a carer washes here, no robot; --{name} has no "
                "meaning"
            )
