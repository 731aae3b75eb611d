"""`bath-drake learn` stopped, killed and resumed: nothing is lost, nothing differs."""

import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bath_drake.cli import INTERRUPTED, main
from bath_drake.learning.checkpoint import Checkpoint
from bath_drake.resources import models_folder
from bath_drake.skill_file import load_skill, save_skill

DEMONSTRATIONS = sorted(
    str(path) for path in (models_folder() / "demonstrations").glob("back_*.csv")
)
EFFORT = ["--quick", "--obstacles", "2", "--pictures", "one"]


@pytest.fixture(scope="module")
def arc(tmp_path_factory):
    path = tmp_path_factory.mktemp("arc") / "arc.csv"
    s = np.linspace(0.0, 1.0, 61)
    # Bends enough to need all steps of the search, even with two obstacles.
    rows = zip(4.0 * s, 0.3 * s, 0.141 * np.sin(2.0 * np.pi * s), strict=True)
    lines = [f"{t:.4f},{x:.6f},{y:.6f}" for t, x, y in rows]
    path.write_text("\n".join(["t_s,x_m,y_m", *lines]))
    return str(path)


@pytest.fixture(scope="module")
def whole(arc, tmp_path_factory):
    """The skill file of a run that nobody disturbed."""
    path = tmp_path_factory.mktemp("whole") / "s.yaml"
    assert main(["learn", arc, "-o", str(path), *EFFORT]) == 0
    return path


@pytest.fixture(autouse=True)
def ctrl_c_as_in_a_terminal():
    """A shell's background jobs ignore Ctrl-C, and so do the tests run there."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def signal_during(monkeypatch, part, *numbers):
    """Lets the first step that is computed and has `part` in its name raise signals."""
    step, left = Checkpoint.step, list(numbers)

    def hit(self, key, compute):
        def disturbed():
            while part in key and left:
                signal.raise_signal(left.pop(0))
                time.sleep(0.01)  # two that are pending at once would be one
            return compute()

        return step(self, key, disturbed)

    monkeypatch.setattr(Checkpoint, "step", hit)


@pytest.mark.parametrize(
    ("number", "part"),
    [
        (signal.SIGINT, "by direction"),
        (signal.SIGINT, "generation 1"),
        (signal.SIGTERM, "generation 0"),
    ],
)
def test_a_stopped_run_leaves_an_unfinished_skill_and_is_resumed(
    arc, whole, tmp_path, monkeypatch, capsys, number, part
):
    out = tmp_path / "s.yaml"
    words = ["learn", arc, "-o", str(out), *EFFORT]
    handlers = [signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)]
    signal_during(monkeypatch, part, number)
    assert main(words) == 1
    captured = capsys.readouterr()
    assert "UNFINISHED" in captured.out
    (line,) = captured.err.splitlines()
    assert "s.yaml is unfinished" in line
    assert "--resume goes on" in line
    assert names(tmp_path) == ["s.checkpoint", "s.png", "s.yaml"]
    assert handlers == [signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)]
    stopped = load_skill(out)
    assert not stopped.finished
    start = [repr(float(value)) for value in stopped.start]
    # It runs: to the goal (0), or into a trap of a field that is not done (1).
    assert main(["reproduce", str(out), "--start", *start]) in (0, 1)
    assert main([*words, "--resume"]) == 0
    assert names(tmp_path) == ["s.png", "s.yaml"]
    assert out.read_bytes() == whole.read_bytes()
    assert load_skill(out).finished


def test_a_second_ctrl_c_ends_at_once_with_everything_intact(
    arc, whole, tmp_path, monkeypatch, capsys
):
    out = tmp_path / "s.yaml"
    out.write_bytes(whole.read_bytes())
    signal_during(monkeypatch, "generation 1", signal.SIGINT, signal.SIGINT)
    words = ["learn", arc, "-o", str(out), *EFFORT]
    assert main(words) == INTERRUPTED
    assert capsys.readouterr().err == "bath-drake learn: interrupted\n"
    assert out.read_bytes() == whole.read_bytes()
    assert names(tmp_path) == ["s.checkpoint", "s.yaml"]
    assert main([*words, "--resume"]) == 0
    assert out.read_bytes() == whole.read_bytes()


def test_what_a_stopped_run_has_computed_is_not_lost_by_a_plain_command(
    arc, tmp_path, monkeypatch, capsys
):
    out = tmp_path / "s.yaml"
    words = ["learn", arc, "-o", str(out), *EFFORT]
    with monkeypatch.context() as patch:
        signal_during(patch, "generation 1", signal.SIGINT)
        assert main(words) == 1
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    capsys.readouterr()
    for again, message in [
        (words, "s.checkpoint: found the checkpoint of an unfinished run; continue it"),
        ([*words, "--resume", "--seed", "1"], "config.seed: found 0, this run has 1"),
        (
            ["learn", DEMONSTRATIONS[0], *words[2:], "--resume"],
            "s.checkpoint: canonical.axes: found",
        ),
    ]:
        assert main(again) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert message in line
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_holding_out_can_be_stopped_and_resumed_too(arc, tmp_path, monkeypatch, capsys):
    other, out = tmp_path / "other.csv", tmp_path / "s.yaml"
    # Another file of the same motion: twice the same file would be one.
    other.write_text("#" + Path(arc).read_text(encoding="utf-8"), encoding="utf-8")
    words = ["learn", arc, str(other), "-o", str(out), "--held-out", *EFFORT]
    words += ["--obstacles", "0"]  # does not converge: the code is 1 either way
    with monkeypatch.context() as patch:
        signal_during(patch, "without 0", signal.SIGINT)
        assert main(words) == 1
    captured = capsys.readouterr()
    (line,) = captured.err.splitlines()
    assert "holding out is not" in line
    assert "--resume goes on" in line
    assert "  UNFINISHED" in captured.out
    assert load_skill(out).finished
    skill = out.read_bytes()
    assert "s.checkpoint" in names(tmp_path)
    assert main([*words, "--resume"]) == 1
    captured = capsys.readouterr()
    assert captured.err == ""
    assert "median held out" in captured.out
    assert out.read_bytes() == skill
    assert names(tmp_path) == ["other.csv", "s.png", "s.yaml", "s_held_out.png"]


def test_a_finished_skill_is_not_learned_again_by_resume(arc, whole, capsys):
    words = ["learn", arc, "-o", str(whole), *EFFORT, "--resume"]
    before = whole.stat().st_mtime_ns
    assert main(words) == 0
    assert "learned to its end already" in capsys.readouterr().out
    assert whole.stat().st_mtime_ns == before
    assert names(whole.parent) == ["s.png", "s.yaml"]


def test_a_skill_that_did_not_converge_says_so_when_resumed(arc, tmp_path, capsys):
    # Without obstacles the flow goes straight.
    words = ["learn", arc, "-o", str(tmp_path / "s.yaml"), "--quick"]
    words += ["--obstacles", "0", "--pictures", "one"]
    assert main(words) == 1
    assert main([*words, "--resume"]) == 1
    assert "already" in capsys.readouterr().out


def test_resume_takes_no_skill_for_another(arc, whole, tmp_path, capsys):
    out = tmp_path / "s.yaml"
    words = ["learn", arc, "-o", str(out), *EFFORT, "--resume"]
    skill = load_skill(whole)
    frame = replace(skill.canonical, scales=2.0 * skill.canonical.scales)
    for other, message in [
        (replace(skill, config=skill.config | {"seed": 5}), "config.seed: found 5"),
        (replace(skill, demonstration_hashes=("0" * 64,)), "demonstration_hashes"),
        (replace(skill, canonical=frame), "canonical.scales: found"),
    ]:
        save_skill(out, other)
        before = out.read_bytes()
        assert main(words) == 2
        assert f"s.yaml: {message}" in capsys.readouterr().err
        assert out.read_bytes() == before


def test_where_there_is_nothing_to_resume_learning_begins(arc, whole, tmp_path):
    out = tmp_path / "s.yaml"
    assert main(["learn", arc, "-o", str(out), *EFFORT, "--resume"]) == 0
    assert out.read_bytes() == whole.read_bytes()


def start(out, **environment):
    words = [sys.executable, "-m", "bath_drake", "learn", *DEMONSTRATIONS]
    return subprocess.Popen(
        [*words, "-o", str(out), "--quick", "--resume", "--pictures", "one"],
        env=os.environ | environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


@pytest.mark.exhaustive
@pytest.mark.parametrize("wanted", [20])
def test_kills_change_no_bit(wanted, tmp_path):
    undisturbed = tmp_path / "whole.yaml"
    assert start(undisturbed).wait() == 0  # with a compiler's time, perhaps
    undisturbed.unlink()
    begin = time.monotonic()
    assert start(undisturbed).wait() == 0
    longest = time.monotonic() - begin
    out, kept = tmp_path / "s.yaml", tmp_path / "s.checkpoint"
    moments = random.Random(6)
    kills = ends = found = 0
    while kills < wanted:
        process = start(out)
        while process.poll() is None and not kept.exists():
            time.sleep(0.01)
        time.sleep(moments.uniform(0.0, 0.7 * longest))
        process.kill()
        if process.wait() == 0:  # it was at its end
            ends += 1
            assert out.read_bytes() == undisturbed.read_bytes()
            out.unlink()
        else:
            kills += 1
            found = max(found, kept.stat().st_size if kept.exists() else 0)
    assert found > 10_000  # it was not always too early
    assert start(out).wait() == 0
    assert out.read_bytes() == undisturbed.read_bytes()
    assert not kept.exists()


@pytest.mark.exhaustive
def test_one_worker_on_one_core_learns_what_two_do(tmp_path):
    cores = os.sched_getaffinity(0)
    found = []
    for name, count in (("one", 1), ("two", 2)):
        out = tmp_path / f"{name}.yaml"
        os.sched_setaffinity(0, sorted(cores)[:count])
        try:
            assert start(out, BATH_DRAKE_WORKERS=str(count)).wait() == 0
        finally:
            os.sched_setaffinity(0, cores)
        found.append(out.read_bytes())
    assert found[0] == found[1]
