"""`bath-drake diagram`."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Takes the scenario and where to draw."""
    parser.add_argument("scenario", metavar="SCENARIO.yaml")
    parser.add_argument(
        "-o", "--out", type=Path, metavar="FILE.svg", help="default: SCENARIO.svg here"
    )


def run(options: argparse.Namespace) -> int:
    """Draws the scenario's Diagram, prints the file's path; returns 0."""
    from bath_drake.diagrams import build_reproduction
    from bath_drake.diagrams.block_diagram import draw_block_diagram
    from bath_drake.diagrams.recording import build_recording
    from bath_drake.errors import ScenarioError
    from bath_drake.files import check_output, write_atomically
    from bath_drake.scenario import find_scenario, load_scenario
    from bath_drake.strokes import scenario_skill

    source = find_scenario(options.scenario)
    path = options.out or Path(f"{source.stem}.svg")
    check_output(path, error=ScenarioError)
    scenario = load_scenario(source)
    if scenario.scene.carer is not None:
        diagram = build_recording(scenario).diagram
    else:
        diagram = build_reproduction(scenario, scenario_skill(scenario))
    write_atomically(path, draw_block_diagram(diagram), error=ScenarioError)
    print(path)
    return 0
