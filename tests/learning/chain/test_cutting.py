"""Strokes cut into stages."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.learning.chain.cutting import cut, gate_at, stage_count
from bath_drake.learning.strokes import headings, resample


def sine(periods, count=200):
    t = np.linspace(0.0, 1.0, 4 * count)
    wave = np.stack([1.6 * t - 0.8, 0.3 * np.sin(2 * np.pi * periods * t)], axis=-1)
    return resample(wave, count)


def test_a_straight_stroke_is_one_stage():
    line = np.linspace([0.0, 0.0], [1.0, 0.5], 100)
    assert stage_count(line, 1.4) == 1
    assert cut(line, 1) == (0, 99)


@given(st.floats(0.5, 4.0), st.integers(1, 12))
def test_cuts_rise_from_the_first_point_to_the_last(periods, count):
    curve = sine(periods)
    found = cut(curve, count)
    assert (found[0], found[-1]) == (0, len(curve) - 1)
    assert (np.diff(found) >= 4).all()
    assert len(found) - 1 <= count


@pytest.mark.parametrize("periods", [1.0, 2.0, 3.5])
def test_stages_share_the_turning(periods):
    curve = sine(periods)
    count = stage_count(curve, 1.4)
    turn = np.abs(np.diff(headings(curve)))
    shares = [turn[a:b].sum() for a, b in pairwise(cut(curve, count))]
    # A cut may move by a quarter of a stage at both of its ends.
    assert max(shares) <= 1.4 * 1.6


def test_a_cut_lies_where_the_stroke_is_straight():
    curve = sine(2.0)
    turn = np.abs(np.diff(headings(curve)))
    # As many stages as bends: each cut can lie where one bend becomes the next.
    at = list(cut(curve, 4)[1:-1])
    assert turn[at].max() < 0.3 * np.mean(turn)


def test_the_goal_lies_inside_the_gate_and_ahead():
    curve = sine(2.0)
    for at in cut(curve, 6)[1:-1]:
        gate, goal = gate_at(curve, at, 0)
        assert gate.holds(goal)
        away = goal - gate.centre
        assert away @ gate.direction > 0.02
        assert np.hypot(*away) < gate.radius - 0.01


@given(st.floats(1.0, 4.0))
def test_a_gate_holds_no_earlier_part_of_its_stage(periods):
    curve = sine(periods)
    cuts = cut(curve, 5)
    for before, at in pairwise(cuts[:-1]):
        gate, _ = gate_at(curve, at, before)
        # Gates are not made smaller than 0.06.
        if gate.radius > 0.06:
            assert not gate.holds(curve[before : at - 3]).any()


def test_cuts_do_not_depend_on_place_size_and_slant():
    curve = sine(2.0)
    turn = 0.4 * np.array([[0.6, -0.8], [0.8, 0.6]])
    assert cut(curve @ turn.T + [1.0, 2.0], 6) == cut(curve, 6)
