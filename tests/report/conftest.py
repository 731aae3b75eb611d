from pathlib import Path

import pytest
from made_up_run import WOUND, write_run

from bath_drake.scenario import Scenario
from bath_drake.scene.config import WoundConfig


@pytest.fixture(scope="session")
def run_folder(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "reproduction"
    return write_run(folder, Scenario(description="A made-up run."))


@pytest.fixture(scope="session")
def wounded_run_folder(tmp_path_factory) -> Path:
    scenario = Scenario(description="A made-up run around a wound.")
    x, y, a, b, angle = WOUND
    scenario.scene.wound = WoundConfig(centre=[x, y], semi_axes=[a, b], angle=angle)
    scenario.limits.frechet_executed = None
    folder = tmp_path_factory.mktemp("runs") / "restricted_area"
    return write_run(folder, scenario)
