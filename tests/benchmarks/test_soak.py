"""The soak is the same for the same episode, goes on where it was, and counts."""

import json
from concurrent.futures import Future

import numpy as np
import pytest

from bath_drake.benchmarks import soak, soak_episodes
from bath_drake.benchmarks.figures import Settings
from bath_drake.benchmarks.soak_episodes import (
    EPISODES,
    Episode,
    run_sitting,
    sitting_scenario,
)
from bath_drake.errors import BathDrakeError
from bath_drake.scenario import check_scenario, dump_scenario


def made_up(index, seconds=10.0, **more):
    values = {
        "sitting": 0,
        "runs_before": index,
        "outcome": "TIMED_OUT",
        "passed": 0.5,
        "entries": 0,
        "not_finite": 0,
        "too_fast": 0,
        "memory": 400.0 + index,
    }
    return Episode(index=index, seconds=seconds, **{**values, **more})


@pytest.mark.parametrize("ideal", [True, False])
def test_every_sitting_is_a_sound_scenario_and_the_same_again(ideal):
    texts = set()
    for number in range(20):
        scenario = sitting_scenario("f_avg", number, ideal=ideal)
        check_scenario(scenario)
        again = sitting_scenario("f_avg", number, ideal=ideal)
        assert dump_scenario(scenario) == dump_scenario(again)
        texts.add(dump_scenario(scenario))
    assert len(texts) == 20


def test_those_of_whom_most_is_left_sit_next():
    found = {
        "f_avg": [made_up(0, 30.0)],
        "f_old": [made_up(0, 10.0)],
        "f_thin": [made_up(0, 40.0)],
        soak.THROUGH_THE_CAMERA: [made_up(0, 25.0)],
    }
    # The camera's seconds take three times as long; nothing of f_thin is left.
    assert soak.next_people(found, 40.0, set()) == [
        soak.THROUGH_THE_CAMERA,
        "f_old",
        "f_avg",
    ]
    assert soak.next_people(found, 40.0, {"f_old", "m_avg"}) == ["f_avg"]


@pytest.fixture
def quick_sittings(monkeypatch):
    """Sittings that take no time, in this very process; yields what was run."""
    ran = []

    def run_sitting(person, number, *, ideal, first, seconds):
        for index in range(first, EPISODES):
            if seconds < 0.5:
                return
            ran.append((person, number, index, ideal))
            episode = made_up(
                index, min(10.0, seconds), sitting=number, runs_before=index - first
            )
            seconds -= episode.seconds
            yield episode

    class Here:
        def __init__(self, **kwargs):
            pass

        def __enter__(self):
            return self

        def __exit__(self, *exception):
            pass

        def submit(self, call, *args):
            future = Future()
            future.set_result(call(*args))
            return future

    monkeypatch.setattr(soak, "run_sitting", run_sitting)
    monkeypatch.setattr(soak, "ProcessPoolExecutor", Here)
    monkeypatch.setattr(soak, "shipped_people", lambda: ["f_avg", "m_avg"])
    return ran


def soaked(hours, folder):
    return soak.run(Settings(hours=hours, data=folder), lambda what, share: None)


def test_a_soak_goes_on_where_it_was_broken_off(tmp_path, quick_sittings):
    soaked(2.0 * 50.0 / 3600.0, tmp_path)
    assert len(quick_sittings) == 10
    lines = (tmp_path / "soak_f_avg.jsonl").read_text("utf-8").splitlines()
    assert [json.loads(line)["index"] for line in lines] == [0, 1, 2, 3, 4]
    whole = [(s, k) for s in (0, 1) for k in range(EPISODES)]
    report = soaked(2.0 * 20.0 * EPISODES / 3600.0, tmp_path)
    for person, ideal in (("f_avg", True), ("m_avg", False)):
        mine = [run for run in quick_sittings if run[0] == person]
        assert [run[1:3] for run in mine] == whole
        assert {run[3] for run in mine} == {ideal}
    (hours,) = (f for f in report.figures if f.name == "soak_hours")
    assert hours.passed


def test_nothing_is_run_twice(tmp_path, quick_sittings):
    soaked(2.0 * 30.0 / 3600.0, tmp_path)
    quick_sittings.clear()
    soaked(2.0 * 30.0 / 3600.0, tmp_path)
    assert quick_sittings == []


def test_a_damaged_episode_is_refused_by_file_and_line(tmp_path):
    (tmp_path / "soak_f_avg.jsonl").write_text("{}\n", "utf-8")
    with pytest.raises(BathDrakeError, match=r"line 1: found '\{\}'"):
        soaked(0.01, tmp_path)


def test_each_process_is_judged_by_its_own_growth():
    first = [made_up(k, memory=500.0 + min(k, 3)) for k in range(5)]
    second = [made_up(k, sitting=1, memory=450.0 + 2.0 * k) for k in range(5)]
    # Warm after three runs: 453 to 453 MB, and 456 to 458 MB.
    assert soak.largest_growth(first) == 0.0
    assert soak.largest_growth(first + second) == 2.0
    assert np.isnan(soak.largest_growth(first[:3]))


def test_what_only_a_robot_that_moves_needs_is_no_growth():
    # Held at first, it loads the kernels of washing with its fourth episode.
    held = [made_up(k, memory=400.0, passed=0.0) for k in range(4)]
    moves = [made_up(k, memory=412.0 + min(k - 4, 3)) for k in range(4, 10)]
    assert np.isnan(soak.largest_growth(held))
    assert soak.largest_growth(held + moves) == 0.0
    moves.append(made_up(10, memory=417.0, passed=0.0))
    assert soak.largest_growth(held + moves) == 2.0


def test_an_entry_or_growth_misses_the_targets():
    well = soak.body_row("f_avg", [made_up(k) for k in range(6)])
    assert all(f.passed for f in soak.figures(60.0 / 3600.0, [well]))
    entered = soak.body_row("f_avg", [made_up(0, 60.0, entries=1)])
    missed = [f.name for f in soak.figures(60.0 / 3600.0, [entered]) if not f.passed]
    assert missed == ["soak_restricted_entries"]
    grown = soak.body_row("f_avg", [made_up(3 * k) for k in range(6)])
    missed = [f.name for f in soak.figures(60.0 / 3600.0, [grown]) if not f.passed]
    assert missed == ["soak_memory_growth_of_a_body"]


@pytest.mark.faults
@pytest.mark.slow
def test_an_episode_is_the_same_whichever_was_run_before_it(monkeypatch):
    monkeypatch.setattr(soak_episodes, "LONGEST", 3.0)
    monkeypatch.setattr(soak_episodes, "EPISODES", 3)

    def told(episodes):
        return [(e.index, e.seconds, e.outcome, e.passed) for e in episodes]

    every = told(run_sitting("f_thin", 0, ideal=True))
    assert told(run_sitting("f_thin", 0, ideal=True, first=2)) == every[2:]


@pytest.mark.faults
@pytest.mark.slow
def test_two_minutes_of_soak_enter_nothing_and_emit_numbers_alone(monkeypatch):
    # Two bodies, without the camera: a process each, and each takes a minute of CI's.
    monkeypatch.setattr(soak, "shipped_people", lambda: ["f_thin", "m_heavy"])
    report = soak.run(Settings(hours=2.0 / 60.0), lambda what, share: None)
    found = {figure.name: figure for figure in report.figures}
    for name in ("hours", "restricted_entries", "not_finite", "too_fast"):
        assert found[f"soak_{name}"].passed, report.rows
