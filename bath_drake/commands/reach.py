"""`bath-drake reach`: whether the arm gets all over the path, without a run."""

import argparse
from pathlib import Path

from bath_drake.commands._scenario import add_scenario_arguments, chosen_scenario
from bath_drake.errors import ScenarioError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Takes the scenario, what may stand in for its choices, and a folder."""
    add_scenario_arguments(parser)
    parser.add_argument(
        "--search", action="store_true", help="look for a better place of the base"
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="for reach.json, reach.svg and base.svg",
    )


def run(options: argparse.Namespace) -> int:
    """Returns 0 if the whole path is reached in every pose of the person, else 1."""
    from bath_drake.reach.precheck import reachability
    from bath_drake.report.reach_figures import write_reachability
    from bath_drake.run_folder import make_run_folder
    from bath_drake.strokes import scenario_skill

    scenario = chosen_scenario(options)
    if scenario.scene.carer is not None:
        raise ScenarioError(f"{options.scenario}: a carer washes here, no robot")
    skill = scenario_skill(scenario, options.skill)
    if options.out is not None:
        make_run_folder(options.out)
    found = reachability(
        scenario,
        skill,
        back=options.out is not None,
        search=options.search or None,
        floor=options.out is not None,
    )
    print("\n".join(found.lines()))
    if options.out is not None:
        for path in write_reachability(options.out, found):
            print(f"wrote:   {path}")
    return 0 if found.path.reached else 1
