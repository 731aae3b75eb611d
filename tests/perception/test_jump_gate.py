"""Maps that no body can have come to are refused, until they prove to be its own."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.jump_gate import GateState, JumpGate, Verdict

DT = 1.0 / 30.0


def make_map(shift=0.0, turn=0.0, growth=1.0):
    return CanonicalMap(
        Rotation.from_rotvec([0.0, 0.0, turn]).as_matrix(),
        np.array([0.6 + shift, 0.1, 0.9]),
        np.array([0.18, 0.24 * growth]),
    )


def judged(maps, dt=DT):
    """The verdicts on maps of frames `dt` apart, and what is remembered at the end."""
    gate, state, verdicts = JumpGate(), GateState(), []
    for k, seen in enumerate(maps):
        state, verdict = gate.next(state, seen, k * dt)
        verdicts.append(verdict)
    return verdicts, state


def test_a_body_that_moves_as_fast_as_people_do_is_believed():
    # Half a metre a second and a turn of two radians a second, breath and all.
    maps = [make_map(0.49 * k * DT, 1.9 * k * DT) for k in range(20)]
    verdicts, state = judged(maps)
    assert verdicts == [Verdict.RELOCKED] + [Verdict.ACCEPTED] * 19
    assert state.rejected == 0


@pytest.mark.parametrize(
    "jump", [{"shift": 0.15}, {"turn": 0.7}, {"growth": 1.2}, {"growth": 0.8}]
)
def test_a_jump_is_refused_and_counted_and_what_follows_believed(jump):
    still, away = make_map(), make_map(**jump)
    verdicts, state = judged([still, still, away, away, still])
    assert verdicts[2:] == [Verdict.REJECTED, Verdict.REJECTED, Verdict.ACCEPTED]
    assert state.rejected == 2
    assert state.rival is None


def test_a_body_that_was_moved_is_taken_up_anew_after_a_second():
    verdicts, state = judged([make_map()] * 5 + [make_map(0.3)] * 40)
    # 30 frames later a second has passed since the first of them.
    assert verdicts.index(Verdict.RELOCKED, 1) == 5 + 30
    assert set(verdicts[36:]) == {Verdict.ACCEPTED}
    assert state.rejected == 30


def test_two_odd_frames_with_a_second_of_nothing_between_them_are_not_agreement():
    gate = JumpGate()
    state, _ = gate.next(GateState(), make_map(), 0.0)
    state, first = gate.next(state, make_map(0.3), DT)
    state, second = gate.next(state, make_map(0.3), DT + 1.5)
    assert (first, second) == (Verdict.REJECTED, Verdict.REJECTED)
    # From the second on they are counted anew.
    assert state.rival_since == DT + 1.5


def test_maps_that_agree_with_nothing_are_never_believed():
    rng = np.random.default_rng(4)
    wild = [make_map(*rng.uniform([0.5, 0.5], [3.0, 3.0])) for _ in range(200)]
    verdicts, state = judged([make_map(), *wild])
    assert set(verdicts[1:]) == {Verdict.REJECTED}
    assert state.rejected == 200


@given(st.floats(0.0, 60.0))
def test_however_long_nothing_was_seen_another_body_is_not_taken_for_it(seconds):
    gate = JumpGate()
    state, _ = gate.next(GateState(), make_map(), 0.0)
    _, verdict = gate.next(state, make_map(0.4), seconds + DT)
    assert verdict is Verdict.REJECTED


@pytest.mark.parametrize("name", list(vars(JumpGate())))
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_its_numbers_must_be_positive(name, value):
    with pytest.raises(ValueError, match=f"{name} must be positive"):
        JumpGate(**{name: value})
