"""The canonical map: a person's back onto the square [-1, 1]^2 (paper, IV-B).

The back's plane P is that of the principal axes of its surface; the box of the
1-99 % extents in it is what canonical space N scales to the square. So a point
keeps its place relative to the body, whatever the body's size and pose.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray, IntArray
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.offsets import less
from bath_drake.perception.quadric import cross
from bath_drake.perception.quantiles import inner_range, median, trimmed_range
from bath_drake.shared import Shared

# Fewer points than this carry no extents worth the name.
MIN_POINTS = 50

# Where the variances along the two in-plane principal axes are within the first
# ratio their directions are noise and gravity decides; above the second the
# principal axes alone decide; between the two the angle is blended. Either is but
# a first guess, which the midline corrects.
SQUARE_RATIO = 1.15
OBLONG_RATIO = 1.5

# The midline: levels of this height (metres), the outermost share of the back at
# either end left out, slopes between levels at least so far apart (metres).
LEVEL = 0.01
MIDLINE_TRIM = 0.03
MIDLINE_SPAN = 0.1
MIDLINE_ROUNDS = 2

# Rotations that went through files carry some 1e-7 of it.
_ROUNDING = 1e-6 + 1e-5 * np.eye(3)


@dataclass(frozen=True, eq=False)
class CanonicalMap(Shared):
    """The similarity-free map between W and N through the back's plane P.

    Attributes:
        R_WP: (3, 3) rotation: x to the person's right, y to the head, z outward.
        p_WP: (3,) centre of the back's box, metres.
        half_extents: (2,) half the box along x and y, metres.

    Raises:
        ValueError: If shapes, the rotation or the extents are not as said.
    """

    R_WP: FloatArray
    p_WP: FloatArray
    half_extents: FloatArray

    def __post_init__(self) -> None:
        """Copies the arrays read-only and checks them."""
        for name, shape in (("R_WP", (3, 3)), ("p_WP", (3,)), ("half_extents", (2,))):
            value = np.array(getattr(self, name), dtype=np.float64)
            if value.shape != shape or not np.isfinite(value).all():
                raise ValueError(f"{name} must be finite with shape {shape}")
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        if not (np.abs(self.R_WP @ self.R_WP.T - np.eye(3)) <= _ROUNDING).all():
            raise ValueError("R_WP must be orthonormal")
        if not np.linalg.det(self.R_WP) > 0.0:
            raise ValueError("R_WP must be right-handed")
        if not (self.half_extents > 0.0).all():
            raise ValueError(f"half_extents must be positive, got {self.half_extents}")

    @property
    def normal_W(self) -> FloatArray:
        """The plane's outward normal in W, (3,)."""
        return self.R_WP[:, 2]

    def plane_from_world(self, p_W: FloatArray) -> FloatArray:
        """Returns points of W (..., 3) in P (..., 3), metres, height last."""
        return less(p_W, self.p_WP) @ self.R_WP

    def canonical_from_world(self, p_W: FloatArray) -> FloatArray:
        """Projects points of W (..., 3) orthogonally onto the plane: N (..., 2)."""
        return self.plane_from_world(p_W)[..., :2] / self.half_extents

    def world_from_canonical(self, p_N: FloatArray) -> FloatArray:
        """Returns the plane's points in W, (..., 3), of canonical ones (..., 2)."""
        p_P = np.asarray(p_N, dtype=np.float64) * self.half_extents
        return self.p_WP + p_P @ self.R_WP[:, :2].T

    def ellipse_to_canonical(self, ellipse: FloatArray) -> FloatArray:
        """Maps an ellipse of the back's plane into N; exact.

        Args:
            ellipse: (5,) centre x, y, semi-axes a, b (metres in P) and angle.

        Returns:
            (5,) the same in N, the semi-axes in falling order. Anisotropic
            scaling takes the unit circle's image under A to that under D A, so
            the singular value decomposition of a 2 x 2 matrix is the answer.
        """
        return _scale_ellipse(ellipse, 1.0 / self.half_extents)

    def ellipse_from_canonical(self, ellipse: FloatArray) -> FloatArray:
        """Maps an ellipse row (5,) of N into the back's plane, metres."""
        return _scale_ellipse(ellipse, self.half_extents)

    def image_transform(
        self, camera: PinholeCamera, R_WC: FloatArray, p_WC: FloatArray
    ) -> FloatArray:
        """Returns T_IN (3, 3): p_I ~ T_IN (x, y, 1), for points of the plane.

        Args:
            camera: The camera that takes the image.
            R_WC: (3, 3) orientation of the camera in W.
            p_WC: (3,) position of the camera in W, metres.
        """
        R_CW = np.asarray(R_WC, dtype=np.float64).T
        p_CP = R_CW @ (self.p_WP - np.asarray(p_WC, dtype=np.float64))
        axes = R_CW @ self.R_WP[:, :2] * self.half_extents
        return camera.intrinsics @ np.column_stack([axes, p_CP])


def _scale_ellipse(ellipse: FloatArray, scales: FloatArray) -> FloatArray:
    x, y, a, b, angle = np.asarray(ellipse, dtype=np.float64)
    c, s = np.cos(angle), np.sin(angle)
    shape = scales[:, None] * np.array([[c * a, -s * b], [s * a, c * b]])
    axes, lengths, _ = np.linalg.svd(shape)
    turned = np.arctan2(axes[1, 0], axes[0, 0])
    return np.array([x * scales[0], y * scales[1], lengths[0], lengths[1], turned])


def apply_homography(T: FloatArray, points: FloatArray) -> FloatArray:
    """Applies a (3, 3) homography to points (..., 2)."""
    points = np.asarray(points, dtype=np.float64)
    mapped = points @ T[:, :2].T + T[:, 2]
    return np.asarray(mapped[..., :2] / mapped[..., 2:])


def fit_canonical_map(
    points_W: FloatArray,
    up_W: FloatArray,
    eye_W: FloatArray,
    weights: FloatArray | None = None,
    trim: float = 0.01,
) -> CanonicalMap:
    """Fits the back's plane, axes and extents by principal axes.

    Args:
        points_W: (n, 3) points of the back, metres.
        up_W: (3,) up; the y axis takes its side.
        eye_W: (3,) where the camera is, metres; the normal points towards it.
        weights: (n,) surface each point stands for (any unit); default equal. An
            oblique camera crowds its pixels where the skin faces it, and only
            with weights are axes and extents those of the surface.
        trim: Share of the surface left out at each end of each axis.

    Returns:
        The map. The y axis runs along the back's midline, see
        `principal_frame`.

    Raises:
        ValueError: If there are too few points or they span no plane.
    """
    mean, R_WP, offsets = _principal(points_W, up_W, eye_W, weights)
    p_P = offsets @ R_WP
    if weights is None:
        weights = np.ones(len(p_P))
    low, high = np.array([trimmed_range(p_P[:, k], weights, trim) for k in (0, 1)]).T
    centre = np.append((low + high) / 2.0, 0.0)
    return CanonicalMap(R_WP, mean + R_WP @ centre, (high - low) / 2.0)


def principal_frame(
    points_W: FloatArray,
    up_W: FloatArray,
    eye_W: FloatArray,
    weights: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Returns the mean (3,) and the axes R_WP (3, 3) that `fit_canonical_map` takes.

    The normal is the smallest principal axis. In the plane the principal axes of a
    broad back are nearly of one length and turn by several degrees as the outline
    of a shoulder comes or goes. So they are but the first guess for the y axis,
    which is then laid along the midline: the median slope of the middles between
    the left and the right edge, which one odd shoulder does not move.

    Arguments and errors are those of `fit_canonical_map`.
    """
    mean, R_WP, _ = _principal(points_W, up_W, eye_W, weights)
    return mean, R_WP


def _principal(
    points_W: FloatArray,
    up_W: FloatArray,
    eye_W: FloatArray,
    weights: FloatArray | None,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The `principal_frame`, and the points (n, 3) less their mean."""
    points_W = np.asarray(points_W, dtype=np.float64)
    if points_W.ndim != 2 or points_W.shape[1] != 3 or len(points_W) < MIN_POINTS:
        raise ValueError(
            f"at least {MIN_POINTS} points of shape (3,) are needed, "
            f"got shape {points_W.shape}"
        )
    if weights is None:
        weights = np.ones(len(points_W))
    weights = weights / np.sum(weights)
    mean = weights @ points_W
    offsets, weighted = _scaled_offsets(_contiguous(points_W), mean, weights)
    variances, axes = np.linalg.eigh(weighted.T @ offsets)
    if not variances[1] > 1e-8:
        raise ValueError("the points lie on a line: they span no plane")
    z = np.ascontiguousarray(axes[:, 0])
    z = z if z @ (np.asarray(eye_W, dtype=np.float64) - mean) >= 0.0 else -z
    y = _up_axis(axes[:, 2], variances[2] / variances[1], z, up_W)
    for _ in range(MIDLINE_ROUNDS):
        x = cross(y, z)
        angle = _midline_slope(offsets @ y, offsets @ x)
        y = np.cos(angle) * y + np.sin(angle) * x
    return mean, np.column_stack([cross(y, z), y, z]), offsets


def _contiguous(values: FloatArray) -> FloatArray:
    return np.ascontiguousarray(values, dtype=np.float64)


@njit(cache=True)
def _scaled_offsets(
    points: FloatArray, mean: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Returns (n, 3) points less (3,) their mean, and these times (n,) weights."""
    offsets, weighted = np.empty(points.shape), np.empty(points.shape)
    for i in range(len(points)):
        for k in range(3):
            offsets[i, k] = points[i, k] - mean[k]
            weighted[i, k] = offsets[i, k] * weights[i]
    return offsets, weighted


def edges_by_level(
    along: FloatArray, across: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Returns a region's left and right edge at each level.

    Args:
        along: (n,) heights of its points along its long axis, metres.
        across: (n,) their positions across, metres.

    Returns:
        The level (n,) of each point, counted from the lowest in steps of `LEVEL`,
        and the left and right edges (m,) of the levels; of one without points they
        are +inf and -inf.
    """
    level, left, right = _edges(
        _contiguous(along), _contiguous(across), -np.inf, np.inf
    )
    return level, left, right


@njit(cache=True)
def _edges(
    along: FloatArray, across: FloatArray, low: float, high: float
) -> tuple[IntArray, FloatArray, FloatArray]:
    """The `edges_by_level` of the points from `low` to `high`; -1 for the others."""
    least, greatest = np.inf, -np.inf
    for a in along:
        if low <= a <= high:
            least, greatest = min(least, a), max(greatest, a)
    count = int((greatest - least) / LEVEL) + 1 if greatest >= least else 0
    level = np.full(len(along), -1, dtype=np.int64)
    left, right = np.full(count, np.inf), np.full(count, -np.inf)
    for i in range(len(along)):
        if low <= along[i] <= high:
            k = int((along[i] - least) / LEVEL)
            level[i] = k
            left[k], right[k] = min(left[k], across[i]), max(right[k], across[i])
    return level, left, right


def _midline_slope(along: FloatArray, across: FloatArray) -> float:
    """Returns the angle of the midline to the `along` axis, towards `across`."""
    low, high = inner_range(along, MIDLINE_TRIM)
    _, left, right = _edges(along, across, low, high)
    slopes = _slopes(left, right)
    if len(slopes) == 0:  # too short a region to have a midline
        return 0.0
    return float(np.arctan(median(slopes)))


@njit(cache=True)
def _slopes(left: FloatArray, right: FloatArray) -> FloatArray:
    """Returns the slope of the midline between all levels that are far apart."""
    count = len(left)
    slopes = np.empty(count * count)
    found = 0
    for i in range(count):
        for j in range(i + 1, count):
            apart = (j - i) * LEVEL
            if apart >= MIDLINE_SPAN and right[i] > left[i] and right[j] > left[j]:
                rise = (left[j] + right[j]) / 2.0 - (left[i] + right[i]) / 2.0
                slopes[found] = rise / apart
                found += 1
    return slopes[:found].copy()


def _up_axis(
    major: FloatArray, ratio: float, normal: FloatArray, up_W: FloatArray
) -> FloatArray:
    """Chooses the in-plane y axis; `ratio` is that of the two variances."""
    up = np.asarray(up_W, dtype=np.float64)
    up = up - (up @ normal) * normal
    length = np.linalg.norm(up)
    if not length > 1e-6:
        raise ValueError("the back's plane is level: up has no direction in it")
    up /= length
    right = cross(up, normal)
    # Angle from up to the major axis; axes are lines and come in a cross, so the
    # nearest arm of the cross is within 45 degrees.
    angle = np.arctan2(major @ -right, major @ up)
    angle = (angle + np.pi / 4.0) % (np.pi / 2.0) - np.pi / 4.0
    share = np.clip((ratio - SQUARE_RATIO) / (OBLONG_RATIO - SQUARE_RATIO), 0, 1)
    angle *= share * share * (3.0 - 2.0 * share)
    return np.asarray(np.cos(angle) * up - np.sin(angle) * right)
