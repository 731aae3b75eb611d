"""The discrete Fréchet distance against its definition and a known library."""

import hypothesis.strategies as st
import numpy as np
import pytest
import similaritymeasures
from hypothesis import given, settings
from hypothesis.extra.numpy import arrays

from bath_drake.learning.frechet import discrete_frechet
from bath_drake.notation import FloatArray

curves = st.integers(1, 25).flatmap(
    lambda n: arrays(np.float64, (n, 2), elements=st.floats(-10.0, 10.0))
)


@settings(max_examples=50)
@given(curves, curves)
def test_it_agrees_with_similaritymeasures(a: FloatArray, b: FloatArray) -> None:
    expected = similaritymeasures.frechet_dist(a, b)
    # Sums of two squares, at most 800: one rounding each way.
    np.testing.assert_allclose(discrete_frechet(a, b), expected, rtol=1e-14, atol=1e-14)


@given(curves, curves)
def test_it_is_symmetric_and_zero_on_itself(a: FloatArray, b: FloatArray) -> None:
    assert discrete_frechet(a, b) == discrete_frechet(b, a)
    assert discrete_frechet(a, a) == 0.0


@given(curves, curves)
def test_it_is_at_least_the_distance_of_the_ends_and_the_hausdorff_distance(
    a: FloatArray, b: FloatArray
) -> None:
    # Squares of differences below 1e-154 underflow: hence the tiny slack.
    d = discrete_frechet(a, b) + 1e-150
    far = np.linalg.norm(a[:, None] - b[None], axis=-1)
    least = max(far[0, 0], far[-1, -1], far.min(axis=0).max(), far.min(axis=1).max())
    assert d >= least * (1.0 - 1e-14)
    assert d <= far.max() * (1.0 + 1e-14) + 1e-150


@given(curves, curves, curves)
def test_the_triangle_inequality_holds(
    a: FloatArray, b: FloatArray, c: FloatArray
) -> None:
    around = discrete_frechet(a, b) + discrete_frechet(b, c)
    assert discrete_frechet(a, c) <= around * (1.0 + 1e-12) + 1e-12


@given(curves, st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_a_shifted_curve_is_no_farther_than_the_shift(
    a: FloatArray, x: float, y: float
) -> None:
    # Walking in step holds the leash at the shift; only rounding adds to it.
    d = discrete_frechet(a, a + np.array([x, y]))
    assert d <= np.hypot(x, y) + 1e-12


@pytest.mark.parametrize(
    ("a", "message"),
    [
        (np.empty((0, 2)), "shape"),
        (np.zeros((3, 3)), "shape"),
        ([[0, np.nan]], "finite"),
    ],
)
def test_bad_curves_are_refused(a: FloatArray, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        discrete_frechet(a, np.zeros((2, 2)))
