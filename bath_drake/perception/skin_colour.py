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
    x, y, value, smooth = _prepared(
        np.ascontiguousarray(observation.pixels),
        np.ascontiguousarray(observation.colours),
    )
    off = _with_ratios(value, np.log(np.maximum(smooth, LEAST_COLOUR)))
    usual = np.array([DARK_SHARE, 1.0, 1.0]) * _medians(off)
    skin = _near_usual(off, usual, 2.0 * OFF_COLOUR)
    deviations = np.zeros((n, 3))
    for k in range(ROUNDS):
        if k > 0:
            skin = ~off_skin(deviations)
        if np.count_nonzero(skin) < MIN_POINTS:
            return np.zeros((n, 3))
        moments, sums = _normal_equations(x, y, off, skin)
        fit = np.ascontiguousarray(np.linalg.lstsq(moments, sums, rcond=None)[0])
        deviations = _off_quadratics(x, y, off, fit)
    return deviations


def off_skin(deviations: FloatArray) -> BoolArray:
    """Returns which of `skin_deviations` (n, 3) are no skin's."""
    if len(deviations) == 0:
        return np.zeros(0, dtype=bool)
    deviations = np.ascontiguousarray(deviations)
    # Of a normal distribution the median of the absolute is 0.674 deviations.
    limits = np.full(2, OFF_COLOUR)
    # Where more than half is quiet enough the noise decides nothing.
    if 2 * (_quiet(deviations, 0.674 * OFF_COLOUR / SIGMAS) - 1) < len(deviations):
        noise = _medians(np.abs(deviations[:, 1:])) / 0.674
        limits = np.maximum(OFF_COLOUR, SIGMAS * noise)
    found: BoolArray = _beyond(
        deviations,
        float(np.log(DARK_SHARE)),
        float(np.log(BRIGHT_SHARE)),
        limits,
    )
    return found


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
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Returns what is fitted, of pixels (n, 2) that are sorted by row.

    Returns:
        (n,) columns and rows from their means, in hundreds of pixels; the largest of
        each colour (n,); its mean (n, 3) over the neighbours that are points too.
    """
    count = len(pixels)
    left, right, column_sum, row_sum = int(pixels[0, 0]), int(pixels[0, 0]), 0, 0
    for i in range(count):
        left, right = min(left, pixels[i, 0]), max(right, pixels[i, 0])
        column_sum += pixels[i, 0]
        row_sum += pixels[i, 1]
    top = pixels[0, 1]
    index = np.full((pixels[-1, 1] - top + 3, right - left + 3), -1, dtype=np.int32)
    x, y, value = np.empty(count), np.empty(count), np.empty(count)
    for i in range(count):
        u, v = pixels[i, 0], pixels[i, 1]
        index[v - top + 1, u - left + 1] = i
        x[i] = (u - column_sum / count) / 100.0
        y[i] = (v - row_sum / count) / 100.0
        value[i] = max(colours[i, 0], colours[i, 1], colours[i, 2])
    means = np.empty((count, 3))
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
        means[i, 0], means[i, 1] = red / near, green / near
        means[i, 2] = blue / near
    return x, y, value, means


@njit(cache=True)
def _with_ratios(value: FloatArray, logs: FloatArray) -> FloatArray:
    """Returns (n, 3) values, red over green and green over blue as logarithms."""
    off = np.empty(logs.shape)
    for i in range(len(value)):
        off[i, 0] = value[i]
        off[i, 1], off[i, 2] = logs[i, 0] - logs[i, 1], logs[i, 1] - logs[i, 2]
    return off


@njit(cache=True)
def _normal_equations(
    x: FloatArray, y: FloatArray, values: FloatArray, used: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Returns the (6, 6) and (6, 3) of the least-squares fits of quadratics."""
    moments = np.zeros((6, 6))
    sums = np.zeros((6, 3))
    row = np.empty(6)
    for i in range(len(x)):
        if not used[i]:
            continue
        row[0], row[1], row[2] = 1.0, x[i], y[i]
        row[3], row[4], row[5] = x[i] * x[i], x[i] * y[i], y[i] * y[i]
        for j in range(6):
            for k in range(3):
                sums[j, k] += row[j] * values[i, k]
            for k in range(j + 1):
                moments[j, k] += row[j] * row[k]
    for j in range(6):
        for k in range(j):
            moments[k, j] = moments[j, k]
    return moments, sums


@njit(cache=True)
def _off_quadratics(
    x: FloatArray, y: FloatArray, off: FloatArray, fit: FloatArray
) -> FloatArray:
    """Returns how far (n, 3) brightness, as a logarithm, and ratios are off a fit."""
    out = np.empty((len(x), 3))
    for i in range(len(x)):
        for k in range(3):
            linear = fit[0, k] + fit[1, k] * x[i] + fit[2, k] * y[i]
            square = fit[3, k] * x[i] * x[i] + fit[4, k] * x[i] * y[i]
            out[i, k] = linear + square + fit[5, k] * y[i] * y[i]
        # Below that the ratio is of no use.
        bright = max(out[i, 0], LEAST_BRIGHTNESS)
        out[i, 0] = np.log(max(off[i, 0], 1.0) / bright)
        out[i, 1], out[i, 2] = off[i, 1] - out[i, 1], off[i, 2] - out[i, 2]
    return out
