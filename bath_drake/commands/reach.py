"""`bath-drake reach`: whether the arm gets all over the path, without a run."""

import argparse
from pathlib import Path

from bath_drake.errors import ScenarioError
from bath_drake.patient.people import shipped_people


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Takes the scenario, what may stand in for its choices, and a folder."""
    parser.add_argument("scenario", metavar="SCENARIO.yaml")
    parser.add_argument("--skill", metavar="SKILL.yaml", help="instead of its own")
    parser.add_argument(
        "--person",
        metavar="DIR",
        help=f"a folder or a shipped name: {', '.join(shipped_people())}",
    )
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
    from bath_drake.scenario import find_scenario, find_skill, load_scenario
    from bath_drake.skill_file import load_skill

    scenario = load_scenario(find_scenario(options.scenario))
    if options.person is not None:
        scenario.scene.person = options.person
    if scenario.scene.carer is not None:
        raise ScenarioError(f"{options.scenario}: a carer washes here, no robot")
    skill = load_skill(find_skill(options.skill or scenario.skill))
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
