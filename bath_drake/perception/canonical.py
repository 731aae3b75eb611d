"""The canonical map: a person's back onto the square [-1, 1]^2 (paper, IV-B).

The back's plane P is that of the principal axes of its surface; the box of the
1-99 % extents in it is what canonical space N scales to the square. So a point
keeps its place relative to the body, whatever the body's size and pose.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.notation import FloatArray, IntArray
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.offsets import less
from bath_drake.perception.principal import (
    LEVEL_PLANE,
    ON_A_LINE,
    edges_between,
    principal_axes,
    trimmed_box,
)
from bath_drake.shared import Shared

# Fewer points than this carry no extents worth the name.
MIN_POINTS = 50

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
    points, shares = _weighted(points_W, weights)
    mean, R_WP = _principal(points, shares, up_W, eye_W)
    low, high = trimmed_box(points, shares, mean, R_WP, trim)
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
    return _principal(*_weighted(points_W, weights), up_W, eye_W)


def _weighted(
    points_W: FloatArray, weights: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    """Returns points (n, 3) and weights (n,) as kernels take them."""
    if weights is None:
        weights = np.ones(len(points_W))
    # numba compiles anew for read-only arrays: plain copies.
    points = np.array(points_W, dtype=np.float64, order="C")
    return points, np.array(weights, dtype=np.float64, order="C")


def _principal(
    points_W: FloatArray, weights: FloatArray, up_W: FloatArray, eye_W: FloatArray
) -> tuple[FloatArray, FloatArray]:
    if points_W.ndim != 2 or points_W.shape[1] != 3 or len(points_W) < MIN_POINTS:
        raise ValueError(
            f"at least {MIN_POINTS} points of shape (3,) are needed, "
            f"got shape {points_W.shape}"
        )
    up, eye = np.array(up_W, dtype=np.float64), np.array(eye_W, dtype=np.float64)
    status, mean, R_WP = principal_axes(points_W, weights, up, eye)
    if status == ON_A_LINE:
        raise ValueError("the points lie on a line: they span no plane")
    if status == LEVEL_PLANE:
        raise ValueError("the back's plane is level: up has no direction in it")
    return mean, R_WP


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
    along = np.ascontiguousarray(along, dtype=np.float64)
    across = np.ascontiguousarray(across, dtype=np.float64)
    level, left, right = edges_between(along, across, -np.inf, np.inf)
    return level, left, right
