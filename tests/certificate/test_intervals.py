"""Inclusion, checked in exact rational arithmetic: no tolerance is needed."""

import math
from collections.abc import Callable
from fractions import Fraction

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import example, given, settings

from bath_drake.certificate import intervals
from bath_drake.certificate.world import log_bounds

Interval = tuple[float, float]
Exact = tuple[Fraction, Fraction]

# Every finite float, denormal ones among them; and many of ordinary size, whose
# results neither overflow nor vanish in the absolute part of the widening.
anything = st.floats(allow_nan=False, allow_infinity=False)
ordinary = st.floats(-1e6, 1e6) | st.floats(-1e-6, 1e-6)
numbers = ordinary | anything


def _between(ends: tuple[float, float], share: float) -> Fraction:
    low, high = map(Fraction, ends)
    return low + (high - low) * Fraction(share)


intervals_ = st.tuples(numbers, numbers).map(lambda e: (min(e), max(e)))
shares = st.floats(0.0, 1.0)
positive = st.tuples(
    st.floats(1e-140, 1e140) | st.floats(1e-3, 1e3),
    st.floats(0.0, 1e140) | st.floats(0.0, 1e3),
).map(lambda e: (e[0], e[0] + e[1]))


def _holds(found: Interval, exact: Fraction) -> bool:
    """Whether an interval holds a number, or says nothing: an end that is NaN."""
    if math.isnan(found[0]) or math.isnan(found[1]):
        # Only an overflow may have led there.
        return True
    low = found[0] == -math.inf or Fraction(found[0]) <= exact
    return low and (found[1] == math.inf or exact <= Fraction(found[1]))


@settings(max_examples=300)
@given(intervals_, intervals_, shares, shares)
@example((5e-324, 5e-324), (5e-324, 5e-324), 0.0, 0.0)
@example((0.0, 5e-324), (-1.7e308, 1.7e308), 1.0, 1.0)
@example((0.1, 0.1), (0.2, 0.2), 0.0, 0.0)
def test_sums_differences_and_products_hold_every_true_value(
    a: Interval, b: Interval, s: float, t: float
) -> None:
    x, y = _between(a, s), _between(b, t)
    assert _holds(intervals.add(a, b), x + y)
    assert _holds(intervals.subtract(a, b), x - y)
    assert _holds(intervals.multiply(a, b), x * y)
    assert _holds(intervals.scale(b[0], a), Fraction(b[0]) * x)
    assert _holds(intervals.square(a), x * x)
    if max(map(abs, a)) < 8e307:  # doubling is not widened: it must not overflow
        assert _holds(intervals.double(a), 2 * x)
    assert _holds(intervals.widen(a, abs(b[1])), x - Fraction(abs(b[1])))
    assert _holds(intervals.widen(a, abs(b[1])), x + Fraction(abs(b[1])))
    assert Fraction(intervals.magnitude(a)) >= abs(x)


@settings(max_examples=300)
@given(intervals_, positive, shares, shares)
def test_quotients_hold_every_true_value(
    a: Interval, b: Interval, s: float, t: float
) -> None:
    assert _holds(intervals.divide(a, b), _between(a, s) / _between(b, t))


@settings(max_examples=200)
@given(
    st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0)).map(
        lambda e: (min(e), max(e))
    ),
    st.integers(0, 12),
    shares,
)
def test_powers_hold_every_true_value(a: Interval, n: int, s: float) -> None:
    found = intervals.power(a, n)
    assert _holds(found, _between(a, s) ** n)
    if n and n % 2 == 0:
        # No negative part but the widening's 1e-300, times 20^12 at most.
        assert found[0] >= -1e-284


@settings(max_examples=200)
@given(intervals_, intervals_, shares, shares, st.floats(0, 1e3), st.floats(0, 1e3))
def test_reach_bounds_the_linear_form(
    a: Interval, b: Interval, s: float, t: float, rx: float, ry: float
) -> None:
    bound = intervals.reach(a, rx, b, ry)
    if math.isfinite(bound):
        exact = abs(_between(a, s)) * Fraction(rx) + abs(_between(b, t)) * Fraction(ry)
        assert Fraction(bound) >= exact


@given(st.floats(min_value=5e-324, allow_infinity=False))
@example(1.0)
@example(5e-324)
@example(1.7976931348623157e308)
@example(1.0 + 2.0**-52)
@example(1.0 - 2.0**-53)
def test_the_bounds_of_a_logarithm_enclose_the_one_in_extended_precision(
    x: float,
) -> None:
    low, high = log_bounds(x)
    assert low <= np.log(np.longdouble(x)) <= high
    # Sharp enough to be of use: 20 units in the last place.
    assert high - low <= 20 * 2.0**-52 * (abs(high) + 1.0)


@pytest.mark.parametrize("operation", ["add", "subtract", "multiply"])
def test_ordinary_results_are_widened_by_two_units_in_the_last_place_at_most(
    operation: str,
) -> None:
    run: Callable[[Interval, Interval], Interval] = getattr(intervals, operation)
    rng = np.random.default_rng(8)
    for x, y in rng.uniform(-10.0, 10.0, (200, 2)).tolist():
        low, high = run((x, x), (y, y))
        # Each end moves by 2^-52 |x| after rounding; spacing is at least 2^-53 |x|.
        assert high - low <= 6 * math.ulp(max(abs(low), abs(high)))
