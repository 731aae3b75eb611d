"""The soak is the same for the same episode, goes on where it was, and counts."""

import json

import pytest

from bath_drake.benchmarks import soak
from bath_drake.benchmarks.figures import Settings
from bath_drake.benchmarks.soak_episodes import Episode, episode_scenario
from bath_drake.errors import BathDrakeError
from bath_drake.scenario import check_scenario, dump_scenario


def made_up(index, seconds=10.0, **more):
    values = {
        "outcome": "TIMED_OUT",
        "passed": 0.5,
        "entries": 0,
        "not_finite": 0,
        "too_fast": 0,
        "memory": 400.0 + index,
    }
    return Episode(index=index, seconds=seconds, **{**values, **more})


@pytest.mark.parametrize("ideal", [True, False])
def test_every_episode_is_a_sound_scenario_and_the_same_again(ideal):
    texts = set()
    for index in range(40):
        scenario = episode_scenario("f_avg", index, 20.0, ideal=ideal)
        check_scenario(scenario)
        again = episode_scenario("f_avg", index, 20.0, ideal=ideal)
        assert dump_scenario(scenario) == dump_scenario(again)
        texts.add(dump_scenario(scenario))
    assert len(texts) == 40


def test_a_soak_goes_on_where_it_was_broken_off(tmp_path, monkeypatch):
    ran = []

    def run_episode(person, index, seconds, *, ideal):
        ran.append((index, seconds, ideal))
        return made_up(index, min(seconds, 10.0))

    monkeypatch.setattr(soak, "run_episode", run_episode)
    assert len(soak.soak_body("f_avg", 20.0, tmp_path)) == 2
    assert len(soak.soak_body("f_avg", 35.0, tmp_path)) == 4
    assert [index for index, _, _ in ran] == [0, 1, 2, 3]
    assert ran[-1][1] == pytest.approx(5.0)
    lines = (tmp_path / "soak_f_avg.jsonl").read_text("utf-8").splitlines()
    assert [json.loads(line)["index"] for line in lines] == [0, 1, 2, 3]


def test_a_damaged_episode_is_refused_by_file_and_line(tmp_path):
    (tmp_path / "soak_f_avg.jsonl").write_text("{}\n", "utf-8")
    with pytest.raises(BathDrakeError, match=r"line 1: found '\{\}'"):
        soak.soak_body("f_avg", 1.0, tmp_path)


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
def test_two_minutes_of_soak_enter_nothing_and_emit_numbers_alone(monkeypatch):
    # Two bodies, without the camera: a process each, and each takes a minute of CI's.
    monkeypatch.setattr(soak, "shipped_people", lambda: ["f_thin", "m_heavy"])
    report = soak.run(Settings(hours=2.0 / 60.0), lambda what, share: None)
    found = {figure.name: figure for figure in report.figures}
    for name in ("hours", "restricted_entries", "not_finite", "too_fast"):
        assert found[f"soak_{name}"].passed, report.rows
