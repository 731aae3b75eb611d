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
from bath_drake.perception.quadric import (
    by_cell,
    cross,
    fit_all,
    fit_around,
    gather,
    no_fit,
    quality,
)

# A wider neighbourhood is tried where the first is thin, one-sided or a poor fit;
# beyond the largest radius (metres) the skin is no quadric any more.
WIDENING = (1.0, 1.4, 2.0)
MAX_RADIUS = 0.06


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
        valid: False if the points did not determine a patch that can be trusted; then
            `p_WS` and `normal_W` are those of the back's plane and must not be washed
            at.
        normal_deviation: How far off `normal_W` is predicted to be, rms, rad, from the
            points' noise and places; infinite where the patch is not valid.
    """

    p_WS: FloatArray
    normal_W: FloatArray
    curvatures: FloatArray
    count: int
    rms: float
    radius: float
    valid: bool
    normal_deviation: float = float("inf")

    @property
    def quality(self) -> float:
        """How probably the normal is within 3 degrees of the true one; in [0, 1]."""
        return float(quality(self.normal_deviation))


def fit_surface(
    points_W: FloatArray,
    canonical_map: CanonicalMap,
    p_NQ: FloatArray,
    radius: float = 0.03,
    recalled_W: FloatArray | None = None,
) -> SurfacePatch:
    """Fits the skin where the line through a canonical point meets it.

    Args:
        points_W: (n, 3) visible points of the back, metres.
        canonical_map: Where the back is.
        p_NQ: (2,) the canonical point; the line is along the plane's normal.
        radius: Points within this distance of the line are fitted; up to
            `MAX_RADIUS` if those are too few or lie on one side.
        recalled_W: (m, 3) points of skin that the robot hides, metres, as known from
            before: without them a hole is bridged from its rim.

    Returns:
        The patch; `valid` is False if even the widest neighbourhood is too thin, or
        its `quality` too low.

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
    if recalled_W is not None and len(recalled_W) > 0:
        points_W = np.concatenate([points_W, recalled_W])
    for factor in WIDENING:
        radius_now = min(factor * radius, MAX_RADIUS)
        fit = fit_around(gather(points_W, R_WP, p_WQ, radius_now), radius_now)
        if fit[11] > 0.5:
            break
    return _patch(canonical_map, p_WQ, fit)


def fit_path(
    points_W: FloatArray,
    canonical_map: CanonicalMap,
    p_NQ: FloatArray,
    radius: float = 0.03,
) -> list[SurfacePatch]:
    """Fits the skin at many canonical points at once.

    Args:
        points_W: (n, 3) visible points of the back, metres.
        canonical_map: Where the back is.
        p_NQ: (m, 2) the canonical points.
        radius: As of `fit_surface`.

    Returns:
        The m patches, each that of `fit_surface` but for rounding.

    Raises:
        ValueError: If the radius is not positive or a point not finite.
    """
    if not 0.0 < radius <= MAX_RADIUS:
        raise ValueError(f"radius must be in (0, {MAX_RADIUS}] m, got {radius}")
    p_NQ = np.asarray(p_NQ, dtype=np.float64)
    if p_NQ.ndim != 2 or p_NQ.shape[1] != 2 or not np.isfinite(p_NQ).all():
        raise ValueError(f"p_NQ must be finite with shape (m, 2), got {p_NQ.shape}")
    p_WQ = canonical_map.world_from_canonical(p_NQ)
    if len(points_W) == 0:
        nothing = no_fit(0, min(WIDENING[-1] * radius, MAX_RADIUS))
        return [_patch(canonical_map, point, nothing) for point in p_WQ]
    p_P = canonical_map.plane_from_world(points_W)
    radii = np.minimum(np.array(WIDENING) * radius, MAX_RADIUS)
    fits = fit_all(*by_cell(p_P, radii[-1]), p_NQ * canonical_map.half_extents, radii)
    return [
        _patch(canonical_map, point, fit) for point, fit in zip(p_WQ, fits, strict=True)
    ]


def _patch(
    canonical_map: CanonicalMap, p_WQ: FloatArray, fit: FloatArray
) -> SurfacePatch:
    """The patch of a row of `fit_quadric` or `no_fit`, whose line goes through p_WQ."""
    R_WP = canonical_map.R_WP
    return SurfacePatch(
        p_WS=p_WQ + R_WP @ fit[:3],
        normal_W=R_WP @ fit[3:6],
        curvatures=fit[6:8].copy(),
        count=int(fit[8]),
        rms=float(fit[9]),
        radius=float(fit[10]),
        valid=bool(fit[11] > 0.5),
        normal_deviation=float(fit[12]),
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
    up = canonical_map.R_WP[:, 1]
    R_WE = _square_to(patch.normal_W, np.ascontiguousarray(up), roll)
    if not np.isfinite(R_WE[0, 0]):
        raise ValueError("the skin's normal is along the patient's up: no roll")
    return R_WE, patch.p_WS + standoff * patch.normal_W


@njit(cache=True)
def _square_to(normal_W: FloatArray, up: FloatArray, roll: float) -> FloatArray:
    """R_WE of a nozzle that looks against a normal; NaN where `up` is along it."""
    z = -normal_W
    x = up - (up[0] * z[0] + up[1] * z[1] + up[2] * z[2]) * z
    length = np.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    R_WE = np.full((3, 3), np.nan)
    if length > 1e-6:
        x /= length
        x = np.cos(roll) * x + np.sin(roll) * cross(z, x)
        y = cross(z, x)
        for i in range(3):
            R_WE[i, 0], R_WE[i, 1], R_WE[i, 2] = x[i], y[i], z[i]
    return R_WE


def height_over(patch: SurfacePatch, p_WQ: FloatArray) -> float:
    """Returns how high a point (3,) is over the patch, along its normal, m.

    A patch speaks for its own neighbourhood: beside it, more than twice the fitted
    radius away along the skin, or where it is not valid, the answer is infinite.
    """
    if not patch.valid:
        return float("inf")
    p_WQ = np.ascontiguousarray(p_WQ, dtype=np.float64)
    height, aside = _over(patch.p_WS, patch.normal_W, p_WQ)
    return height if aside <= 2.0 * patch.radius else float("inf")


@njit(cache=True)
def _over(
    p_WS: FloatArray, normal_W: FloatArray, p_WQ: FloatArray
) -> tuple[float, float]:
    """How far a point is from another along a normal, and aside of it, m."""
    height = aside2 = 0.0
    for k in range(3):
        height += (p_WQ[k] - p_WS[k]) * normal_W[k]
    for k in range(3):
        aside2 += (p_WQ[k] - p_WS[k] - height * normal_W[k]) ** 2
    return height, np.sqrt(aside2)
