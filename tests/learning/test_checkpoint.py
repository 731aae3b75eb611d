"""Checkpoints: whatever is cut off and wherever, the end is the same bit by bit."""

import os
import subprocess
import sys
from pathlib import Path

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from bath_drake.errors import CheckpointError
from bath_drake.learning.checkpoint import Arrays, Checkpoint, Steps, Stopped, Under
from bath_drake.notation import FloatArray

_IDENTITY = {"version": "1", "demonstrations": ["ab", "cd"], "config": {"seed": 3}}
_STEPS = 6
_FEW = settings(max_examples=30)  # every file waits for the disk


class Computed(list[str]):
    """The keys of the steps that were computed, not read."""


def _learn(checkpoint: Steps, computed: Computed, stop: int = _STEPS) -> Arrays:
    """A made-up search: each step needs the one before and numbers of its own."""
    state: Arrays = {"x": np.zeros((2, 3)), "n": np.array(0)}
    for k in range(stop):

        def compute(k: int = k, before: Arrays = state) -> Arrays:
            computed.append(f"step {k}")
            rng = np.random.default_rng([7, k])
            x: FloatArray = np.tanh(before["x"] + rng.normal(size=(2, 3)))
            return {"x": x, "n": before["n"] + 1}

        state = checkpoint.step(f"step {k}", compute)
    return state


def _bits(arrays: Arrays) -> list[tuple[str, tuple[int, ...], bytes]]:
    return [(name, a.shape, a.tobytes()) for name, a in arrays.items()]


_WHOLE = _bits(_learn(Checkpoint(), Computed()))


def test_two_steps_of_one_name_are_refused(tmp_path: Path) -> None:
    for checkpoint in (Checkpoint(), Checkpoint(tmp_path / "c", _IDENTITY)):
        with checkpoint:
            _learn(checkpoint, Computed(), 2)
            with pytest.raises(ValueError, match="'step 1' is asked for twice"):
                checkpoint.step("step 1", lambda: {"x": np.ones(1)})


def test_parts_of_learning_have_names_of_their_own() -> None:
    checkpoint = Checkpoint()
    for name in ("a", "b"):
        found = Under(checkpoint, name)
        inner = Under(found, "c")
        for steps in (found, inner):
            assert _bits(_learn(steps, Computed())) == _WHOLE


@_FEW
@given(st.lists(st.integers(0, _STEPS), max_size=3), st.data())
def test_any_interruptions_give_the_same_end(
    tmp_path_factory: pytest.TempPathFactory, stops: list[int], data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("c") / "s.checkpoint"
    for stop in stops:
        with Checkpoint(path, _IDENTITY, resume=True) as checkpoint:
            _learn(checkpoint, Computed(), stop)
        # A kill while it writes leaves any beginning of the file.
        if path.exists():
            os.truncate(path, data.draw(st.integers(0, path.stat().st_size)))
    with Checkpoint(path, _IDENTITY, resume=True) as checkpoint:
        computed = Computed()
        assert _bits(_learn(checkpoint, computed)) == _WHOLE
        assert len(computed) == _STEPS - checkpoint.found
    with Checkpoint(path, _IDENTITY, resume=True) as checkpoint:
        computed = Computed()
        assert _bits(_learn(checkpoint, computed)) == _WHOLE
        assert computed == []


@_FEW
@given(st.sets(st.integers(0, _STEPS - 1)))
def test_any_steps_known_give_the_same_end(
    tmp_path_factory: pytest.TempPathFactory, known: set[int]
) -> None:
    path = tmp_path_factory.mktemp("c") / "s.checkpoint"
    states = [_learn(Checkpoint(), Computed(), k + 1) for k in range(_STEPS)]
    with Checkpoint(path, _IDENTITY) as checkpoint:
        for k in sorted(known, reverse=True):
            checkpoint.step(f"step {k}", lambda k=k: states[k])
    with Checkpoint(path, _IDENTITY, resume=True) as checkpoint:
        computed = Computed()
        assert _bits(_learn(checkpoint, computed)) == _WHOLE
        assert computed == [f"step {k}" for k in range(_STEPS) if k not in known]


def test_what_a_step_gives_is_the_callers_own(tmp_path: Path) -> None:
    turned = np.arange(6.0).reshape(2, 3).T
    for resume in (False, True):
        with Checkpoint(tmp_path / "c", _IDENTITY, resume=resume) as checkpoint:
            found = checkpoint.step("a", lambda: {"x": turned})["x"]
            np.testing.assert_array_equal(found, turned)
            # Sums go by memory order: it must not tell a stored result from a new one.
            assert found.flags.c_contiguous
            found += 1.0


def test_every_kind_of_array_comes_back_with_its_bits(tmp_path: Path) -> None:
    values: Arrays = {
        "nothing": np.empty((0, 3)),
        "one": np.array(5),
        "odd": np.array([np.nan, -0.0, np.inf, 5e-324]),
        "flags": np.array([True, False]),
    }
    with Checkpoint(tmp_path / "c", _IDENTITY) as checkpoint:
        checkpoint.step("a", lambda: values)
    with Checkpoint(tmp_path / "c", _IDENTITY, resume=True) as checkpoint:
        found = checkpoint.step("a", dict)
    assert _bits(found) == _bits(values)
    assert [a.dtype for a in found.values()] == [a.dtype for a in values.values()]


def test_an_array_of_objects_is_refused() -> None:
    with pytest.raises(ValueError, match="Object arrays"):
        Checkpoint().step("a", lambda: {"x": np.array([None])})


def test_a_step_that_fails_leaves_no_trace(tmp_path: Path) -> None:
    def fail() -> Arrays:
        raise np.linalg.LinAlgError("singular")

    with Checkpoint(tmp_path / "c", _IDENTITY) as checkpoint:
        with pytest.raises(np.linalg.LinAlgError):
            checkpoint.step("a", fail)
        assert checkpoint.step("a", lambda: {"x": np.ones(1)})["x"] == 1.0


def test_a_stopped_checkpoint_begins_no_step_but_knows_its_own(tmp_path: Path) -> None:
    with Checkpoint(tmp_path / "c", _IDENTITY) as checkpoint:
        before = _learn(checkpoint, Computed(), 2)
    with Checkpoint(tmp_path / "c", _IDENTITY, resume=True) as checkpoint:
        checkpoint.stop()
        assert _bits(_learn(checkpoint, Computed(), 2)) == _bits(before)
        with pytest.raises(Stopped, match="step 2"):
            checkpoint.step("step 2", dict)


def test_a_write_that_was_cut_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "c"
    checkpoint = Checkpoint(path, _IDENTITY)
    _learn(checkpoint, Computed(), 2)

    def full(file: int) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(CheckpointError, match=r"c: cannot be written: No space"):
            checkpoint.flush()
    for key in ("step 2", "step 3"):
        checkpoint.step(key, lambda: {"x": np.ones(1)})
    checkpoint.close()
    with Checkpoint(path, _IDENTITY, resume=True) as again:
        assert again.found == 4


def _begin(path: Path) -> None:
    with Checkpoint(path, _IDENTITY) as checkpoint:
        _learn(checkpoint, Computed(), 1)


def test_a_checkpoint_is_not_begun_where_one_is(tmp_path: Path) -> None:
    path = tmp_path / "c"
    _begin(path)
    before = path.read_bytes()
    with pytest.raises(CheckpointError, match=r"--resume.* or delete it"):
        Checkpoint(path, _IDENTITY)
    assert path.read_bytes() == before


def test_a_checkpoint_of_no_step_is_nothing(tmp_path: Path) -> None:
    path = tmp_path / "c"
    killed = Checkpoint(path, _IDENTITY)
    left = path.read_bytes()
    killed.close()
    assert not path.exists()
    path.write_bytes(left)
    with Checkpoint(path, {"another": "run"}) as checkpoint:
        assert checkpoint.found == 0


def test_a_checkpoint_in_use_is_refused_even_to_another_process(tmp_path: Path) -> None:
    path = tmp_path / "c"
    program = (
        "import sys, pathlib\n"
        "from bath_drake.learning.checkpoint import Checkpoint\n"
        "Checkpoint(pathlib.Path(sys.argv[1]), {}, resume=True)"
    )
    words = [sys.executable, "-c", program, str(path)]
    with Checkpoint(path, _IDENTITY):
        for resume in (False, True):
            with pytest.raises(CheckpointError, match="another run is writing it"):
                Checkpoint(path, _IDENTITY, resume=resume)
        found = subprocess.run(words, capture_output=True, text=True, check=False)
        assert "another run is writing it" in found.stderr
    Checkpoint(path, _IDENTITY, resume=True).close()


def test_a_finished_checkpoint_leaves_no_file(tmp_path: Path) -> None:
    with Checkpoint(tmp_path / "c", _IDENTITY) as checkpoint:
        _learn(checkpoint, Computed())
        checkpoint.remove()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"version": "2"}, 'version: found "1", this run has "2"'),
        ({"demonstrations": ["ab"]}, r'demonstrations: found \["ab", "cd"\]'),
        ({"config": {"seed": 4}}, r"config\.seed: found 3, this run has 4"),
        ({"config": {"seed": 3, "new": 1.5}}, r"config\.new: found null"),
    ],
)
def test_the_checkpoint_of_another_run_is_refused(
    tmp_path: Path, change: dict[str, object], message: str
) -> None:
    path = tmp_path / "c"
    _begin(path)
    with pytest.raises(CheckpointError, match=f"c: {message}"):
        Checkpoint(path, _IDENTITY | change, resume=True)
    # And it is free again.
    Checkpoint(path, _IDENTITY, resume=True).close()


@_FEW
@given(st.integers(0, 10_000), st.integers(1, 255))
def test_any_damaged_byte_is_noticed(
    tmp_path_factory: pytest.TempPathFactory, at: int, flip: int
) -> None:
    path = tmp_path_factory.mktemp("c") / "c"
    with Checkpoint(path, _IDENTITY) as checkpoint:
        _learn(checkpoint, Computed(), 3)
    data = bytearray(path.read_bytes())
    data[at % len(data)] ^= flip
    path.write_bytes(data)
    with pytest.raises(CheckpointError, match=r"c: (found no|byte \d+: found a dam)"):
        Checkpoint(path, _IDENTITY, resume=True)
    assert path.read_bytes() == data


def test_what_is_no_checkpoint_is_refused_and_kept(tmp_path: Path) -> None:
    skill, folder = tmp_path / "s.yaml", tmp_path / "folder"
    skill.write_text("schema_version: 2\n")
    folder.mkdir()
    for path, message in [
        (skill, "found no checkpoint"),
        (folder, "cannot be opened"),
        (tmp_path / "absent" / "c", "cannot be opened: No such file"),
    ]:
        with pytest.raises(CheckpointError, match=message):
            Checkpoint(path, _IDENTITY, resume=True)
    assert skill.read_text() == "schema_version: 2\n"
