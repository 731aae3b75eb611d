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


def _one_sided(near: FloatArray) -> bool:
    turn = np.arctan2(near[:, 1], near[:, 0]) / (2.0 * np.pi) % 1.0
    counts = np.bincount((turn * SECTORS).astype(np.int64) % SECTORS, minlength=SECTORS)
    empty = counts < SECTOR_SHARE * len(near)
    run = longest = 0
    for is_empty in np.tile(empty, 2):  # twice around: runs may wrap
        run = run + 1 if is_empty else 0
        longest = max(longest, run)
    return longest >= SECTORS // 2


def _least_squares(basis: FloatArray, values: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.solve(basis.T @ basis, basis.T @ values))


def _fit(
    near: FloatArray, R_WP: FloatArray, p_WQ: FloatArray, radius: float
) -> SurfacePatch:
    # A plane first: in its axes the skin is level, however steep a flank is in P's.
    a, b, c = _least_squares(
        np.column_stack([near[:, :2], np.ones(len(near))]), near[:, 2]
    )
    R_PT = _tangent_axes(a, b)
    p_PT = np.array([0.0, 0.0, c])
    local = (near - p_PT) @ R_PT / radius  # of order one: well conditioned
    s, t, h = local.T
    basis = np.column_stack([s * s / 2.0, s * t, t * t / 2.0, s, t, np.ones_like(s)])
    k = _least_squares(basis, h)
    rms = float(np.sqrt(np.mean((basis @ k - h) ** 2))) * radius
    # Where the line along P's normal meets the quadric.
    direction = R_PT[2]
    height = 0.0
    for _ in range(STEPS):
        s, t, h = height * direction
        gradient = np.array([k[0] * s + k[1] * t + k[3], k[1] * s + k[2] * t + k[4]])
        quadric = (k[0] * s + 2.0 * k[1] * t) * s / 2.0 + k[2] * t * t / 2.0
        quadric += k[3] * s + k[4] * t + k[5]
        slope = direction[2] - gradient @ direction[:2]
        height -= (h - quadric) / slope
    s, t, h = height * direction
    gradient = np.array([k[0] * s + k[1] * t + k[3], k[1] * s + k[2] * t + k[4]])
    normal = np.append(-gradient, 1.0)
    length = np.linalg.norm(normal)
    # Shape operator of a height field: inverse first form times second form.
    second = -np.array([[k[0], k[1]], [k[1], k[2]]]) / (radius * length)
    first = np.eye(2) + np.outer(gradient, gradient)
    curvatures = np.sort(np.linalg.eigvals(np.linalg.solve(first, second)).real)[::-1]
    p_PS = p_PT + R_PT @ (height * direction * radius)
    return SurfacePatch(
        p_WS=p_WQ + R_WP @ p_PS,
        normal_W=R_WP @ R_PT @ (normal / length),
        curvatures=curvatures,
        count=len(near),
        rms=rms,
        radius=radius,
        valid=True,
    )


def _tangent_axes(a: float, b: float) -> FloatArray:
    """Returns R_PT of the plane z = a x + b y, its normal last."""
    n = np.array([-a, -b, 1.0]) / np.sqrt(1.0 + a * a + b * b)
    x = np.array([1.0, 0.0, a]) / np.sqrt(1.0 + a * a)
    return np.column_stack([x, np.cross(n, x), n])


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
    x = np.cos(roll) * x + np.sin(roll) * np.cross(z, x)
    R_WE = np.column_stack([x, np.cross(z, x), z])
    return R_WE, patch.p_WS + standoff * patch.normal_W
