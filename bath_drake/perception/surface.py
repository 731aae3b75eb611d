"""The skin at one point: position, normal and curvature by a quadric fit.

The paper takes the local attributes of the surface from the depth data (Sec.
IV-B). A quadric over a few centimetres averages the sensor's noise and, unlike a
plane, is not biased where the back is round.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray
from bath_drake.perception.canonical import CanonicalMap

# Fewer points than this do not hold a quadric's six coefficients against noise.
MIN_COUNT = 40

# A wider neighbourhood is tried where the first is thin or one-sided; beyond the
# largest radius (metres) the skin is no quadric any more.
WIDENING = (1.0, 1.4, 2.0)
MAX_RADIUS = 0.06

# Directions around the point are told apart in this many sectors; one with less
# than this share of the points is empty, and half a turn of empty ones is one-sided.
SECTORS = 8
SECTOR_SHARE = 0.02

# Newton steps down the line through the point; the quadric is nearly flat.
STEPS = 4


@dataclass(frozen=True, eq=False)
class SurfacePatch:
    """A second-order patch of skin around the washed point.

    Attributes:
        p_WS: (3,) the point on the skin, metres.
        normal_W: (3,) outward unit normal.
        curvatures: (2,) principal curvatures, 1/m, falling; positive bulges out.
        count: Points the fit rests on.
        rms: Residual of the fit, metres.
        radius: Radius of the fitted neighbourhood, metres.
        valid: False if the points did not determine a patch; then `p_WS` and
            `normal_W` are those of the back's plane and must not be washed at.
    """

    p_WS: FloatArray
    normal_W: FloatArray
    curvatures: FloatArray
    count: int
    rms: float
    radius: float
    valid: bool


def fit_surface(
    points_W: FloatArray,
    canonical_map: CanonicalMap,
    p_NQ: FloatArray,
    radius: float = 0.03,
) -> SurfacePatch:
    """Fits the skin where the line through a canonical point meets it.

    Args:
        points_W: (n, 3) visible points of the back, metres.
        canonical_map: Where the back is.
        p_NQ: (2,) the canonical point; the line is along the plane's normal.
        radius: Points within this distance of the line are fitted; up to
            `MAX_RADIUS` if those are too few or lie on one side.

    Returns:
        The patch; `valid` is False if even the widest neighbourhood is too thin.

    Raises:
        ValueError: If the radius is not positive or the point not finite.
    """
    if not 0.0 < radius <= MAX_RADIUS:
        raise ValueError(f"radius must be in (0, {MAX_RADIUS}] m, got {radius}")
    p_NQ = np.asarray(p_NQ, dtype=np.float64)
    if p_NQ.shape != (2,) or not np.isfinite(p_NQ).all():
        raise ValueError(f"p_NQ must be two finite numbers, got {p_NQ}")
    p_WQ = canonical_map.world_from_canonical(p_NQ)
    R_WP = np.ascontiguousarray(canonical_map.R_WP)
    points_W = np.ascontiguousarray(points_W, dtype=np.float64)
    near = np.empty((0, 3))
    for factor in WIDENING:
        radius_now = min(factor * radius, MAX_RADIUS)
        near = _gather(points_W, R_WP, p_WQ, radius_now)
        if len(near) >= MIN_COUNT and not _one_sided(near):
            return _fit(near, R_WP, p_WQ, radius_now)
    return SurfacePatch(
        p_WS=p_WQ,
        normal_W=canonical_map.normal_W,
        curvatures=np.zeros(2),
        count=len(near),
        rms=0.0,
        radius=radius_now,
        valid=False,
    )


@njit(cache=True)
def _gather(
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


def _fit(
    near: FloatArray, R_WP: FloatArray, p_WQ: FloatArray, radius: float
) -> SurfacePatch:
    # A plane first: in its axes the skin is level, however steep a flank is in P's.
    a, b, c = np.linalg.solve(*_plane_equations(near))
    R_PT = _tangent_axes(a, b)
    moments, sums, squares = _quadric_equations(near, R_PT, c, radius)
    k = np.asarray(np.linalg.solve(moments, sums))
    # Of a least-squares fit |b - A k|^2 = |b|^2 - k . A' b, up to rounding.
    residual = max(float(squares - k @ sums), 0.0) / len(near)
    p_TS, normal_T, curvatures = _meet(k, R_PT[2].copy())
    p_PS = R_PT @ (p_TS * radius)
    p_PS[2] += c
    return SurfacePatch(
        p_WS=p_WQ + R_WP @ p_PS,
        normal_W=R_WP @ R_PT @ normal_T,
        curvatures=curvatures / radius,
        count=len(near),
        rms=radius * float(np.sqrt(residual)),
        radius=radius,
        valid=True,
    )


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


def _tangent_axes(a: float, b: float) -> FloatArray:
    """Returns R_PT of the plane z = a x + b y, its normal last."""
    n = np.array([-a, -b, 1.0]) / np.sqrt(1.0 + a * a + b * b)
    x = np.array([1.0, 0.0, a]) / np.sqrt(1.0 + a * a)
    return np.column_stack([x, _cross(n, x), n])


@njit(cache=True)
def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Returns a x b; numpy's takes ten times as long for two vectors."""
    return np.array(
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    )


def desired_nozzle_pose(
    patch: SurfacePatch,
    standoff: float,
    canonical_map: CanonicalMap,
    roll: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """Returns where the nozzle should be: square to the skin, off it by `standoff`.

    Args:
        patch: The skin at the washed point.
        standoff: Distance of the nozzle's tip from the skin, metres.
        canonical_map: Gives the patient's up, to which the roll refers.
        roll: Angle of the nozzle's x axis about its z axis from the patient's up,
            radians; constant, so that the wrist does not spin along the path.

    Returns:
        R_WE (3, 3) and p_WE (3,): z along the inward normal.

    Raises:
        ValueError: If the normal is along the patient's up.
    """
    z = -patch.normal_W
    up = canonical_map.R_WP[:, 1]
    x = up - (up @ z) * z
    length = np.linalg.norm(x)
    if not length > 1e-6:
        raise ValueError("the skin's normal is along the patient's up: no roll")
    x /= length
    x = np.cos(roll) * x + np.sin(roll) * _cross(z, x)
    R_WE = np.column_stack([x, _cross(z, x), z])
    return R_WE, patch.p_WS + standoff * patch.normal_W


def height_over(patch: SurfacePatch, p_WQ: FloatArray) -> float:
    """Returns how high a point (3,) is over the patch, along its normal, m.

    A patch speaks for its own neighbourhood: beside it, more than twice the fitted
    radius away along the skin, or where it is not valid, the answer is infinite.
    """
    if not patch.valid:
        return float("inf")
    offset = np.asarray(p_WQ, dtype=np.float64) - patch.p_WS
    height = float(offset @ patch.normal_W)
    aside = float(np.linalg.norm(offset - height * patch.normal_W))
    return height if aside <= 2.0 * patch.radius else float("inf")
