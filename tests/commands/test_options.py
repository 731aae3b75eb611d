from types import SimpleNamespace

import pytest

from bath_drake.commands import _options
from bath_drake.commands._options import run_and_report, simulation_bar
from bath_drake.errors import RunFolderError
from bath_drake.run_folder import PAGE, REPORT
from bath_drake.scenario import Scenario

METRICS = {
    "checks": {"reached_goal": {"value": True, "limit": True, "pass": True}},
    "real_time_factor": 1.0,
}


LINE = "reach:   the whole path is reached"


class FakeMeshcat:
    def web_url(self):
        return "http://localhost:7000"


@pytest.fixture
def simulated(monkeypatch):
    """Stands in for the simulation; tells what it was asked for."""
    asked = SimpleNamespace(verdict="pass", calls=[])

    def reachability(scenario, skill):
        return SimpleNamespace(lines=lambda: [LINE], metrics=lambda: {"path": "told"})

    def simulate_into(
        folder, scenario, skill, *, meshcat, progress, reach, write_frame=None
    ):
        assert reach == {"path": "told"}
        progress(0.5, scenario.duration)
        progress(scenario.duration + 1.0, scenario.duration)
        asked.calls.append((folder, scenario, skill))
        return SimpleNamespace(metrics={"verdict": asked.verdict, **METRICS})

    monkeypatch.setattr(_options, "simulate_into", simulate_into)
    monkeypatch.setattr(_options, "reachability", reachability)
    monkeypatch.setattr(_options, "Meshcat", FakeMeshcat)
    return asked


@pytest.mark.parametrize(("verdict", "code"), [("pass", 0), ("fail", 1)])
def test_the_exit_code_is_the_verdict(simulated, tmp_path, capsys, verdict, code):
    simulated.verdict = verdict
    folder, scenario = tmp_path / "run", Scenario()
    assert run_and_report(folder, scenario, "skill", live=False) == code
    assert simulated.calls == [(folder, scenario, "skill")]
    out, err = capsys.readouterr()
    # What is within reach is said first.
    assert out.startswith(f"{LINE}\n")
    assert f"verdict: {verdict}" in out
    assert str(folder / REPORT) in out
    assert str(folder / PAGE) in out
    # In a pipe there is no bar.
    assert err == ""


def test_only_live_runs_name_an_address(simulated, tmp_path, capsys):
    run_and_report(tmp_path, Scenario(), "skill", live=False)
    assert "localhost" not in capsys.readouterr().out
    run_and_report(tmp_path, Scenario(), "skill", live=True)
    out = capsys.readouterr().out
    assert out.startswith(f"{LINE}\nMeshcat: http://localhost:7000\n")


def test_a_folder_that_cannot_be_stops_before_the_simulation(simulated, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("x")
    with pytest.raises(RunFolderError):
        run_and_report(blocked, Scenario(), "skill", live=False)
    assert simulated.calls == []


def test_a_terminal_gets_a_bar_of_simulated_seconds(monkeypatch, capsys):
    monkeypatch.setattr(_options.sys.stderr, "isatty", lambda: True, raising=False)
    with simulation_bar(40.0) as progress:
        progress(12.34, 40.0)
        progress(41.0, 40.0)
    err = capsys.readouterr().err
    assert "12.3/40 s" in err
    # Never past its end.
    assert "40.0/40 s" in err
