"""A track is cut to its stroke; short gaps are filled, long ones reported."""

import numpy as np
import pytest

from bath_drake.demonstrations.capture.stroke import cut_stroke

RATE = 15.0


def made_up_track(hidden=(), away=()):
    """Times, points on a bend, heights and reasons of 45 frames."""
    t = np.arange(45) / RATE
    points = np.stack([0.1 * np.cos(t), 0.1 * np.sin(t), np.zeros_like(t)], axis=1)
    heights = np.full(45, 0.015)
    heights[list(away)] = 0.15
    reasons = ["" for _ in t]
    for k in hidden:
        points[k], heights[k], reasons[k] = np.nan, np.nan, "hidden"
    return t, points, heights, reasons


def test_a_whole_track_stays_as_it_is():
    t, points, heights, reasons = made_up_track()
    stroke = cut_stroke(t, points, heights, reasons)
    np.testing.assert_array_equal(stroke.points, points)
    assert stroke.gaps == ()


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_a_short_gap_is_filled_along_the_bend(frames):
    hidden = range(20, 20 + frames)
    track = made_up_track(hidden)
    stroke = cut_stroke(*track)
    whole = made_up_track()[1]
    np.testing.assert_array_equal(stroke.t, track[0])
    # A cubic through four neighbours a side; the bend's fifth derivative is small.
    np.testing.assert_allclose(stroke.points, whole, atol=1e-5)
    np.testing.assert_array_equal(np.flatnonzero(stroke.filled), list(hidden))
    assert [gap.filled for gap in stroke.gaps] == [True]


def test_a_long_gap_stays_open_and_is_reported():
    stroke = cut_stroke(*made_up_track(range(20, 24)))
    (gap,) = stroke.gaps
    assert not gap.filled
    assert gap.reason == "hidden"
    assert (gap.start, gap.end) == pytest.approx((19 / RATE, 24 / RATE))
    assert stroke.t.size == 41
    assert np.isfinite(stroke.points).all()


def test_the_hand_that_comes_and_goes_is_no_part_of_the_stroke():
    away = [*range(6), *range(40, 45)]
    stroke = cut_stroke(*made_up_track((0, 1, 43), away))
    assert (stroke.first, stroke.last) == (6, 39)
    assert stroke.gaps == ()


def test_a_marker_that_is_never_seen_leaves_no_stroke():
    assert cut_stroke(*made_up_track(range(45))) is None
