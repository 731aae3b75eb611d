"""Demonstrations that do not belong to the others are named, and move no goal."""

from pathlib import Path

import numpy as np
import pytest

from bath_drake.demonstrations.agreement import find_strays
from bath_drake.demonstrations.metadata import RecordingMetadata
from bath_drake.demonstrations.processing import (
    canonical_demonstrations,
    without_strays,
)
from bath_drake.demonstrations.recording import Recording

BENT = np.column_stack(
    [np.linspace(-0.2, 0.2, 80), 0.05 * np.sin(np.linspace(0.0, 5.0, 80))]
)


def recorded(name, points, seconds=4.0):
    t = np.linspace(0.0, seconds, len(points))
    return Recording(Path(f"{name}.csv"), t, points, RecordingMetadata(), name)


def three():
    return [recorded(k, BENT + 0.004 * i) for i, k in enumerate("abc")]


def strays_of(*others):
    found, _ = canonical_demonstrations([*three(), *others])
    return {d.name: d.stray for d in found if d.stray}, found


def test_those_that_agree_have_no_strays():
    strays, found = strays_of()
    assert strays == {}
    assert without_strays(found) == found


def test_one_that_was_broken_off_is_named():
    strays, _ = strays_of(recorded("short", BENT[:45]))
    assert list(strays) == ["short"]
    assert "broken off" in strays["short"]
    assert "allowed: 0.2" in strays["short"]


def test_one_that_goes_the_other_way_round_is_named():
    strays, _ = strays_of(recorded("back", BENT[::-1]))
    assert strays == {
        "back": "goes the other way round: it starts where the others end"
    }


def test_one_that_is_there_twice_is_named():
    strays, _ = strays_of(three()[1])
    assert strays == {"b": "is the same recording as b"}


def test_a_stray_moves_no_goal():
    _, found = strays_of(recorded("short", BENT[:45]))
    alone, _ = canonical_demonstrations(three())
    # The frame's scale hangs on all extents, and the short one's are within.
    np.testing.assert_allclose(found[0].points[-1], alone[0].points[-1], atol=1e-12)
    np.testing.assert_array_equal(found[3].goal_offset, 0.0)


def test_other_speeds_and_lengths_of_file_are_no_reason():
    slow = recorded("slow", BENT[::2], seconds=12.0)
    assert strays_of(slow)[0] == {}


def test_of_two_none_is_a_stray():
    pair = [recorded("a", BENT), recorded("b", BENT[::-1])]
    found, _ = canonical_demonstrations(pair)
    assert [d.stray for d in found] == ["", ""]


def test_without_agreement_none_is_a_stray():
    turn = np.linspace(0.0, 2.0 * np.pi, 5)[:-1]
    ends = np.column_stack([np.cos(turn), np.sin(turn)])
    assert find_strays(0.0 * ends, ends, 2.0, list("abcd"), list("abcd")) == {}


@pytest.mark.parametrize("turns", [0.0, 0.3, 2.0])
def test_the_place_of_all_together_does_not_matter(turns):
    cos, sin = np.cos(turns), np.sin(turns)
    R = np.array([[cos, -sin], [sin, cos]])
    paths = [BENT, BENT + 0.003, BENT[:40]]
    starts = np.array([path[0] for path in paths]) @ R.T + 3.0
    ends = np.array([path[-1] for path in paths]) @ R.T + 3.0
    assert list(find_strays(starts, ends, 0.4, list("abc"), list("abc"))) == [2]
