import json
import re
import shutil
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from bath_drake.cli import main
from bath_drake.errors import RunFolderError
from bath_drake.report import style
from bath_drake.report.page import render_report, write_report
from bath_drake.report.run_data import load_run
from bath_drake.simulation_log import SimulationLog


class _Page(HTMLParser):
    """Tags with their attributes, and the text."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.text = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_data(self, data):
        self.text.append(data)


@pytest.fixture(scope="module")
def page_text(run_folder):
    return write_report(run_folder).read_text()


@pytest.fixture(scope="module")
def page(page_text):
    return _Page(page_text)


@pytest.fixture(scope="module")
def wounded_page(wounded_run_folder):
    """Its figures are drawn, but not saved: what a saved one is like `page` shows."""
    (wounded_run_folder / "meshcat.html").write_text("a scene")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "as_data_uri", lambda figure, raster: "data:image/png,")
        return _Page(write_report(wounded_run_folder).read_text())


@pytest.fixture
def copy(run_folder, tmp_path):
    return shutil.copytree(run_folder, tmp_path / "copy")


def _figures(page):
    return [a["alt"] for tag, a in page.tags if tag == "img"]


def test_the_page_loads_nothing_and_runs_nothing(page, page_text):
    assert not {tag for tag, _ in page.tags} & {"script", "link", "iframe", "object"}
    sources = [a[k] for _, a in page.tags for k in ("src", "href") if k in a]
    assert sources
    assert all(source.startswith("data:image/") for source in sources)
    assert not re.search(r"@import|url\((?!#)", page_text)


def test_every_figure_of_a_plain_run_is_there_with_a_text(page):
    assert len(_figures(page)) == 10
    assert all(_figures(page))


def test_a_wound_adds_its_clearance(page, wounded_page):
    assert set(_figures(wounded_page)) - set(_figures(page)) == {
        "Clearance from the wound over time"
    }


@pytest.mark.exhaustive
def test_the_command_prints_the_path_of_the_same_page(run_folder, page_text, capsys):
    assert main(["report", str(run_folder)]) == 0
    path = run_folder / "report.html"
    assert capsys.readouterr().out.strip() == str(path)
    assert path.read_text() == page_text


def test_the_page_states_verdict_limits_of_use_and_rigidity(run_folder, page):
    text = " ".join(" ".join(page.text).split())
    verdict = json.loads((run_folder / "metrics.json").read_text())["verdict"]
    assert verdict.upper() in text
    assert "not certified, not for use on people" in text
    assert "The person is rigid in this run" in text
    assert "without noise" in text


@pytest.mark.exhaustive
@pytest.mark.usefixtures("unsaved_figures")
def test_the_page_of_a_bending_person_before_a_noisy_camera_says_so(run_folder):
    run = load_run(run_folder)
    run.scenario.scene.motion.flexion_amplitude = 0.05
    run.scenario.scene.camera.noise = "kinect_v2"
    text = render_report(run)
    assert "skin bends in this run" in text
    assert "The person is rigid" not in text
    assert "kinect_v2 noise" in text


def test_the_page_says_what_is_proved_and_what_a_proof_does_not_cover(page):
    text = " ".join(" ".join(page.text).split())
    assert "Proved: " in text
    assert "Almost every start in free space reaches the goal" in text
    assert "It says nothing of the arm's lag" in text
    assert "proofs during the run" in text


def test_every_check_is_in_the_verdict_table(run_folder, page):
    checks = json.loads((run_folder / "metrics.json").read_text())["checks"]
    badges = [a for tag, a in page.tags if a.get("class", "").startswith("badge")]
    assert [a["class"] for a in badges] == [
        "badge pass" if check["pass"] else "badge fail" for check in checks.values()
    ]


def test_meshcat_is_linked_only_where_it_lies(page, wounded_page):
    def links(found):
        return [a["href"] for tag, a in found.tags if tag == "a"]

    assert links(page) == []
    assert links(wounded_page) == ["meshcat.html"]


@pytest.mark.parametrize(
    "name", ["scenario.yaml", "skill.yaml", "log.npz", "metrics.json"]
)
def test_a_missing_or_damaged_file_is_named(copy, name):
    (copy / name).write_bytes(b"\x00[broken")
    with pytest.raises(RunFolderError, match=re.escape(name)):
        write_report(copy)
    (copy / name).unlink()
    with pytest.raises(RunFolderError, match=f"{re.escape(name)}: missing"):
        write_report(copy)


@pytest.mark.slow
@pytest.mark.exhaustive
@pytest.mark.usefixtures("unsaved_figures")
def test_a_run_that_never_washed_has_a_report_too(copy):
    log = SimulationLog.load(copy / "log.npz")
    never = replace(log, phase=np.zeros_like(log.phase), outcome="TIMED_OUT")
    never.save(copy / "log.npz")
    text = write_report(copy).read_text()
    assert "The run timed out before the goal" in text


@pytest.mark.parametrize("content", ["[]", "{}", '{"verdict": "pass"}'])
def test_metrics_without_their_keys_are_refused(copy, content):
    (copy / "metrics.json").write_text(content)
    with pytest.raises(RunFolderError, match="metrics"):
        write_report(copy)


def test_the_command_fails_on_one_line_without_a_folder(tmp_path, capsys):
    assert main(["report", str(tmp_path / "none")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "none" in error
