"""`bath-drake demo`: from demonstration files to a verified washing motion."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds where the run goes."""
    parser.add_argument(
        "--out", type=Path, default=Path("runs/demo"), metavar="DIR", help="its folder"
    )


def run(options: argparse.Namespace) -> int:
    """Returns 0 if the verification passes, 1 if not."""
    from bath_drake.commands import learn
    from bath_drake.commands._options import run_and_report
    from bath_drake.folder_lock import locked
    from bath_drake.run_folder import make_run_folder
    from bath_drake.scenario import find_demonstration, load_scenario
    from bath_drake.skill_file import load_skill

    scenario = load_scenario("reproduction")
    make_run_folder(options.out)
    skill_path = options.out / "learned_skill.yaml"
    files = [str(find_demonstration(name)) for name in scenario.demonstrations]
    words = [*files, "-o", str(skill_path), "--seed", str(scenario.random_seed)]
    if learn.checkpoint_path(skill_path).exists():
        words.append("--resume")  # the demo before was stopped while it learned
    parser = argparse.ArgumentParser()
    learn.add_arguments(parser)
    with locked(options.out):
        learned = learn.run(parser.parse_args(words))
    if learned != 0:
        return learned
    return run_and_report(options.out, scenario, load_skill(skill_path), live=False)
