"""What several verbs share: progress bars, a Meshcat, the end of a run."""

import contextlib
import logging
import sys
from collections.abc import Iterator
from pathlib import Path

from pydrake.geometry import Meshcat
from tqdm import tqdm

from bath_drake.learning.skill import Skill
from bath_drake.run_folder import (
    PAGE,
    REPORT,
    make_run_folder,
    simulate_into,
    verdict_lines,
)
from bath_drake.scenario import Scenario
from bath_drake.simulation import Progress


@contextlib.contextmanager
def simulation_bar(duration: float) -> Iterator[Progress]:
    """A bar of simulated seconds on a terminal; silent in a pipe."""
    bar = tqdm(
        total=duration,
        desc="simulating",
        disable=not sys.stderr.isatty(),
        bar_format="{desc} {bar} {n:.1f}/{total:.0f} s [{elapsed}]",
    )

    def progress(now: float, longest: float) -> None:
        bar.total = longest
        bar.n = min(now, longest)
        bar.refresh()

    with bar:
        yield progress


def run_and_report(folder: Path, scenario: Scenario, skill: Skill, live: bool) -> int:
    """Simulates into `folder`, prints the verdict; 0 if it passes, 1 if not."""
    make_run_folder(folder)
    # Drake sets its own level on import; the address is printed below if wanted.
    logging.getLogger("drake").setLevel(logging.WARNING)
    meshcat = Meshcat()
    if live:
        print(f"Meshcat: {meshcat.web_url()}", flush=True)
    with simulation_bar(scenario.duration) as progress:
        evaluation = simulate_into(
            folder, scenario, skill, meshcat=meshcat, progress=progress
        )
    print("\n".join(verdict_lines(evaluation.metrics)))
    print(f"report:  {folder / REPORT}\nmeshcat: {folder / PAGE}")
    if live:
        input("press Enter to close Meshcat ") if sys.stdin.isatty() else None
    return 0 if evaluation.metrics["verdict"] == "pass" else 1
