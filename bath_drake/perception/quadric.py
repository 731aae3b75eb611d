"""The quadric fit of a patch of skin, compiled: one place, or many at once."""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray, IntArray

# Fewer points than this do not hold a quadric's six coefficients against noise.
MIN_COUNT = 40

# Directions around the point are told apart in this many sectors; one with less
# than this share of the points is empty, and half a turn of empty ones is one-sided.
SECTORS = 8
SECTOR_SHARE = 0.02

# Numbers in a fit's row, see `fit_quadric`.
FIT_SIZE = 13

# How fast skin's curvature changes, 1/m^2: what a quadric cannot follow. Measured on
# people of several builds; with it the predicted and the true errors agree.
CURVATURE_CHANGE = 8.0

# A fit is trusted if its normal is within this angle (rad) of the true one with at
# least this probability; it is predicted, see `quality`.
GOOD_ANGLE = np.deg2rad(3.0)
MIN_QUALITY = 0.3

# Newton steps down the line through the point; the quadric is nearly flat.
STEPS = 4


@njit(cache=True)
def gather(
    points_W: FloatArray, R_WP: FloatArray, p_WQ: FloatArray, radius: float
) -> FloatArray:
    """Returns the points near the line, in P's axes from Q; one pass, no index."""
    near = np.empty((len(points_W), 3))
    count = 0
    for i in range(len(points_W)):
        dx = points_W[i, 0] - p_WQ[0]
        dy = points_W[i, 1] - p_WQ[1]
        dz = points_W[i, 2] - p_WQ[2]
        x = dx * R_WP[0, 0] + dy * R_WP[1, 0] + dz * R_WP[2, 0]
        y = dx * R_WP[0, 1] + dy * R_WP[1, 1] + dz * R_WP[2, 1]
        if x * x + y * y <= radius * radius:
            near[count, 0] = x
            near[count, 1] = y
            near[count, 2] = dx * R_WP[0, 2] + dy * R_WP[1, 2] + dz * R_WP[2, 2]
            count += 1
    return near[:count].copy()


def by_cell(
    p_P: FloatArray, size: float
) -> tuple[FloatArray, IntArray, IntArray, FloatArray, float]:
    """Sorts points (n, 3) into square cells of the plane.

    Returns:
        The points, cell after cell; where each cell begins, and the last ends; how
        many cells there are along both axes; the corner of the first; its size.
    """
    low = p_P[:, :2].min(axis=0)
    cells = ((p_P[:, :2] - low) / size).astype(np.int64)
    counts = cells.max(axis=0) + 1
    index = cells[:, 0] * counts[1] + cells[:, 1]
    order = np.argsort(index, kind="stable")
    begins = np.zeros(int(counts[0] * counts[1]) + 1, dtype=np.int64)
    np.cumsum(np.bincount(index, minlength=len(begins) - 1), out=begins[1:])
    return np.ascontiguousarray(p_P[order]), begins, counts, low, size


@njit(cache=True)
def fit_all(
    points: FloatArray,
    begins: IntArray,
    counts: IntArray,
    low: FloatArray,
    size: float,
    queries: FloatArray,
    radii: FloatArray,
) -> FloatArray:
    """Returns the rows of `fit_quadric` for points (m, 2) of the plane."""
    fits = np.empty((len(queries), FIT_SIZE))
    near = np.empty((len(points), 3))
    for k in range(len(queries)):
        x, y = queries[k, 0], queries[k, 1]
        a, b = int(np.floor((x - low[0]) / size)), int(np.floor((y - low[1]) / size))
        for n in range(len(radii)):
            radius = radii[n]
            count = 0
            for i in range(max(a - 1, 0), min(a + 2, counts[0])):
                for j in range(max(b - 1, 0), min(b + 2, counts[1])):
                    cell = i * counts[1] + j
                    for p in range(begins[cell], begins[cell + 1]):
                        dx, dy = points[p, 0] - x, points[p, 1] - y
                        if dx * dx + dy * dy <= radius * radius:
                            near[count, 0], near[count, 1] = dx, dy
                            near[count, 2] = points[p, 2]
                            count += 1
            fit = fit_around(near[:count], radius)
            for i in range(FIT_SIZE):
                fits[k, i] = fit[i]
            if fit[11] > 0.5:
                break
    return fits


@njit(cache=True)
def fit_around(near: FloatArray, radius: float) -> FloatArray:
    """Returns the row of a fit that can be trusted, or that of `no_fit`."""
    if determined(near):
        fit = fit_quadric(near, radius)
        if quality(fit[12]) >= MIN_QUALITY:
            return fit
    return no_fit(len(near), radius)


@njit(cache=True)
def quality(deviation: float) -> float:
    """Returns how probable it is that a normal is within `GOOD_ANGLE` of the true one.

    Args:
        deviation: Predicted root mean square of the angle between the two, rad. It
            is that of two components of one normal distribution each.
    """
    if not deviation < np.inf:
        return 0.0
    return 1.0 - np.exp(-((GOOD_ANGLE / deviation) ** 2)) if deviation > 0.0 else 1.0


@njit(cache=True)
def determined(near: FloatArray) -> bool:
    """Whether points around a line hold a quadric against noise."""
    return len(near) >= MIN_COUNT and not _one_sided(near)


@njit(cache=True)
def no_fit(count: int, radius: float) -> FloatArray:
    """A row like that of `fit_quadric`: the plane's own point and normal, not valid."""
    row = np.zeros(FIT_SIZE)
    row[5], row[8], row[10], row[12] = 1.0, count, radius, np.inf
    return row


@njit(cache=True)
def _one_sided(near: FloatArray) -> bool:
    counts = np.zeros(SECTORS)
    for i in range(len(near)):
        turn = np.arctan2(near[i, 1], near[i, 0]) / (2.0 * np.pi) % 1.0
        counts[int(turn * SECTORS) % SECTORS] += 1.0
    run = longest = 0
    for k in range(2 * SECTORS):  # twice around: runs may wrap
        empty = counts[k % SECTORS] < SECTOR_SHARE * len(near)
        run = run + 1 if empty else 0
        longest = max(longest, run)
    return longest >= SECTORS // 2


@njit(cache=True)
def fit_quadric(near: FloatArray, radius: float) -> FloatArray:
    """Fits a quadric to points around a line along P's normal.

    Args:
        near: (n, 3) in P's axes from where the line meets the plane.
        radius: Of the neighbourhood.

    Returns:
        A row: the point (3) and the unit normal (3) in P's axes, the two principal
        curvatures, the count, the rms residual, the radius, one for valid, and how
        far the normal is off, rms, as predicted (rad).
    """
    # A plane first: in its axes the skin is level, however steep a flank is in P's.
    moments3, sums3 = _plane_equations(near)
    a, b, c = np.linalg.solve(moments3, sums3)
    R_PT = _tangent_axes(a, b)
    moments, sums, squares = _quadric_equations(near, R_PT, c, radius)
    # With the columns of the inverse that belong to the two slopes, in one go.
    wanted = np.zeros((6, 3))
    for i in range(6):
        wanted[i, 0] = sums[i]
    wanted[3, 1], wanted[4, 2] = 1.0, 1.0
    solved: FloatArray = np.asarray(np.linalg.solve(moments, wanted))
    k = solved[:, 0].copy()
    # Of a least-squares fit |b - A k|^2 = |b|^2 - k . A' b, up to rounding.
    residual = max(squares - np.dot(k, sums), 0.0) / len(near)
    p_TS, normal_T, curvatures = _meet(k, R_PT[2].copy())
    row = np.empty(FIT_SIZE)
    p_P, normal_P = R_PT @ (p_TS * radius), R_PT @ normal_T
    for i in range(3):
        row[i], row[3 + i] = p_P[i], normal_P[i]
    row[2] += c
    row[6], row[7] = curvatures[0] / radius, curvatures[1] / radius
    row[8], row[9] = len(near), radius * np.sqrt(residual)
    row[10], row[11] = radius, 1.0
    spread = (solved[3, 1] + solved[4, 2]) * len(near)
    row[12] = _normal_deviation(spread, residual, len(near), radius)
    return row


@njit(cache=True)
def _normal_deviation(
    spread: float, residual: float, count: int, radius: float
) -> float:
    """Returns how far off a fitted normal is, rms, rad, predicted.

    Noise is averaged over the points; what the skin has beyond a quadric is not. Both
    tell on the slope as the points' places let them.

    Args:
        spread: How the places let them, one for the best: small where they lie all
            around, large where they lie to one side.
        residual: Mean square of the residuals, in units of the radius.
        count: Of the points.
        radius: m.
    """
    # As many equations as there are coefficients are met exactly.
    noise = residual / max(count - 6.0, 1.0)
    beyond = (CURVATURE_CHANGE * radius * radius) ** 2
    return float(np.sqrt(spread * (noise + beyond)))


@njit(cache=True)
def _plane_equations(near: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Returns the normal equations (3, 3), (3,) of the plane z = a x + b y + c."""
    moments, sums = np.zeros((3, 3)), np.zeros(3)
    row = np.ones(3)
    for i in range(len(near)):
        row[0], row[1] = near[i, 0], near[i, 1]
        _accumulate(row, near[i, 2], moments, sums)
    return moments, sums


@njit(cache=True)
def _quadric_equations(
    near: FloatArray, R_PT: FloatArray, c: float, radius: float
) -> tuple[FloatArray, FloatArray, float]:
    """Returns the normal equations of a height field in T over its tangent plane.

    T has the axes R_PT and its origin at the height `c`; its unit is the radius, so
    that all is of order one and the equations are well conditioned.

    Returns:
        The (6, 6) and (6,) of the coefficients that `_meet` takes, and the sum of
        the squared heights.
    """
    moments, sums = np.zeros((6, 6)), np.zeros(6)
    row = np.ones(6)
    squares = 0.0
    for i in range(len(near)):
        x, y, z = near[i, 0], near[i, 1], near[i, 2] - c
        s = (x * R_PT[0, 0] + y * R_PT[1, 0] + z * R_PT[2, 0]) / radius
        t = (x * R_PT[0, 1] + y * R_PT[1, 1] + z * R_PT[2, 1]) / radius
        h = (x * R_PT[0, 2] + y * R_PT[1, 2] + z * R_PT[2, 2]) / radius
        row[0], row[1], row[2] = s * s / 2.0, s * t, t * t / 2.0
        row[3], row[4] = s, t
        _accumulate(row, h, moments, sums)
        squares += h * h
    return moments, sums, squares


@njit(cache=True)
def _accumulate(
    row: FloatArray, value: float, moments: FloatArray, sums: FloatArray
) -> None:
    """Adds one equation to the normal equations, in place."""
    for j in range(len(row)):
        sums[j] += row[j] * value
        for k in range(len(row)):
            moments[j, k] += row[j] * row[k]


@njit(cache=True)
def _meet(
    k: FloatArray, direction: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Returns where a line through the origin meets a quadric, and its shape there.

    Args:
        k: (6,) the quadric h = k0 s^2/2 + k1 s t + k2 t^2/2 + k3 s + k4 t + k5.
        direction: (3,) of the line, nearly that of h.

    Returns:
        The point (3,), the unit normal (3,) and the principal curvatures (2,),
        falling, positive where the skin bulges out.
    """
    height = 0.0
    for _ in range(STEPS):
        s, t, h = height * direction
        gs, gt = k[0] * s + k[1] * t + k[3], k[1] * s + k[2] * t + k[4]
        quadric = (k[0] * s + 2.0 * k[1] * t) * s / 2.0 + k[2] * t * t / 2.0
        quadric += k[3] * s + k[4] * t + k[5]
        slope = direction[2] - gs * direction[0] - gt * direction[1]
        height -= (h - quadric) / slope
    point = height * direction
    s, t = point[0], point[1]
    gs, gt = k[0] * s + k[1] * t + k[3], k[1] * s + k[2] * t + k[4]
    length = np.sqrt(1.0 + gs * gs + gt * gt)
    # The shape operator of a height field, inverse first form times second form:
    # its eigenvalues are those of mean and Gaussian curvature.
    gauss = (k[0] * k[2] - k[1] * k[1]) / length**4
    mean = (1.0 + gt * gt) * k[0] - 2.0 * gs * gt * k[1] + (1.0 + gs * gs) * k[2]
    mean = -mean / (2.0 * length**3)
    spread = np.sqrt(max(mean * mean - gauss, 0.0))
    normal = np.array([-gs, -gt, 1.0]) / length
    return point, normal, np.array([mean + spread, mean - spread])


@njit(cache=True)
def _tangent_axes(a: float, b: float) -> FloatArray:
    """Returns R_PT of the plane z = a x + b y, its normal last."""
    n = np.array([-a, -b, 1.0]) / np.sqrt(1.0 + a * a + b * b)
    x = np.array([1.0, 0.0, a]) / np.sqrt(1.0 + a * a)
    y = cross(n, x)
    axes = np.empty((3, 3))
    for i in range(3):
        axes[i, 0], axes[i, 1], axes[i, 2] = x[i], y[i], n[i]
    return axes


@njit(cache=True)
def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Returns a x b; numpy's takes ten times as long for two vectors."""
    return np.array(
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    )
