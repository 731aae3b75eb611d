"""Skills of several fields and branches through the commands, the page and Meshcat."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_run import make_skill, write_run
from made_up_skill import composed_skill, crossing_chain

from bath_drake.cli import main
from bath_drake.composition.branch import Branch
from bath_drake.composition.certify import certify_chain
from bath_drake.composition.chain import Chain
from bath_drake.composition.rollout import chain_rollout, chain_times
from bath_drake.field.rollout import RolloutStatus
from bath_drake.meshcat.view import (
    ROOT,
    Overlay,
    overlays_of_run,
    record_overlays,
)
from bath_drake.report.page import write_report
from bath_drake.report.run_data import load_run
from bath_drake.scenario import Scenario
from bath_drake.skill_file import certified, load_skill, save_skill

START = composed_skill().start


def proved(skill):
    return certified(skill, *map(certify_chain, skill.chains))


@pytest.fixture(scope="module")
def branched(tmp_path_factory):
    """The crossing loop, conditioned, and a field of its own for starts from above."""
    skill = composed_skill(conditioned=True)
    above = np.array([-0.7, 0.7])
    chain = Chain(crossing_chain().fields[:1])
    path = chain_rollout(above, chain).path
    skill = replace(
        skill, branches=(*skill.branches, Branch(chain, above, above[None], path))
    )
    path = tmp_path_factory.mktemp("skill") / "branched.yaml"
    save_skill(path, proved(skill))
    return path


def reproduced(path, out, start, *words):
    start = [repr(float(value)) for value in start]
    code = main(["reproduce", str(path), "--start", *start, *words, "-o", str(out)])
    rows = [line.split(",") for line in out.read_text().splitlines()[1:]]
    return code, np.array(rows, dtype=np.float64)


def test_a_composed_skill_is_reproduced_field_after_field(branched, tmp_path, capsys):
    skill = load_skill(branched)
    start, goal = START + 0.02, np.array([-0.15, -0.68])
    code, rows = reproduced(
        branched, tmp_path / "p.csv", start, "--goal", *map(str, goal)
    )
    output = capsys.readouterr().out
    chain = skill.chain_for(start, goal)
    found = chain_rollout(start, chain)
    assert code == 0
    assert found.status is RolloutStatus.ARRIVED
    # Nine digits are written.
    np.testing.assert_allclose(rows[:, 1:], found.path, atol=1e-8)
    times = chain_times(found, chain, speed=0.07, half_extents=skill.canonical.scales)
    np.testing.assert_allclose(rows[:, 0], times, rtol=1e-8)
    # Roll-outs end within 1e-3 of the goal: the one that was asked for.
    np.testing.assert_allclose(rows[-1, 1:], goal, atol=1e-3)
    assert "fields   3 of 3 followed" in output
    certificate = certify_chain(chain, start=start)
    assert f"verdict  {certificate.verdict}: {certificate.reason}" in output
    assert certificate.passed


def test_the_branch_shown_nearest_to_the_start_is_reproduced(
    branched, tmp_path, capsys
):
    code, rows = reproduced(branched, tmp_path / "p.csv", [-0.6, 0.6])
    assert code == 0
    assert "fields" not in capsys.readouterr().out
    (chain,) = load_skill(branched).chains[1:]
    # Roll-outs end within 1e-3 of the goal.
    np.testing.assert_allclose(rows[-1, 1:], chain.goal, atol=1e-3)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--start", "9", "9"], "--start: (9, 9)"),
        (["--start", "-0.7", "-0.3", "--goal", "0", "9"], "--goal: ("),
    ],
)
def test_ends_that_are_not_free_are_refused(branched, capsys, words, message):
    assert main(["reproduce", str(branched), *words]) == 2
    assert message in capsys.readouterr().err


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A made-up run of the crossing loop on a person, its folder."""
    scenario = Scenario(description="A made-up run of a composed skill.")
    made_up = make_skill(scenario)
    skill = proved(replace(made_up, branches=composed_skill().branches))
    folder = tmp_path_factory.mktemp("runs") / "composed"
    return write_run(folder, scenario, skill)


def test_a_run_tells_how_many_fields_were_followed(run):
    data = load_run(run)
    assert data.metrics["stages"] == {"count": 3, "reached": 3}
    assert (
        data.evaluation.rollout.tolist()
        == chain_rollout(START, data.skill.chain).path.tolist()
    )
    # Each point is judged in the world that was driven in then.
    assert data.metrics["min_beta"] > 0.0


def test_what_is_left_at_a_key_frame_is_the_chain_from_there(run):
    data = load_run(run)
    for frame in data.keyframes:
        chain = data.chain_from(frame)
        assert len(chain) == 3 - data.stage(frame)
        assert chain.fields[0] == frame.world
        np.testing.assert_array_equal(chain.goal, data.skill.chain.goal)
        # The path goes all the way.
        assert np.linalg.norm(data.path_from(frame)[-1] - chain.goal) < 1e-2


@pytest.mark.slow
@pytest.mark.usefixtures("unsaved_figures")
def test_the_page_of_a_composed_skill_names_its_fields(run):
    text = write_report(run).read_text()
    assert "in 3 fields, followed in turn" in text
    assert "3 of 3" in text
    assert "5 ellipses, 3 fields" not in text  # it has three
    assert "3 ellipses, 3 fields" in text


def test_meshcat_shows_the_obstacles_that_are_followed_apart_from_the_others(run):
    data = load_run(run)
    overlays = overlays_of_run(data.log, data.evaluation, data.skill)
    names = {overlay.name for overlay in overlays}
    for k in range(3):
        assert f"virtual_obstacles/field_{k}/followed" in names
        assert f"virtual_obstacles/field_{k}/waiting" in names
    gates = [o for o in overlays if o.name.startswith("gates/")]
    assert len(gates) == 2
    assert max(gate.radius for gate in gates) <= 0.001
    for stage in range(3):
        seen = [o.name for o in overlays if o.stage is not None and o.is_seen(stage)]
        assert sum(name.endswith("followed") for name in seen) == 1
        assert sum(name.endswith("waiting") for name in seen) == 2
        assert f"virtual_obstacles/field_{stage}/followed" in seen


class _Recorder:
    """A Meshcat that notes when an object is made visible, and when not."""

    def __init__(self):
        self.seen = {}

    def __getattr__(self, name):
        return lambda *arguments: None

    def get_mutable_recording(self):
        return self

    def frame(self, time):
        return round(60.0 * time)

    def SetProperty(self, *arguments):  # the animation's has four arguments
        if len(arguments) == 4:
            frame, path, name, value = arguments
            assert name == "visible"
            self.seen.setdefault(path.removeprefix(f"{ROOT}/"), []).append(
                (frame / 60.0, value)
            )


def test_the_recording_shows_each_field_while_it_is_followed(run):
    data, recorder = load_run(run), _Recorder()
    record_overlays(recorder, data.log, data.evaluation, data.skill)
    for k in range(3):
        times = data.log.time[data.log.stage == k]
        shown = recorder.seen[f"virtual_obstacles/field_{k}/followed"]
        (begin,) = [t for t, value in shown if value and times[0] - 0.1 <= t]
        # Frames are a fifteenth of a second apart, samples 0.05 s.
        assert begin == pytest.approx(times[0], abs=1.0 / 15.0 + 0.05)
        ends = [t for t, value in shown if not value and t > begin]
        if k < 2:
            assert ends[0] == pytest.approx(times[-1], abs=1.0 / 15.0 + 0.05)
        else:
            assert ends == []
        waiting = recorder.seen[f"virtual_obstacles/field_{k}/waiting"]
        assert waiting == [(t, not value) for t, value in shown]


def test_what_belongs_to_no_field_is_always_seen():
    assert Overlay("path", (), "#000000", 0.1).is_seen(5)
