import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.map_filter import MapFilter

DT = 1.0 / 30.0
BACK = Rotation.from_euler("xyz", [0.3, -0.7, 1.9])
NUMBER = st.floats(-1.0, 1.0)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER).map(np.array)


def make_map(turn=(0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0), growth=(0.0, 0.0)):
    return CanonicalMap(
        (BACK * Rotation.from_rotvec(turn)).as_matrix(),
        np.array([0.6, 0.1, 0.9]) + shift,
        np.array([0.18, 0.24]) + growth,
    )


def angle(a, b):
    return Rotation.from_matrix(a.R_WP.T @ b.R_WP).magnitude()


def run(smooth, seen, seconds, filter_=None, dt=DT):
    filter_ = MapFilter() if filter_ is None else filter_
    for _ in range(round(seconds / dt)):
        smooth = filter_.next(smooth, seen, dt)
    return smooth


@given(turn=VECTOR, shift=VECTOR)
@settings(max_examples=30)
def test_it_converges_to_a_map_that_stays(turn, shift):
    seen = make_map(turn, shift, (0.02, -0.03))
    smooth = run(make_map(), seen, 60.0, dt=2.0)
    # 60 s are 20 of the longer time constants: exp(-20) = 2e-9 of what was off.
    assert angle(smooth, seen) < 1e-7
    np.testing.assert_allclose(smooth.p_WP, seen.p_WP, atol=1e-8)
    np.testing.assert_allclose(smooth.half_extents, seen.half_extents, atol=1e-9)


def test_the_map_that_is_seen_again_stays_as_it_is():
    smooth = MapFilter().next(make_map(), make_map(), DT)
    # The rotation goes through a vector and back: some 1e-16 each.
    np.testing.assert_allclose(smooth.R_WP, make_map().R_WP, atol=1e-14)
    np.testing.assert_array_equal(smooth.p_WP, make_map().p_WP)
    np.testing.assert_array_equal(smooth.half_extents, make_map().half_extents)


def test_it_stays_a_rotation_over_thousands_of_frames(rng):
    smooth = make_map()
    for _ in range(2000):
        seen = make_map(0.05 * rng.standard_normal(3))
        smooth = MapFilter().next(smooth, seen, DT)
    # The projection on the rotations is good to rounding, every time.
    np.testing.assert_allclose(smooth.R_WP.T @ smooth.R_WP, np.eye(3), atol=1e-14)
    assert np.linalg.det(smooth.R_WP) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("turn", [0.05, 1.0, 3.0])
def test_a_step_of_the_pose_is_an_e_folding_off_after_its_time(turn):
    filter_ = MapFilter(pose_time=0.5)
    seen = make_map((0.0, turn, 0.0), (0.1, 0.0, 0.0))
    smooth = run(make_map(), seen, 0.5, filter_)
    # Exact for any step; what is left is rounding over 15 frames.
    assert angle(smooth, seen) == pytest.approx(turn * np.exp(-1.0), rel=1e-9)
    left = seen.p_WP - smooth.p_WP
    np.testing.assert_allclose(left, [0.1 * np.exp(-1.0), 0, 0], atol=1e-12)


def test_a_step_of_the_size_is_an_e_folding_off_after_its_time():
    seen = make_map(growth=(0.03, -0.02))
    smooth = run(make_map(), seen, 3.0, MapFilter(size_time=3.0))
    left = seen.half_extents - smooth.half_extents
    np.testing.assert_allclose(left, np.exp(-1.0) * np.array([0.03, -0.02]), atol=1e-12)


def test_the_size_moves_slower_than_the_pose():
    seen = make_map((0.1, 0.0, 0.0), (0.05, 0.0, 0.0), (0.05, 0.0))
    smooth = run(make_map(), seen, 1.0)
    pose = (seen.p_WP - smooth.p_WP)[0] / 0.05
    size = (seen.half_extents - smooth.half_extents)[0] / 0.05
    assert pose < 0.5 * size < size < 1.0


def test_two_short_steps_are_one_long_step():
    filter_, seen = MapFilter(), make_map((0.2, 0.1, 0.0), (0.1, 0.0, 0.0), (0.02, 0))
    one = filter_.next(make_map(), seen, 0.2)
    two = filter_.next(filter_.next(make_map(), seen, 0.15), seen, 0.05)
    assert angle(one, two) < 1e-7  # the least angle that a rotation of floats has
    np.testing.assert_allclose(one.p_WP, two.p_WP, atol=1e-15)
    np.testing.assert_allclose(one.half_extents, two.half_extents, atol=1e-15)


def test_flicker_is_damped(rng):
    smooth, places = make_map(), []
    for _ in range(2000):
        seen = make_map(shift=(0.005 * rng.standard_normal(), 0.0, 0.0))
        smooth = MapFilter(pose_time=0.5).next(smooth, seen, DT)
        places.append(smooth.p_WP[0])
    # White noise through a first-order filter of 15 frames: a factor of
    # sqrt(s / (2 - s)), s = 1 - exp(-1/15), 0.18; 0.25 leaves room for the sample.
    assert np.std(places[300:]) < 0.25 * 0.005


@pytest.mark.parametrize("name", ["pose_time", "size_time"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_time_constants_must_be_positive(name, value):
    with pytest.raises(ValueError, match=f"{name} must be positive"):
        MapFilter(**{name: value})
