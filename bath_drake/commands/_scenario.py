"""A scenario and what stands in for its choices, for the verbs that take one."""

import argparse
from pathlib import Path
from typing import Any

from bath_drake.patient.people import shipped_people


def add_scenario_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the scenario, `--skill` and `--person`."""
    parser.add_argument("scenario", metavar="SCENARIO.yaml")
    parser.add_argument("--skill", metavar="SKILL.yaml", help="instead of its own")
    parser.add_argument(
        "--person",
        metavar="DIR",
        help=f"a folder or a shipped name: {', '.join(shipped_people())}",
    )


def chosen_scenario(options: argparse.Namespace) -> Any:
    """Returns the Scenario, with the person that was asked for in it.

    Raises:
        ScenarioError: If there is none of that name, it is damaged, or its person is.
    """
    # Not before a verb runs: help is to be quick.
    from bath_drake.patient.people import find_person, load_person
    from bath_drake.scenario import load_scenario

    scenario = load_scenario(options.scenario)
    if options.person is not None:
        folder = find_person(options.person)
        # A path must mean the same when the report reads the run's folder.
        named = Path(options.person)
        scenario.scene.person = str(folder.resolve() if named.is_dir() else named)
    load_person(scenario.scene.person)
    return scenario
