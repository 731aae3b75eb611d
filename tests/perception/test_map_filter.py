"""The smoothed map follows a body that moves and not a mask that flickers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.map_filter import MapFilter, SmoothMap, predicted

DT = 1.0 / 30.0
BACK = Rotation.from_euler("xyz", [0.3, -0.7, 1.9])
NUMBER = st.floats(-1.0, 1.0)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER).map(np.array)


def make_map(turn=(0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0), growth=(0.0, 0.0)):
    return CanonicalMap(
        (Rotation.from_rotvec(turn) * BACK).as_matrix(),
        np.array([0.6, 0.1, 0.9]) + shift,
        np.array([0.18, 0.24]) + growth,
    )


def angle(a, b):
    return Rotation.from_matrix(a.R_WP.T @ b.R_WP).magnitude()


def run(seen, filter_=None, dt=DT):
    """What is known after each of some maps."""
    filter_ = MapFilter() if filter_ is None else filter_
    smooth = filter_.start(seen[0])
    yield smooth
    for one in seen[1:]:
        smooth = filter_.next(smooth, one, dt)
        yield smooth


def last(seen, **options):
    *_, smooth = run(seen, **options)
    return smooth


@pytest.mark.slow
@given(turn=VECTOR, shift=VECTOR)
@settings(max_examples=5)
def test_it_converges_to_a_map_that_stays(turn, shift):
    seen = make_map(turn, shift, (0.02, -0.03))
    smooth = last([make_map()] + [seen] * 900).canonical_map
    # Half a minute: ten of the size's time constants, and some forty of the pose's.
    assert angle(smooth, seen) < 1e-6
    np.testing.assert_allclose(smooth.p_WP, seen.p_WP, atol=1e-6)
    np.testing.assert_allclose(smooth.half_extents, seen.half_extents, atol=3e-6)


def test_the_map_that_is_seen_again_stays_as_it_is():
    smooth = last([make_map()] * 50)
    # The rotation goes through a vector and back, fifty times.
    np.testing.assert_allclose(smooth.canonical_map.R_WP, make_map().R_WP, atol=1e-13)
    np.testing.assert_allclose(smooth.canonical_map.p_WP, make_map().p_WP, atol=1e-13)
    np.testing.assert_allclose(smooth.velocity, 0.0, atol=1e-11)


def test_it_stays_a_rotation_over_thousands_of_frames(rng):
    seen = [make_map(0.05 * rng.standard_normal(3)) for _ in range(2000)]
    smooth = last(seen).canonical_map
    # The projection on the rotations is good to rounding, every time.
    np.testing.assert_allclose(smooth.R_WP.T @ smooth.R_WP, np.eye(3), atol=1e-14)
    assert np.linalg.det(smooth.R_WP) == pytest.approx(1.0, abs=1e-14)


SWAY = np.array([0.02, -0.01, 0.005])  # m/s
TWIST = np.array([0.0, 0.0, 0.04])  # rad/s


def test_a_steady_motion_is_followed_without_lag():
    times = DT * np.arange(600)
    seen = [make_map(t * TWIST, t * SWAY) for t in times]
    smooth = last(seen)
    assert angle(smooth.canonical_map, seen[-1]) < 1e-5
    # A first-order filter would be behind by its time constant, some centimetre.
    np.testing.assert_allclose(smooth.canonical_map.p_WP, seen[-1].p_WP, atol=1e-5)
    np.testing.assert_allclose(smooth.velocity, [*TWIST, *SWAY], atol=1e-4)
    ahead = predicted(smooth, 0.1).canonical_map
    np.testing.assert_allclose(ahead.p_WP, seen[-1].p_WP + 0.1 * SWAY, atol=3e-5)


def test_a_body_that_sways_is_followed_within_a_frame():
    # As the shipped scenarios' people do: 5 degrees every 23 s, half a metre up.
    times = DT * np.arange(1400)
    sway = 0.04 * np.sin(2 * np.pi * times / 23.0)
    seen = [make_map(shift=(x, 0.0, 0.0)) for x in sway]
    found = np.array([s.canonical_map.p_WP[0] for s in run(seen)]) - 0.6
    speed = np.gradient(sway, times)
    late = (sway - found)[60:] @ speed[60:] / (speed[60:] @ speed[60:])
    assert abs(late) < DT


@pytest.mark.parametrize("step", [0.03, 0.2])
def test_a_jerk_is_followed_at_once_but_for_the_flicker(step):
    seen = [make_map()] * 60 + [make_map((0.0, step, 0.0), (step, 0.0, 0.0))] * 2
    filter_ = MapFilter()
    for smooth in list(run(seen, filter_))[60:]:
        off = np.linalg.norm(smooth.canonical_map.p_WP - seen[-1].p_WP)
        assert off <= filter_.most_shift + 1e-12
        assert angle(smooth.canonical_map, seen[-1]) <= filter_.most_turn + 1e-7


def test_flicker_is_damped(rng):
    filter_ = MapFilter()
    noise = filter_.shift_noise
    seen = [
        make_map(shift=(noise * rng.standard_normal(), 0.0, 0.0)) for _ in range(3000)
    ]
    places = np.array([s.canonical_map.p_WP[0] for s in run(seen)]) - 0.6
    # At first a mean of k frames is off by 1 / sqrt(k); then the gain is steady.
    assert np.abs(places[30:60]).max() < 3.0 * noise / np.sqrt(20)
    # The steady gain is 0.1, which leaves 0.29 of the noise; and a sample's own error.
    assert np.std(places[300:]) < 0.35 * noise


def test_the_size_is_a_mean_at_first_and_fades_with_its_time(rng):
    sizes = 0.01 * rng.standard_normal(30)
    smooth = last([make_map(growth=(g, 0.0)) for g in sizes])
    mean = 0.18 + sizes.mean()
    assert smooth.canonical_map.half_extents[0] == pytest.approx(mean, abs=2e-4)
    filter_ = MapFilter(size_time=3.0)
    known = SmoothMap(make_map(), covariance=np.eye(2), seconds=60.0)
    for _ in range(round(3.0 / DT)):
        known = filter_.next(known, make_map(growth=(0.03, -0.02)), DT)
    left = (
        make_map(growth=(0.03, -0.02)).half_extents - known.canonical_map.half_extents
    )
    np.testing.assert_allclose(left, np.exp(-1.0) * np.array([0.03, -0.02]), atol=1e-12)


@pytest.mark.parametrize("name", list(vars(MapFilter())))
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_its_numbers_must_be_positive(name, value):
    with pytest.raises(ValueError, match=f"{name} must be positive"):
        MapFilter(**{name: value})
