"""The discrete Fréchet distance against its definition and a known library."""

import math
from collections.abc import Callable

import hypothesis.strategies as st
import numpy as np
import pytest
import similaritymeasures
from hypothesis import given, settings
from hypothesis.extra.numpy import arrays

from bath_drake.learning import _frechet
from bath_drake.learning.frechet import discrete_frechet, discrete_frechet_gradient
from bath_drake.notation import FloatArray


def curves_of(elements: st.SearchStrategy[float]) -> st.SearchStrategy[FloatArray]:
    return st.integers(1, 25).flatmap(
        lambda n: arrays(np.float64, (n, 2), elements=elements)
    )


curves = curves_of(st.floats(-10.0, 10.0))
# On a coarse grid points coincide and distances tie; squares are exact.
grid_curves = curves_of(st.integers(-3, 3).map(float))
any_curves = curves_of(st.floats(allow_nan=False, allow_infinity=False))
# Below half the largest double: differences do not overflow.
wide_curves = curves_of(st.floats(-8e307, 8e307))


def textbook(distances: FloatArray) -> float:
    """The dynamic programme of Eiter and Mannila over distances (n, m)."""
    d = distances.copy()
    for i in range(len(d)):
        for j in range(d.shape[1]):
            before = [
                d[k, e]
                for k, e in ((i - 1, j), (i, j - 1), (i - 1, j - 1))
                if k >= 0 and e >= 0
            ]
            if before:
                d[i, j] = max(d[i, j], min(before))
    return float(d[-1, -1])


def roots_of_squares(a: FloatArray, b: FloatArray) -> FloatArray:
    dx = a[:, None, 0] - b[None, :, 0]
    dy = a[:, None, 1] - b[None, :, 1]
    return np.asarray(np.sqrt(dx * dx + dy * dy))


def distances(a: FloatArray, b: FloatArray) -> FloatArray:
    """Distances of all pairs; np.hypot neither overflows nor underflows."""
    with np.errstate(over="ignore"):
        difference = a[:, None] - b[None]
        return np.asarray(np.hypot(difference[..., 0], difference[..., 1]))


def walk(rng: np.random.Generator, n: int) -> FloatArray:
    return np.asarray(rng.normal(size=(n, 2)).cumsum(axis=0))


def stroke(rng: np.random.Generator, n: int) -> FloatArray:
    t = np.linspace(0.0, 1.0, n) ** rng.uniform(0.7, 1.4)
    wave = 0.3 * np.sin(3.0 * np.pi * t + rng.normal(scale=0.1))
    return np.stack([t, wave], axis=-1) + rng.normal(scale=0.01, size=(n, 2))


def differences(
    f: Callable[[FloatArray], float], x: FloatArray, h: float = 1e-7
) -> FloatArray:
    found = np.empty_like(x)
    for k in np.ndindex(x.shape):
        step = np.zeros_like(x)
        step[k] = h
        found[k] = (f(x + step) - f(x - step)) / (2.0 * h)
    return found


@pytest.mark.parametrize("make", [walk, stroke])
def test_long_curves_give_the_textbook_result_to_the_last_bit(make):
    rng = np.random.default_rng(0)
    for n, m in [(200, 200), (203, 64), (1, 90), (90, 1), (7, 8), (9, 300), (128, 127)]:
        a, b = make(rng, n), make(rng, m)
        assert discrete_frechet(a, b) == textbook(roots_of_squares(a, b))


@pytest.mark.parametrize("seed", range(20))
def test_detours_and_pauses_give_the_textbook_result_to_the_last_bit(seed):
    # The band of pairs that matter then jumps, widens and shrinks.
    rng = np.random.default_rng(seed)
    a, b = stroke(rng, 80), stroke(rng, 70)
    for curve in (a, b):
        k = rng.integers(10, 60)
        curve[k : k + rng.integers(1, 25)] += rng.normal(size=2)
        k = rng.integers(5, 50)
        curve[k : k + 20] = curve[k]
    assert discrete_frechet(a, b) == textbook(roots_of_squares(a, b))


@given(grid_curves, grid_curves)
def test_curves_with_ties_give_the_textbook_result_to_the_last_bit(
    a: FloatArray, b: FloatArray
) -> None:
    assert discrete_frechet(a, b) == textbook(roots_of_squares(a, b))


@given(any_curves, any_curves)
def test_coordinates_of_any_size_give_the_textbook_result(
    a: FloatArray, b: FloatArray
) -> None:
    # Ours: two squares, a sum and a root, each rounded, 1.5 units in the last place;
    # np.hypot is good to one. The smallest doubles are that far apart themselves.
    expected = textbook(distances(a, b))
    if math.isfinite(expected):
        np.testing.assert_allclose(
            discrete_frechet(a, b), expected, rtol=6e-16, atol=1e-323
        )
    else:
        assert discrete_frechet(a, b) == math.inf


def test_tiny_distances_are_found_beside_huge_ones() -> None:
    a = np.array([[0.0, 0.0], [1e308, 0.0], [-1e308, 1e200]])
    b = a + np.array([[3e-200, 4e-200], [0.0, 0.0], [0.0, 0.0]])
    assert discrete_frechet(a, b) == pytest.approx(5e-200, rel=1e-15)
    assert discrete_frechet_gradient(a, b).pair == (0, 0)


@settings(max_examples=50)
@given(curves, curves)
def test_it_agrees_with_similaritymeasures(a: FloatArray, b: FloatArray) -> None:
    expected = similaritymeasures.frechet_dist(a, b)
    # Sums of two squares, at most 800: one rounding each way.
    np.testing.assert_allclose(discrete_frechet(a, b), expected, rtol=1e-14, atol=1e-14)


@given(wide_curves, wide_curves)
def test_it_is_symmetric_and_zero_on_itself(a: FloatArray, b: FloatArray) -> None:
    assert discrete_frechet(a, b) == discrete_frechet(b, a)
    assert discrete_frechet(a, a) == 0.0


@given(curves, curves)
def test_it_is_at_least_the_distance_of_the_ends_and_the_hausdorff_distance(
    a: FloatArray, b: FloatArray
) -> None:
    d, far = discrete_frechet(a, b), distances(a, b)
    least = max(far[0, 0], far[-1, -1], far.min(axis=0).max(), far.min(axis=1).max())
    # Two ways to round a distance; the atol is for distances that are subnormal.
    assert d >= least * (1.0 - 1e-15) - 1e-323
    assert d <= far.max() * (1.0 + 1e-15) + 1e-323


@given(curves, curves, curves)
def test_the_triangle_inequality_holds(
    a: FloatArray, b: FloatArray, c: FloatArray
) -> None:
    around = discrete_frechet(a, b) + discrete_frechet(b, c)
    # Three distances and a sum are rounded.
    assert discrete_frechet(a, c) <= around * (1.0 + 2e-15) + 1e-322


@given(curves, st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_a_shifted_curve_is_no_farther_than_the_shift(
    a: FloatArray, x: float, y: float
) -> None:
    # Walking in step holds the leash at the shift; only rounding adds to it.
    d = discrete_frechet(a, a + np.array([x, y]))
    assert d <= np.hypot(x, y) + 1e-12


@given(curves, curves, st.floats(0.0, 6.3), st.floats(-5.0, 5.0))
def test_motions_of_both_curves_change_nothing(
    a: FloatArray, b: FloatArray, angle: float, shift: float
) -> None:
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    # Coordinates up to 20 are rounded.
    assert discrete_frechet(a @ turn + shift, b @ turn + shift) == pytest.approx(
        discrete_frechet(a, b), abs=1e-13
    )


@given(grid_curves, grid_curves, st.integers(-1000, 1000))
def test_a_power_of_two_scales_it_exactly(
    a: FloatArray, b: FloatArray, power: int
) -> None:
    d = discrete_frechet(np.ldexp(a, power), np.ldexp(b, power))
    assert d == math.ldexp(discrete_frechet(a, b), power)


@given(curves, curves)
def test_two_walkers_who_turn_round_need_the_same_leash(
    a: FloatArray, b: FloatArray
) -> None:
    assert discrete_frechet(a[::-1], b[::-1]) == discrete_frechet(a, b)


@given(curves, curves, st.data())
def test_a_point_that_is_repeated_changes_nothing(
    a: FloatArray, b: FloatArray, data: st.DataObject
) -> None:
    times = data.draw(arrays(np.int64, len(a), elements=st.integers(1, 4)))
    assert discrete_frechet(np.repeat(a, times, axis=0), b) == discrete_frechet(a, b)


@given(curves, curves, curves, curves)
def test_curves_joined_need_no_longer_leash_than_their_parts(
    a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray
) -> None:
    joined = discrete_frechet(np.concatenate([a, c]), np.concatenate([b, d]))
    assert joined <= max(discrete_frechet(a, b), discrete_frechet(c, d))


@given(curves, st.floats(-10.0, 10.0), st.floats(-10.0, 10.0))
def test_from_a_point_it_is_the_distance_of_the_farthest(
    a: FloatArray, x: float, y: float
) -> None:
    point = np.array([[x, y]])
    np.testing.assert_allclose(
        discrete_frechet(a, point), distances(a, point).max(), rtol=6e-16, atol=1e-323
    )


@given(grid_curves, grid_curves, st.floats(0.0, 100.0))
def test_a_bound_leaves_smaller_distances_and_caps_the_others(
    a: FloatArray, b: FloatArray, bound: float
) -> None:
    square = textbook(roots_of_squares(a, b) ** 2)
    found = _frechet.squared_frechet(a, len(a), b, bound)
    # Roots of whole numbers up to 72, squared again.
    assert found == pytest.approx(min(square, bound), rel=1e-15)


# A search found these: the band shrinks by a block and at once grows into it again.
@pytest.mark.parametrize("seed", [7917, 9857])
def test_a_band_that_grows_again_starts_afresh(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m = rng.integers(9, 40, 2)
    a, b = (rng.integers(0, 5, (k, 2)).astype(np.float64) for k in (n, m))
    for curve in (a, b):
        curve[:, 0] += np.linspace(0.0, 9.0, len(curve)).round()
    for bound in (12.5, 13.0, 14.5, math.inf):
        found = _frechet.squared_frechet(a, n, b, bound)
        assert found == min(bound, 13.0)


def test_what_lies_behind_a_path_s_end_is_not_looked_at() -> None:
    rng = np.random.default_rng(1)
    a, b = walk(rng, 40), walk(rng, 30)
    room = np.full((100, 2), np.nan)
    room[:40] = a
    assert _frechet.frechet(room, 40, b) == discrete_frechet(a, b)
    assert _frechet.bottleneck(room, 40, b)[0] == discrete_frechet(a, b)


@pytest.mark.parametrize("make", [walk, stroke])
@pytest.mark.parametrize(("n", "m"), [(1, 1), (1, 6), (12, 12), (20, 9)])
def test_the_gradient_is_that_of_differences(make, n, m):
    rng = np.random.default_rng(2)
    a, b = make(rng, n), make(rng, m)
    _, (i, j), gradient = discrete_frechet_gradient(a, b)
    to_b = np.zeros_like(b)
    to_b[j] = -gradient[i]
    # Truncation h^2 and rounding 1e-16 / h, of distances about 1.
    np.testing.assert_allclose(
        differences(lambda x: discrete_frechet(x, b), a), gradient, atol=1e-7
    )
    np.testing.assert_allclose(
        differences(lambda x: discrete_frechet(a, x), b), to_b, atol=1e-7
    )


@given(any_curves, any_curves)
def test_the_gradient_is_a_unit_vector_between_the_pair_it_names(
    a: FloatArray, b: FloatArray
) -> None:
    distance, (i, j), gradient = discrete_frechet_gradient(a, b)
    assert distance == discrete_frechet(a, b)
    if math.isfinite(distance):
        np.testing.assert_allclose(
            distances(a, b)[i, j], distance, rtol=6e-16, atol=1e-323
        )
    assert not np.delete(gradient, i, axis=0).any()
    if distance == 0.0:
        assert not gradient.any()
    else:
        assert np.hypot(*gradient[i]) == pytest.approx(1.0, rel=1e-15)


@given(grid_curves, grid_curves)
def test_among_ties_the_pair_is_on_a_shortest_leash(
    a: FloatArray, b: FloatArray
) -> None:
    distance, (i, j), _ = discrete_frechet_gradient(a, b)
    # One leash serves on the way to the pair, one from there on.
    there = discrete_frechet(a[: i + 1], b[: j + 1])
    onwards = discrete_frechet(a[i:], b[j:])
    assert max(there, onwards) == distance


def test_the_pair_is_the_one_a_leash_needs_not_one_as_far_apart() -> None:
    # (1, 0) and (0, 1) are as far apart as (2, 2), but no walker stops there.
    a = np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 2.0]])
    b = np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 0.0]])
    distance, pair, gradient = discrete_frechet_gradient(a, b)
    assert (distance, pair) == (2.0, (2, 2))
    np.testing.assert_array_equal(gradient, [[0.0, 0.0], [0.0, 0.0], [0.0, 1.0]])


@pytest.mark.parametrize("function", [discrete_frechet, discrete_frechet_gradient])
@pytest.mark.parametrize(
    ("a", "message"),
    [
        (np.empty((0, 2)), "a must have shape"),
        (np.zeros((3, 3)), "a must have shape"),
        ([[0, np.nan]], "a must be finite"),
        ([[0, np.inf]], "a must be finite"),
    ],
)
def test_bad_curves_are_refused(function, a, message):
    with pytest.raises(ValueError, match=message):
        function(a, np.zeros((2, 2)))
