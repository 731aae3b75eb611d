"""Compiled beta: the boundaries' functions, ln beta and its derivatives at a point.

A world is handed over as ``workspace`` (5,), holding the centre, the semi-axes and
the power, and ``forms`` (Q, 6), one row (cx, cy, A, B, C, w) an obstacle, from
`quadratic_forms`, so that

    beta_i = A dx^2 + 2 B dx dy + C dy^2 - 1

with exponent w, and beta = beta_0 prod_i beta_i^w_i. Only ln beta is ever formed.
"""

import math

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray

# Threads may share the work, and a quotient by zero is IEEE's and not an exception:
# what comes of it is thrown away.
compiled = njit(cache=True, nogil=True, error_model="numpy")
inlined = njit(cache=True, nogil=True, error_model="numpy", forceinline=True)

# Points farther out are moved here first: their squares must stay finite.
FAR = 1e70
# What stands for beta_i = 0 in phi's derivatives: as 1 - t it is either zero or at
# least 1e-16, so that the limit is met to the last digit.
TINY = 1e-100
# Products within this and its inverse may take one more factor without a logarithm.
_WIDE = 1e80


@inlined
def near(x: float) -> float:
    """The nearest number whose square is finite."""
    return min(max(x, -FAR), FAR)


@compiled
def quadratic_forms(theta: FloatArray, exponents: FloatArray) -> FloatArray:
    """Turns ellipse rows (Q, 5) and exponents (Q,) into rows of forms (Q, 6)."""
    forms = np.empty((theta.shape[0], 6))
    for i in range(theta.shape[0]):
        c = math.cos(theta[i, 4])
        s = math.sin(theta[i, 4])
        p = min(1.0 / (theta[i, 2] * theta[i, 2]), FAR)
        r = min(1.0 / (theta[i, 3] * theta[i, 3]), FAR)
        forms[i, 0] = near(theta[i, 0])
        forms[i, 1] = near(theta[i, 1])
        forms[i, 2] = c * c * p + s * s * r
        forms[i, 3] = c * s * (p - r)
        forms[i, 4] = s * s * p + c * c * r
        forms[i, 5] = exponents[i]
    return forms


@inlined
def even_powers(t: float, power: float) -> tuple[float, float, float]:
    """|t|^p, its first and its second derivative, for an even p >= 2."""
    if power == 2.0:
        return t * t, 2.0 * t, 2.0
    t = near(t)
    low = 1.0  # |t|^(p - 2), as far as the rest stays finite
    for _ in range(int(power) // 2 - 1):
        low = min(low * (t * t), FAR)
    return low * t * t, power * low * t, power * (power - 1.0) * low


@inlined
def _rim(x: float, y: float, workspace: FloatArray) -> tuple[float, float, float]:
    """beta_0 and its gradient."""
    u, du, _ = even_powers((x - workspace[0]) / workspace[2], workspace[4])
    v, dv, _ = even_powers((y - workspace[1]) / workspace[3], workspace[4])
    return max(1.0 - u - v, -1e300), -du / workspace[2], -dv / workspace[3]


@inlined
def _ellipse(
    x: float, y: float, forms: FloatArray, i: int
) -> tuple[float, float, float]:
    """beta_i and half its gradient."""
    dx = x - forms[i, 0]
    dy = y - forms[i, 1]
    hx = forms[i, 2] * dx + forms[i, 3] * dy
    hy = forms[i, 3] * dx + forms[i, 4] * dy
    return dx * hx + dy * hy - 1.0, hx, hy


@compiled
def min_beta(x: float, y: float, workspace: FloatArray, forms: FloatArray) -> float:
    """The smallest of all beta_i, the workspace's own included."""
    x = near(x)
    y = near(y)
    least = _rim(x, y, workspace)[0]
    for i in range(forms.shape[0]):
        least = min(least, _ellipse(x, y, forms, i)[0])
    return least


@compiled
def sharpest(forms: FloatArray) -> float:
    """One over the smallest semi-axis of all ellipses, zero without any."""
    most = 0.0
    for i in range(forms.shape[0]):
        mean = 0.5 * (forms[i, 2] + forms[i, 4])
        most = max(most, mean + math.hypot(mean - forms[i, 4], forms[i, 3]))
    return math.sqrt(most)


@compiled
def crosses(x: float, y: float, dx: float, dy: float, forms: FloatArray) -> bool:
    """Whether the way from free (x, y) to free (x + dx, y + dy) meets an ellipse."""
    for i in range(forms.shape[0]):
        b, hx, hy = _ellipse(x, y, forms, i)
        # beta_i along it is b + 2 slope t + bend t^2, smallest at -slope / bend.
        slope = hx * dx + hy * dy
        bend = forms[i, 2] * dx * dx + forms[i, 4] * dy * dy
        bend += 2.0 * forms[i, 3] * dx * dy
        if slope < 0.0 and -slope < bend and b * bend <= slope * slope:
            return True
    return False


@inlined
def log_beta(
    x: float,
    y: float,
    workspace: FloatArray,
    forms: FloatArray,
    floor: float,
    valued: bool,
) -> tuple[float, float, float, float]:
    """The gradient s of ln beta, the smallest beta_i, and, if ``valued``, ln beta.

    Every smaller beta_i is replaced by ``floor``. Where the smallest is not positive
    and the floor is zero, only that smallest means anything.
    """
    b, bx, by = _rim(x, y, workspace)
    least = b
    b = max(b, floor)
    sx = bx / b
    sy = by / b
    # One logarithm for all neighbours of one exponent: it costs more than the rest.
    total = 0.0
    product = b
    exponent = 1.0
    for i in range(forms.shape[0]):
        b, hx, hy = _ellipse(x, y, forms, i)
        least = min(least, b)
        b = max(b, floor)
        w = forms[i, 5]
        r = 2.0 * w / b
        sx += r * hx
        sy += r * hy
        if valued:
            if w != exponent or not (1.0 / _WIDE < product < _WIDE):
                total += exponent * math.log(product)
                product = 1.0
                exponent = w
            product *= b
    if valued:
        total += exponent * math.log(product)
    return sx, sy, least, total


@inlined
def unit(vx: float, vy: float) -> tuple[float, float]:
    n = math.sqrt(vx * vx + vy * vy)
    if not (1e-150 < n < 1e150):
        big = max(abs(vx), abs(vy))
        if big == 0.0:
            return 0.0, 0.0
        vx /= big
        vy /= big
        n = math.sqrt(vx * vx + vy * vy)
    return vx / n, vy / n


@compiled
def normal(
    x: float, y: float, workspace: FloatArray, forms: FloatArray
) -> tuple[float, float]:
    """On a boundary: its unit normal into free space."""
    b, sx, sy = _rim(x, y, workspace)
    if b > 0.0:
        sx = 0.0
        sy = 0.0
    for i in range(forms.shape[0]):
        b, hx, hy = _ellipse(x, y, forms, i)
        if b == 0.0:
            sx += 2.0 * forms[i, 5] * hx
            sy += 2.0 * forms[i, 5] * hy
    return unit(sx, sy)


@inlined
def curvature(
    x: float, y: float, workspace: FloatArray, forms: FloatArray, floor: float
) -> tuple[float, float, float, float, float]:
    """Both s and Hess(beta) / beta (xx, xy, yy), with no beta_i below ``floor``.

    Built factor by factor: for exponent 1 nothing grows faster than 1 / beta_i near a
    boundary, so nothing of order 1 / beta_i^2 has to cancel.
    """
    u, du, ddu = even_powers((x - workspace[0]) / workspace[2], workspace[4])
    v, dv, ddv = even_powers((y - workspace[1]) / workspace[3], workspace[4])
    b = max(1.0 - u - v, floor)
    sx = -du / workspace[2] / b
    sy = -dv / workspace[3] / b
    hxx = -ddu / (workspace[2] * workspace[2]) / b
    hxy = 0.0
    hyy = -ddv / (workspace[3] * workspace[3]) / b
    for i in range(forms.shape[0]):
        b, hx, hy = _ellipse(x, y, forms, i)
        r = 2.0 / max(b, floor)
        px = r * hx
        py = r * hy
        w = forms[i, 5]
        r *= w
        qx = w * px
        qy = w * py
        hxx += r * forms[i, 2] + qx * (2.0 * sx + (qx - px))
        hxy += r * forms[i, 3] + qx * (sy + (qy - py)) + qy * sx
        hyy += r * forms[i, 4] + qy * (2.0 * sy + (qy - py))
        sx += qx
        sy += qy
    return sx, sy, hxx, hxy, hyy


# Points that `slopes` does at once: registers of four or eight numbers, filled twice
# or more; the figure must be known to the compiler.
LANES = 16


@inlined
def slopes(lanes: FloatArray, workspace: FloatArray, forms: FloatArray) -> None:
    """`log_beta`'s s and least beta, bit by bit, of ``LANES`` points at once.

    ``lanes`` (5 LANES,) holds all x, then all y, and takes s_x, s_y and the least beta:
    one array, because between several the compiler would have to rule out overlaps.
    """
    for j in range(LANES):
        b, bx, by = _rim(lanes[j], lanes[LANES + j], workspace)
        lanes[2 * LANES + j] = bx / b
        lanes[3 * LANES + j] = by / b
        lanes[4 * LANES + j] = b
    for i in range(forms.shape[0]):
        cx, cy = forms[i, 0], forms[i, 1]
        xx, xy, yy = forms[i, 2], forms[i, 3], forms[i, 4]
        w = 2.0 * forms[i, 5]
        for j in range(LANES):
            dx = lanes[j] - cx
            dy = lanes[LANES + j] - cy
            hx = xx * dx + xy * dy
            hy = xy * dx + yy * dy
            b = dx * hx + dy * hy - 1.0
            r = w / b
            lanes[2 * LANES + j] += r * hx
            lanes[3 * LANES + j] += r * hy
            least = lanes[4 * LANES + j]
            lanes[4 * LANES + j] = b if b < least else least


@inlined
def values(
    lanes: FloatArray, workspace: FloatArray, forms: FloatArray, out: FloatArray
) -> None:
    """`log_beta`'s ln beta, bit by bit, at the points of `slopes`: ``out`` (2 LANES,).

    The first half is the answer, the second holds the products. Only where the least
    beta is positive does it mean anything.
    """
    for j in range(LANES):
        out[j] = 0.0
        out[LANES + j] = _rim(lanes[j], lanes[LANES + j], workspace)[0]
    exponent = 1.0
    for i in range(forms.shape[0]):
        w = forms[i, 5]
        outside = 0
        for j in range(LANES):
            product = out[LANES + j]
            outside += 0 if 1.0 / _WIDE < product < _WIDE else 1
        if w != exponent or outside > 0:
            for j in range(LANES):
                product = out[LANES + j]
                if w != exponent or not (1.0 / _WIDE < product < _WIDE):
                    out[j] += exponent * math.log(product)
                    out[LANES + j] = 1.0
            exponent = w
        cx, cy = forms[i, 0], forms[i, 1]
        xx, xy, yy = forms[i, 2], forms[i, 3], forms[i, 4]
        for j in range(LANES):
            dx = lanes[j] - cx
            dy = lanes[LANES + j] - cy
            hx = xx * dx + xy * dy
            hy = xy * dx + yy * dy
            out[LANES + j] *= dx * hx + dy * hy - 1.0
    for j in range(LANES):
        out[j] += exponent * math.log(out[LANES + j])
