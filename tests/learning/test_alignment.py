"""Demonstrations laid beside each other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.learning._alignment import matches
from bath_drake.learning.alignment import align
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.strokes import resample


def corner(at, count=120):
    """Along x, then along y; the corner after a share of the way."""
    legs = np.array([[0.0, 0.0], [2.0 * at, 0.0], [2.0 * at, 2.0 - 2.0 * at]])
    points = resample(legs, count)
    return points - points[-1]


def test_a_stroke_answers_to_itself_point_by_point():
    stroke = corner(0.4)
    np.testing.assert_array_equal(matches(stroke, stroke), np.arange(len(stroke)))


@given(st.integers(0, 1000), st.integers(5, 40), st.integers(5, 40))
def test_matches_join_the_ends_and_never_go_back(seed, n, m):
    rng = np.random.default_rng(seed)
    found = matches(rng.normal(size=(n, 2)), rng.normal(size=(m, 2)))
    assert (np.diff(found) >= 0.0).all()
    assert 0.0 <= found[0]
    assert found[-1] <= m - 1


def test_aligned_points_keep_both_ends():
    strokes = np.array([corner(0.4), corner(0.5), corner(0.6)])
    found = align(strokes)
    np.testing.assert_allclose(found.points[:, 0], strokes[:, 0], atol=1e-12)
    np.testing.assert_allclose(found.points[:, -1], strokes[:, -1], atol=1e-12)
    np.testing.assert_array_equal(found.mean[-1], strokes[0, -1])


def test_a_corner_made_sooner_or_later_is_not_averaged_away():
    strokes = np.array([corner(0.4), corner(0.5), corner(0.6)])
    found = align(strokes)
    plain = resample(strokes.mean(axis=0), strokes.shape[1])
    # The one in the middle has a sharp corner; equal shares of length cut it.
    assert discrete_frechet(found.mean, strokes[1]) < 0.7 * discrete_frechet(
        plain, strokes[1]
    )


def test_where_warping_gains_nothing_the_mean_is_that_of_equal_shares():
    t = np.linspace(-1.0, 0.0, 100)
    strokes = np.array([np.stack([t, s * t * (t + 1.0)], -1) for s in (0.5, 0.6, 0.7)])
    plain = resample(strokes.mean(axis=0), 100)
    np.testing.assert_array_equal(align(strokes).mean, plain)


def test_one_stroke_is_its_own_mean():
    stroke = corner(0.3)
    found = align(stroke[None])
    np.testing.assert_array_equal(found.mean, stroke)


def test_a_given_mean_is_kept():
    strokes = np.array([corner(0.4), corner(0.6)])
    mean = corner(0.5)
    found = align(strokes, mean)
    assert found.mean is mean
    assert found.points.shape == strokes.shape


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_alignment_turns_and_scales_along(scale):
    strokes = np.array([corner(0.4), corner(0.5), corner(0.6)])
    turn = scale * np.array([[0.6, -0.8], [0.8, 0.6]])
    expected = align(strokes)
    found = align(strokes @ turn.T)
    # Rounding only: the same points answer to each other.
    np.testing.assert_allclose(found.mean, expected.mean @ turn.T, atol=1e-9 * scale)
    np.testing.assert_allclose(
        found.points, expected.points @ turn.T, atol=1e-9 * scale
    )
