import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bath_drake.demonstrations.denoise import (
    CUTOFF_HZ,
    TOLERANCE,
    denoise,
)
from bath_drake.demonstrations.outliers import find_outliers, find_strays

SEEDS = st.integers(0, 2**32 - 1)


def clock(rng, duration=8.0, rate=60.0):
    """Times of a tracker that is never quite regular."""
    t = np.linspace(0.0, duration, round(duration * rate) + 1)
    t[1:-1] += rng.uniform(-0.4, 0.4, t.size - 2) / rate
    return t


def sinusoid(t, duration=8.0):
    """A stroke of 1.5 periods across 0.3 m, from rest to rest."""
    s = t / duration
    s = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    return np.stack([0.3 * s, 0.08 * np.sin(3.0 * np.pi * s)], axis=-1)


def tone(t, frequency, rng):
    return np.sin(2.0 * np.pi * (frequency * t[:, None] + rng.uniform(size=2)))


@settings(deadline=None, max_examples=25)
@given(SEEDS, st.floats(4.0, 12.0))
def test_a_clean_stroke_comes_through_within_a_quarter_of_a_millimetre(seed, duration):
    t = clock(np.random.default_rng(seed), duration)
    path = denoise(t, sinusoid(t, duration))
    error = np.linalg.norm(path(t) - sinusoid(t, duration), axis=1)
    # At 4 s the stroke is fastest: 0.7 Hz and its harmonics at mid-stroke, of which
    # the filter takes (0.7 / 1.8)^4 = 2 % of 80 mm; 8 s and slower, 0.25 mm.
    assert np.max(error) < (0.25e-3 if duration >= 8.0 else 2.5e-3)
    assert path.outliers.size == 0


@settings(deadline=None, max_examples=25)
@given(SEEDS, st.floats(4.0, 12.0))
def test_tremor_loses_nine_tenths_inside_and_a_third_at_the_ends(seed, frequency):
    rng = np.random.default_rng(seed)
    t = clock(rng)
    shaken = 2e-3 * tone(t, frequency, rng)
    smooth = denoise(t, sinusoid(t))(t)
    left = denoise(t, sinusoid(t) + shaken)(t) - smooth
    inside = (t > 0.5) & (t < t[-1] - 0.5)
    # The gain is 1 / (1 + (4 / 1.8)^4) = 0.04 at most; an uneven clock adds a little.
    assert np.max(np.abs(left[inside])) < 0.1 * 2e-3
    # An end has neighbours on one side only.
    assert np.max(np.abs(left)) < 0.67 * 2e-3


def test_the_gain_is_that_of_the_filter_documented():
    t = np.linspace(0.0, 20.0, 2001)
    # A large slow motion beside it keeps the tolerance out of play.
    for frequency in (0.3, 1.0, CUTOFF_HZ, 4.0, 8.0):
        wave = 1e-3 * np.sin(2.0 * np.pi * frequency * t)
        path = denoise(t, np.stack([t / 20.0, wave], axis=-1))
        inside = slice(500, 1500)
        gain = np.std(path(t)[inside, 1]) / np.std(wave[inside])
        # 100 samples a second act like a continuum to this precision.
        assert gain == pytest.approx(
            1.0 / (1.0 + (frequency / CUTOFF_HZ) ** 4), abs=1e-3
        )


def test_there_is_no_lag():
    t = np.linspace(0.0, 8.0, 481)
    there = denoise(t, sinusoid(t))(t)
    back = denoise(t, sinusoid(t)[::-1])(t)
    # The spline's equations are solved in one direction: rounding only.
    np.testing.assert_allclose(there, back[::-1], atol=1e-9)


@settings(deadline=None, max_examples=25)
@given(SEEDS, st.floats(0.2, 3.0))
def test_a_fast_stroke_is_followed_within_the_tolerance(seed, duration):
    t = clock(np.random.default_rng(seed), duration, rate=100.0)
    points = sinusoid(t, duration)
    error = np.linalg.norm(denoise(t, points)(t) - points, axis=1)
    # Samples closer than 5 ms are averaged first: between those it is a little more.
    assert np.max(error) <= 1.2 * TOLERANCE * np.max(np.ptp(points, axis=0))


@settings(deadline=None, max_examples=40)
@given(SEEDS)
def test_wild_samples_are_found_and_leave_no_trace(seed):
    rng = np.random.default_rng(seed)
    t = clock(rng)
    points = sinusoid(t) + 5e-4 * tone(t, 8.0, rng)
    wild = np.array([60, 61, 200, 350, 351, 352])
    bad = points.copy()
    jumps = rng.uniform(0.06, 0.3, 3) * rng.choice([-1, 1], 3)
    bad[wild, 1] += np.repeat(jumps, [2, 1, 3])
    np.testing.assert_array_equal(find_outliers(t, bad), wild)
    difference = denoise(t, bad)(t) - denoise(t, points)(t)
    # Three samples are missing: what the tremor was there is not known.
    assert np.max(np.abs(difference)) < 1e-3


@settings(deadline=None, max_examples=40)
@given(SEEDS, st.floats(0.0, 3e-3), st.floats(15.0, 200.0))
def test_noise_alone_is_not_taken_for_wild_samples(seed, noise, rate):
    rng = np.random.default_rng(seed)
    t = clock(rng, rate=rate)
    points = sinusoid(t) + noise * rng.normal(size=(t.size, 2))
    assert find_outliers(t, points).size <= 0.01 * t.size


def test_a_sharp_corner_is_no_outlier():
    t = np.linspace(0.0, 4.0, 41)
    points = np.stack([0.05 * np.abs(t - 2.0), 0.1 * t], axis=-1)
    assert find_outliers(t, points).size == 0


@pytest.mark.parametrize("count", [5, 6, 20])
@pytest.mark.parametrize("duration", [1e-3, 1.0, 1e4])
def test_few_points_at_any_pace_give_a_finite_path_near_them(count, duration):
    t = np.linspace(0.0, duration, count)
    points = sinusoid(t, duration)
    path = denoise(t, points)
    assert np.max(np.abs(path(t) - points)) <= 0.3 * TOLERANCE


def test_thousands_of_samples_a_second_and_nearly_equal_times_do_no_harm():
    rng = np.random.default_rng(0)
    t = np.sort(np.r_[np.linspace(0.0, 8.0, 80001), rng.uniform(0.0, 8.0, 1000)])
    t = np.unique(np.r_[t, np.nextafter(t[5], 1.0)])
    path = denoise(t, sinusoid(t))
    times = np.linspace(0.0, 8.0, 500)
    error = np.linalg.norm(path(times) - sinusoid(times), axis=1)
    # As for 60 samples a second.
    assert np.max(error) < 0.25e-3


def test_a_gap_in_the_recording_is_bridged():
    t = np.linspace(0.0, 8.0, 481)
    kept = (t < 3.0) | (t > 3.4)
    path = denoise(t[kept], sinusoid(t[kept]))
    error = np.linalg.norm(path(t) - sinusoid(t), axis=1)
    # A cubic over 0.4 s of a stroke that turns within 2.7 s.
    assert np.max(error) < 2e-3


def test_a_jump_among_strong_tremor_is_left_out_and_bends_nothing(rng):
    t = np.arange(0.0, 5.0, 1.0 / 30.0)
    line = np.column_stack([0.08 * t, 0.0 * t])
    shaken = line + 0.006 * np.sin(2.0 * np.pi * 9.0 * t + [[0.0], [2.0]]).T
    jumped = shaken.copy()
    jumped[70] += [0.02, 0.045]
    path = denoise(t, jumped)
    assert path.outliers.tolist() == [70]
    # Tremor of 6 mm at 9 Hz passes with 0.2 %, a gap of two samples bends by the rest.
    middle = slice(15, -15)
    np.testing.assert_allclose(path(t)[middle], line[middle], atol=1e-3)


def test_strays_stand_alone():
    smooth = np.full((40, 2), 1e-3)
    smooth[20] = [0.03, 0.0]
    assert find_strays(smooth, side=0.4).tolist() == [20]
    # A corner that was cut leaves a whole run.
    smooth[18:23] = [0.03, 0.0]
    assert find_strays(smooth, side=0.4).size == 0
    # The ends have one neighbour, and may be a motion.
    ends = np.full((40, 2), 1e-3)
    ends[0] = ends[-1] = [0.03, 0.0]
    assert find_strays(ends, side=0.4).size == 0
