"""Compiles what takes longest to compile, before the tests' processes do so each.

    python tests/compile_kernels.py learning
    python tests/compile_kernels.py loop

numba keeps what it compiled beside the modules: where all is there already, both are
done within seconds.
"""

import contextlib
import io
import logging
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from bath_drake.cli import main
from bath_drake.diagrams import build_reproduction
from bath_drake.resources import models_folder
from bath_drake.scenario import find_skill, load_scenario
from bath_drake.simulation import run
from bath_drake.skill_file import load_skill


def learn(folder: Path) -> None:
    """Learns a short skill: fits, roll-outs, Frechet distances."""
    stroke = str(models_folder() / "demonstrations" / "back_sinusoid_1.csv")
    effort = ["--quick", "--obstacles", "2", "--pictures", "one"]
    main(["learn", stroke, "-o", str(folder / "skill.yaml"), *effort])


def wash(folder: Path) -> None:
    """Proves a skill, sees a wound and begins to wash round it."""
    scenario = load_scenario("restricted_area")
    scenario.duration = 0.2
    path = find_skill(scenario.skill)
    # First, so that it is there when what was learned is to be proved.
    main(["certify", str(path)])
    main(["reach", "reproduction", "--out", str(folder)])
    run(build_reproduction(scenario, load_skill(path)), scenario)


PARTS = {"learning": learn, "loop": wash}

if __name__ == "__main__":
    logging.getLogger("drake").setLevel(logging.WARNING)
    with TemporaryDirectory() as name, contextlib.redirect_stdout(io.StringIO()):
        for part in sys.argv[1:]:
            PARTS[part](Path(name))
