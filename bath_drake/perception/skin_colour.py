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
    columns, rows = observation.pixels.T
    red, green, blue = observation.colours.T
    value = np.maximum(np.maximum(red, green), blue).astype(np.float64)
    smooth = _means(
        np.ascontiguousarray(observation.colours),
        np.ascontiguousarray(rows),
        np.ascontiguousarray(columns),
        *observation.mask.shape,
    )
    logs = np.log(np.maximum(smooth, LEAST_COLOUR))
    ratios = logs[:, :2] - logs[:, 1:]
    # Of order one, so that the normal equations are well conditioned.
    x = np.asarray((columns - columns.mean()) / 100.0, dtype=np.float64)
    y = np.asarray((rows - rows.mean()) / 100.0, dtype=np.float64)
    off = np.column_stack([value, ratios])
    usual = np.array([DARK_SHARE, 1.0, 1.0]) * _medians(off)
    skin = _near_usual(off, usual, 2.0 * OFF_COLOUR)
    deviations = np.zeros((n, 3))
    for _ in range(ROUNDS):
        if np.count_nonzero(skin) < MIN_POINTS:
            return np.zeros((n, 3))
        moments, sums = _normal_equations(x, y, off, skin)
        fit = np.ascontiguousarray(np.linalg.lstsq(moments, sums, rcond=None)[0])
        deviations = _off_quadratics(x, y, off, fit)
        skin = ~off_skin(deviations)
    return deviations


def off_skin(deviations: FloatArray) -> BoolArray:
    """Returns which of `skin_deviations` (n, 3) are no skin's."""
    if len(deviations) == 0:
        return np.zeros(0, dtype=bool)
    # Of a normal distribution the median of the absolute is 0.674 deviations.
    noise = _medians(np.abs(deviations[:, 1:])) / 0.674
    limits = np.maximum(OFF_COLOUR, SIGMAS * noise)
    found: BoolArray = _beyond(
        np.ascontiguousarray(deviations),
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
def _means(
    colours: ByteArray, rows: IntArray, columns: IntArray, height: int, width: int
) -> FloatArray:
    """Returns (n, 3) the mean over each point's neighbours that are points too."""
    index = np.full((height + 2, width + 2), -1, dtype=np.int64)
    for i in range(len(rows)):
        index[rows[i] + 1, columns[i] + 1] = i
    means = np.empty((len(rows), 3))
    for i in range(len(rows)):
        count, red, green, blue = 0, 0.0, 0.0, 0.0
        for row in range(rows[i], rows[i] + 3):
            for column in range(columns[i], columns[i] + 3):
                j = index[row, column]
                if j >= 0:
                    count += 1
                    red += colours[j, 0]
                    green += colours[j, 1]
                    blue += colours[j, 2]
        means[i, 0], means[i, 1] = red / count, green / count
        means[i, 2] = blue / count
    return means


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
