"""The built wheel works outside a checkout: models and scenarios are inside it."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from made_up_run import write_run

from bath_drake.scenario import Scenario

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


def run_from(site, program, folder):
    """What a program prints that finds the package in the wheel alone."""
    # -I leaves out the current folder and PYTHONPATH; the wheel goes first.
    program = f"import sys; sys.path.insert(0, {str(site)!r});{program}"
    done = subprocess.run(
        [sys.executable, "-I", "-c", program],
        cwd=folder,
        check=True,
        capture_output=True,
        text=True,
    )
    return done.stdout.strip()


def test_a_scenario_loads_from_the_wheel_alone(unpacked, tmp_path):
    program = (
        "import bath_drake.resources as r, bath_drake.scenario as s;"
        "from bath_drake.patient.people import load_person;"
        "print(r.models_folder()); load_person(s.load_scenario('reproduction')"
        ".scene.person)"
    )
    found = run_from(unpacked, program, tmp_path)
    assert found == str(unpacked / "bath_drake" / "_data" / "models")


def test_the_wheel_carries_the_reports_templates(unpacked, tmp_path):
    shipped = CHECKOUT / "bath_drake" / "report" / "templates"
    program = (
        "import jinja2;"
        "print(*jinja2.PackageLoader('bath_drake.report').list_templates())"
    )
    names = run_from(unpacked, program, tmp_path).split()
    assert sorted(names) == sorted(path.name for path in shipped.iterdir())


@pytest.mark.exhaustive  # kernels are compiled anew: no cache is in a wheel
def test_a_report_is_written_from_the_wheel_alone(unpacked, tmp_path):
    folder = write_run(tmp_path / "run", Scenario(description="A made-up run."))
    program = (
        "import pathlib; from bath_drake.report.page import write_report;"
        f"print(write_report(pathlib.Path({str(folder)!r})))"
    )
    assert run_from(unpacked, program, tmp_path) == str(folder / "report.html")
    assert "A made-up run." in (folder / "report.html").read_text(encoding="utf-8")
