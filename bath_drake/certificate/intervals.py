"""Interval arithmetic, compiled: results hold every possible true value.

An interval is a pair (low, high) of floats. Every operation is done in float64 and
its result then widened by |x| 2^-52 + 1e-300. Rounding to nearest errs by at most
|x| 2^-53 (or 2^-1075 where x is denormal), so twice that, even rounded itself, covers
it. No directed rounding is needed, and no compiler flag may break it: numba's
fastmath stays off, and a fused multiply-add, should one be made, only errs less.

An overflow gives an infinite end and later, where infinities meet, NaN. Comparisons
with NaN are false, and every test of `box_test` asks for a comparison to be true, so
that nothing is ever proved with one.
"""

from numba import njit

Interval = tuple[float, float]

_RELATIVE = 2.0**-52
_ABSOLUTE = 1e-300


@njit(cache=True)
def below(x: float) -> float:
    """A float at most as great as what was rounded to x."""
    return x - (abs(x) * _RELATIVE + _ABSOLUTE)


@njit(cache=True)
def above(x: float) -> float:
    """A float at least as great as what was rounded to x."""
    return x + (abs(x) * _RELATIVE + _ABSOLUTE)


@njit(cache=True)
def point(x: float) -> Interval:
    """The interval of one float, exactly."""
    return x, x


@njit(cache=True)
def add(a: Interval, b: Interval) -> Interval:
    """Sum."""
    return below(a[0] + b[0]), above(a[1] + b[1])


@njit(cache=True)
def subtract(a: Interval, b: Interval) -> Interval:
    """Difference."""
    return below(a[0] - b[1]), above(a[1] - b[0])


@njit(cache=True)
def multiply(a: Interval, b: Interval) -> Interval:
    """Product."""
    p = a[0] * b[0]
    q = a[0] * b[1]
    r = a[1] * b[0]
    s = a[1] * b[1]
    return below(min(min(p, q), min(r, s))), above(max(max(p, q), max(r, s)))


@njit(cache=True)
def scale(t: float, a: Interval) -> Interval:
    """Product with one float."""
    p = t * a[0]
    q = t * a[1]
    return below(min(p, q)), above(max(p, q))


@njit(cache=True)
def double(a: Interval) -> Interval:
    """Twice an interval, exactly."""
    return 2.0 * a[0], 2.0 * a[1]


@njit(cache=True)
def square(a: Interval) -> Interval:
    """Square: never negative, unlike the product with itself."""
    p = a[0] * a[0]
    q = a[1] * a[1]
    if a[0] <= 0.0 and a[1] >= 0.0:
        return 0.0, above(max(p, q))
    return max(0.0, below(min(p, q))), above(max(p, q))


@njit(cache=True)
def divide(a: Interval, b: Interval) -> Interval:
    """Quotient by an interval of positive numbers."""
    low = a[0] / b[1] if a[0] >= 0.0 else a[0] / b[0]
    high = a[1] / b[0] if a[1] >= 0.0 else a[1] / b[1]
    return below(low), above(high)


@njit(cache=True)
def power(a: Interval, n: int) -> Interval:
    """a^n for a whole n >= 0."""
    low = (1.0, 1.0)
    high = (1.0, 1.0)
    if n % 2 == 0:
        s = square(a)
        for _ in range(n // 2):
            low = multiply(low, s)
        return low
    # Odd powers rise: their ends are those of the interval's ends.
    low = point(a[0])
    high = point(a[1])
    s = square(low)
    t = square(high)
    for _ in range(n // 2):
        low = multiply(low, s)
        high = multiply(high, t)
    return low[0], high[1]


@njit(cache=True)
def magnitude(a: Interval) -> float:
    """The greatest absolute value."""
    return max(abs(a[0]), abs(a[1]))


@njit(cache=True)
def widen(a: Interval, r: float) -> Interval:
    """Both ends moved out by r >= 0."""
    return below(a[0] - r), above(a[1] + r)


@njit(cache=True)
def reach(a: Interval, rx: float, b: Interval, ry: float) -> float:
    """An upper bound of |a u + b v| for |u| <= rx and |v| <= ry."""
    return above(above(magnitude(a) * rx) + above(magnitude(b) * ry))
