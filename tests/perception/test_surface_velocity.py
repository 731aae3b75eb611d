"""The skin's own velocity is found, and where the skin will be foretold."""

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bath_drake.perception.surface import SurfacePatch
from bath_drake.perception.surface_velocity import VelocityFilter, moved_patch

PERIOD = 1.0 / 30.0
PATCH = SurfacePatch(
    p_WS=np.array([0.7, 0.1, 0.9]),
    normal_W=np.array([-1.0, 0.0, 0.0]),
    curvatures=np.zeros(2),
    count=200,
    rms=1e-3,
    radius=0.03,
    valid=True,
    normal_deviation=0.01,
)
# Turns about the normal itself show nothing.
STEADY = np.array([0.0, 0.1, -0.2, 0.02, -0.01, 0.005])


def _after(seconds, velocity=STEADY, patch=PATCH):
    """The patch of skin that has moved steadily for so long."""
    turn = Rotation.from_rotvec(seconds * velocity[:3])
    return dataclasses.replace(
        patch,
        p_WS=patch.p_WS + seconds * velocity[3:],
        normal_W=turn.apply(patch.normal_W),
    )


def _found(smoothing, patches, velocity=None, period=PERIOD):
    velocity = np.zeros(6) if velocity is None else velocity
    for before, after in itertools.pairwise(patches):
        velocity = smoothing.next(velocity, before, after, period)
    return velocity


def test_a_steady_motion_is_found():
    frames = [_after(k * PERIOD) for k in range(60)]
    # After 13 time constants; the turning normal leaves a thousandth of the turn.
    np.testing.assert_allclose(_found(VelocityFilter(), frames), STEADY, atol=2e-3)


def test_skin_that_moves_on_is_where_it_was_foretold():
    foretold = moved_patch(PATCH, STEADY, 0.05)
    truth = _after(0.05)
    np.testing.assert_allclose(foretold.p_WS, truth.p_WS, atol=1e-12)
    # Second order in the turn: (0.05 s 0.22 rad/s)^2 / 2.
    np.testing.assert_allclose(foretold.normal_W, truth.normal_W, atol=1e-4)
    assert np.linalg.norm(foretold.normal_W) == pytest.approx(1.0, abs=1e-12)
    assert (foretold.quality, foretold.count) == (PATCH.quality, PATCH.count)


def test_noise_of_the_fits_moves_the_skin_foretold_by_little():
    rng = np.random.default_rng(2)
    frames = [
        dataclasses.replace(PATCH, p_WS=PATCH.p_WS + 3e-4 * rng.standard_normal(3))
        for _ in range(600)
    ]
    velocity, found = np.zeros(6), []
    for before, after in itertools.pairwise(frames):
        velocity = VelocityFilter().next(velocity, before, after, PERIOD)
        found.append(velocity[3:])
    # What the docstring promises of 0.3 mm of noise; over a frame, 0.07 mm.
    assert np.std(found) == pytest.approx(2e-3, rel=0.2)


@given(st.floats(-10.0, 10.0), st.floats(-3.0, 3.0))
def test_one_bad_fit_throws_nothing(jump, turn):
    smoothing = VelocityFilter()
    bad = _after(1.0, np.array([0.0, turn, 0.0, jump, 0.0, 0.0]))
    velocity = smoothing.next(np.zeros(6), PATCH, bad, PERIOD)
    share = 1.0 - np.exp(-PERIOD / smoothing.time)
    assert np.linalg.norm(velocity[3:]) <= share * smoothing.speed * (1 + 1e-12)
    assert np.linalg.norm(velocity[:3]) <= share * smoothing.angular_speed * (1 + 1e-12)


@pytest.mark.parametrize("which", [0, 1])
def test_skin_that_is_not_seen_comes_to_rest(which):
    pair = [PATCH, _after(PERIOD)]
    pair[which] = dataclasses.replace(pair[which], valid=False)
    velocity = VelocityFilter().next(STEADY, *pair, PERIOD)
    np.testing.assert_allclose(velocity, STEADY * np.exp(-PERIOD / 0.15))


def test_a_patch_that_is_none_stays_where_it_is():
    none = dataclasses.replace(PATCH, valid=False)
    assert moved_patch(none, STEADY, 0.1) is none


@pytest.mark.parametrize("dt", [0.0, -0.1, np.nan, np.inf])
def test_impossible_intervals_are_refused(dt):
    with pytest.raises(ValueError, match="dt"):
        VelocityFilter().next(np.zeros(6), PATCH, PATCH, dt)


@pytest.mark.parametrize("name", ["time", "speed", "angular_speed"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_impossible_filters_are_refused(name, value):
    with pytest.raises(ValueError, match=name):
        VelocityFilter(**{name: value})
