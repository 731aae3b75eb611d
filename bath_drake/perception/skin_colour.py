"""How far each point's colour is from that of the skin around it.

The person's own skin is the measure, so it serves every tone and light. Shading takes
away from red, green and blue alike: it changes the brightness, by a third and more at
the flanks, but hardly the ratios of the three. So a reddish or bluish patch is told by
its ratios, long before its brightness tells.
"""

import numpy as np
from numba import njit

from bath_drake.notation import BoolArray, ByteArray, FloatArray, IntArray
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import MIN_POINTS

# Darker than this share of the skin around it is no skin. Folds and shading reach
# 0.7, a wound on very dark skin 0.6. Brighter than the second is none either: the
# shine of dry skin stays under 1.2.
DARK_SHARE = 0.7
BRIGHT_SHARE = 1.4

# Logarithm of a ratio of colours, to that of the skin around; and no less than so many
# deviations of what the whole back varies by, which is the camera's noise: on dark skin
# in little light that hides what is only mildly red.
OFF_COLOUR = 0.12
SIGMAS = 5.0

# Each is a quadratic in the pixel, fitted again without what is no skin so many times.
ROUNDS = 3

# Fits below a tenth of a byte's range are taken for that, and so are colours of which
# a ratio is taken below the second.
LEAST_BRIGHTNESS = 25.0
LEAST_COLOUR = 4.0


def skin_deviations(observation: BodyObservation) -> FloatArray:
    """Returns (n, 3) for each visible point, all zero on perfectly even skin.

    The logarithms of its brightness (largest of red, green and blue), of its red over
    green and of its green over blue, each less that of the skin around it. The ratios
    are of the means over three by three pixels: they carry more noise. Of a back of too
    few points, or with too little skin of one colour on it, all are zero.
    """
    n = len(observation.points_W)
    if n < MIN_POINTS:
        return np.zeros((n, 3))
    # Of order one, so that the normal equations are well conditioned.
    x, y, off = _prepared(
        np.ascontiguousarray(observation.pixels),
        np.ascontiguousarray(observation.colours),
    )
    usual = np.array([DARK_SHARE, 1.0, 1.0]) * _medians(off)
    skin = _near_usual(off, usual, 2.0 * OFF_COLOUR)
    deviations = np.zeros((n, 3))
    for k in range(ROUNDS):
        if k > 0:
            limits = _limits(deviations)
            skin = ~_beyond(deviations, DARK_SHARE, BRIGHT_SHARE, limits)
        if np.count_nonzero(skin) < MIN_POINTS:
            return np.zeros((n, 3))
        moments, sums = _normal_equations(x, y, off, skin)
        fit = np.ascontiguousarray(np.linalg.lstsq(moments, sums, rcond=None)[0])
        deviations = _off_quadratics(x, y, off, fit)
    _take_logarithms(deviations)
    return deviations


def off_skin(deviations: FloatArray) -> BoolArray:
    """Returns which of `skin_deviations` (n, 3) are no skin's."""
    if len(deviations) == 0:
        return np.zeros(0, dtype=bool)
    deviations = np.ascontiguousarray(deviations)
    low, high = float(np.log(DARK_SHARE)), float(np.log(BRIGHT_SHARE))
    return np.asarray(_beyond(deviations, low, high, _limits(deviations)))


def _limits(deviations: FloatArray) -> FloatArray:
    """Returns what the ratios (2,) of skin are not off by, the noise considered."""
    # Where more than half is quiet enough the noise decides nothing.
    quiet = _quiet(deviations, 0.674 * OFF_COLOUR / SIGMAS)
    if 2 * (quiet - 1) >= len(deviations):
        return np.full(2, OFF_COLOUR)
    # Of a normal distribution the median of the absolute is 0.674 deviations.
    noise = _medians(np.abs(deviations[:, 1:])) / 0.674
    return np.maximum(OFF_COLOUR, SIGMAS * noise)


def _medians(columns: FloatArray) -> FloatArray:
    """Returns the (m,) medians of finite numbers (n, m), n > 0; numpy's, but faster."""
    half = len(columns) // 2
    medians = np.empty(columns.shape[1])
    for k, column in enumerate(np.array(columns.T, order="C")):
        column.partition(half)
        medians[k] = column[half]
        if len(column) % 2 == 0:
            medians[k] = 0.5 * (column[:half].max() + column[half])
    return medians


@njit(cache=True)
def _near_usual(off: FloatArray, usual: FloatArray, limit: float) -> BoolArray:
    """Which are brighter than the first of `usual`, and near the others."""
    near = np.empty(len(off), dtype=np.bool_)
    for i in range(len(off)):
        near[i] = (
            off[i, 0] > usual[0]
            and abs(off[i, 1] - usual[1]) < limit
            and abs(off[i, 2] - usual[2]) < limit
        )
    return near


@njit(cache=True)
def _beyond(
    deviations: FloatArray, dark: float, bright: float, limits: FloatArray
) -> BoolArray:
    beyond = np.empty(len(deviations), dtype=np.bool_)
    for i in range(len(deviations)):
        brightness, first, second = deviations[i]
        beyond[i] = (
            brightness <= dark
            or brightness >= bright
            or abs(first) >= limits[0]
            or abs(second) >= limits[1]
        )
    return beyond


@njit(cache=True)
def _quiet(deviations: FloatArray, most: float) -> int:
    """How many have a ratio this little off, of that of the two that has fewer."""
    first = second = 0
    for i in range(len(deviations)):
        first += abs(deviations[i, 1]) < most
        second += abs(deviations[i, 2]) < most
    return min(first, second)


@njit(cache=True)
def _prepared(
    pixels: IntArray, colours: ByteArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Returns what is fitted, of pixels (n, 2), columns and rows.

    Returns:
        (n,) columns and rows from their means, in hundreds of pixels; (n, 3) the
        largest of each colour, and the logarithms of red over green and green over
        blue, of means over the neighbours that are points too.
    """
    count = len(pixels)
    left, top = pixels[0, 0], pixels[0, 1]
    right, bottom, column_sum, row_sum = left, top, 0, 0
    for i in range(count):
        u, v = pixels[i, 0], pixels[i, 1]
        left, right = min(left, u), max(right, u)
        top, bottom = min(top, v), max(bottom, v)
        column_sum += u
        row_sum += v
    index = np.full((bottom - top + 3, right - left + 3), -1, dtype=np.int32)
    x, y, off = np.empty(count), np.empty(count), np.empty((count, 3))
    for i in range(count):
        u, v = pixels[i, 0], pixels[i, 1]
        index[v - top + 1, u - left + 1] = i
        x[i] = (u - column_sum / count) / 100.0
        y[i] = (v - row_sum / count) / 100.0
        off[i, 0] = max(colours[i, 0], colours[i, 1], colours[i, 2])
    for i in range(count):
        u, v = pixels[i, 0] - left, pixels[i, 1] - top
        near, red, green, blue = 0, 0, 0, 0
        for row in range(v, v + 3):
            for column in range(u, u + 3):
                j = index[row, column]
                if j >= 0:
                    near += 1
                    red += int(colours[j, 0])
                    green += int(colours[j, 1])
                    blue += int(colours[j, 2])
        more_red = max(red / near, LEAST_COLOUR) / max(green / near, LEAST_COLOUR)
        more_green = max(green / near, LEAST_COLOUR) / max(blue / near, LEAST_COLOUR)
        off[i, 1], off[i, 2] = np.log(more_red), np.log(more_green)
    return x, y, off


@njit(cache=True)
def _normal_equations(
    x: FloatArray, y: FloatArray, values: FloatArray, used: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Returns the (6, 6) and (6, 3) of the least-squares fits of quadratics."""
    # Each by its own name stays in the processor; in arrays it takes twice as long.
    n = mx = my = mxx = mxy = myy = 0.0
    xxx = xxy = xyy = yxx = yxy = yyy = 0.0
    xxxx = xxxy = xxyy = xyxy = xyyy = yyyy = 0.0
    a0 = a1 = a2 = b0 = b1 = b2 = c0 = c1 = c2 = 0.0
    d0 = d1 = d2 = e0 = e1 = e2 = f0 = f1 = f2 = 0.0
    for i in range(len(x)):
        if not used[i]:
            continue
        p, q = x[i], y[i]
        pp, pq, qq = p * p, p * q, q * q
        n, mx, my = n + 1.0, mx + p, my + q
        mxx, mxy, myy = mxx + pp, mxy + pq, myy + qq
        xxx, xxy, xyy = xxx + p * pp, xxy + p * pq, xyy + p * qq
        yxx, yxy, yyy = yxx + q * pp, yxy + q * pq, yyy + q * qq
        xxxx, xxxy, xxyy = xxxx + pp * pp, xxxy + pp * pq, xxyy + pp * qq
        xyxy, xyyy, yyyy = xyxy + pq * pq, xyyy + pq * qq, yyyy + qq * qq
        u, v, w = values[i, 0], values[i, 1], values[i, 2]
        a0, a1, a2 = a0 + u, a1 + v, a2 + w
        b0, b1, b2 = b0 + p * u, b1 + p * v, b2 + p * w
        c0, c1, c2 = c0 + q * u, c1 + q * v, c2 + q * w
        d0, d1, d2 = d0 + pp * u, d1 + pp * v, d2 + pp * w
        e0, e1, e2 = e0 + pq * u, e1 + pq * v, e2 + pq * w
        f0, f1, f2 = f0 + qq * u, f1 + qq * v, f2 + qq * w
    moments = np.array(
        [
            [n, mx, my, mxx, mxy, myy],
            [mx, mxx, mxy, xxx, xxy, xyy],
            [my, mxy, myy, yxx, yxy, yyy],
            [mxx, xxx, yxx, xxxx, xxxy, xxyy],
            [mxy, xxy, yxy, xxxy, xyxy, xyyy],
            [myy, xyy, yyy, xxyy, xyyy, yyyy],
        ]
    )
    sums = np.array(
        [
            [a0, a1, a2],
            [b0, b1, b2],
            [c0, c1, c2],
            [d0, d1, d2],
            [e0, e1, e2],
            [f0, f1, f2],
        ]
    )
    return moments, sums


@njit(cache=True)
def _off_quadratics(
    x: FloatArray, y: FloatArray, off: FloatArray, fit: FloatArray
) -> FloatArray:
    """Returns how far (n, 3) brightness, as a ratio, and ratios are off a fit."""
    out = np.empty((len(x), 3))
    for i in range(len(x)):
        for k in range(3):
            linear = fit[0, k] + fit[1, k] * x[i] + fit[2, k] * y[i]
            square = fit[3, k] * x[i] * x[i] + fit[4, k] * x[i] * y[i]
            out[i, k] = linear + square + fit[5, k] * y[i] * y[i]
        # Below that the ratio is of no use.
        bright = max(out[i, 0], LEAST_BRIGHTNESS)
        out[i, 0] = max(off[i, 0], 1.0) / bright
        out[i, 1], out[i, 2] = off[i, 1] - out[i, 1], off[i, 2] - out[i, 2]
    return out


@njit(cache=True)
def _take_logarithms(deviations: FloatArray) -> None:
    for i in range(len(deviations)):
        deviations[i, 0] = np.log(deviations[i, 0])
