"""The built wheel works outside a checkout: models and scenarios are inside it."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder]
    subprocess.run(command, cwd=CHECKOUT, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    site = folder / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    return site


def test_the_wheel_carries_models_and_scenarios_but_no_tests(unpacked):
    data = unpacked / "bath_drake" / "_data"
    assert (data / "models" / "people" / "m_avg" / "mesh.npz").is_file()
    assert (data / "diagrams" / "reproduction.yaml").is_file()
    assert not (unpacked / "tests").exists()
    assert not (unpacked / "tutorials").exists()


def test_a_scenario_loads_from_the_wheel_alone(unpacked, tmp_path):
    program = (
        "import bath_drake.resources as r, bath_drake.scenario as s;"
        "from bath_drake.patient.people import load_person;"
        "print(r.models_folder()); load_person(s.load_scenario('reproduction')"
        ".scene.person)"
    )
    # -I leaves out the current folder and PYTHONPATH; the wheel goes first.
    done = subprocess.run(
        [
            sys.executable,
            "-I",
            "-c",
            f"import sys; sys.path.insert(0, {str(unpacked)!r});{program}",
        ],
        cwd=tmp_path,
        check=True,
        capture_output=True,
        text=True,
    )
    assert done.stdout.strip() == str(unpacked / "bath_drake" / "_data" / "models")
