"""The pinhole camera: pixels to camera points and back.

Image coordinates are continuous: pixel (column u, row v) covers the square
[u, u + 1) x [v, v + 1) and is sampled at its centre, (u + 0.5, v + 0.5). That
is how Drake's VTK renderer draws and how `PinholeCamera.project` counts.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bath_drake.notation import FloatArray


@dataclass(frozen=True)
class PinholeCamera:
    """An ideal camera without distortion; the defaults are a Kinect v2.

    Attributes:
        width: Columns of the image, pixels.
        height: Rows of the image, pixels.
        fx: Focal length across, pixels.
        fy: Focal length down, pixels.
        cx: Column of the optical axis, continuous image coordinates.
        cy: Row of the optical axis, continuous image coordinates.

    Raises:
        ValueError: If a size or a focal length is not positive and finite.
    """

    width: int = 512
    height: int = 424
    fx: float = 365.456
    fy: float = 365.456
    cx: float = 254.878
    cy: float = 205.395

    def __post_init__(self) -> None:
        """Checks the numbers."""
        for name in ("width", "height", "fx", "fy"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"camera {name} must be positive, got {value}")
        for name in ("cx", "cy"):
            if not np.isfinite(getattr(self, name)):
                raise ValueError(f"camera {name} must be finite")

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns, the shape of this camera's images."""
        return self.height, self.width

    @property
    def intrinsics(self) -> FloatArray:
        """The (3, 3) matrix K: p_I ~ K p_C."""
        return np.array(
            [[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]]
        )

    @cached_property
    def rays(self) -> FloatArray:
        """Points at depth 1 seen by each pixel's centre, in C, (H, W, 3)."""
        x = (np.arange(self.width) + 0.5 - self.cx) / self.fx
        y = (np.arange(self.height) + 0.5 - self.cy) / self.fy
        rays = np.ones((self.height, self.width, 3))
        rays[..., 0] = x[None, :]
        rays[..., 1] = y[:, None]
        rays.setflags(write=False)
        return rays

    def deproject(self, depth: FloatArray) -> FloatArray:
        """Returns the points seen at depth z (metres along the optical axis).

        Args:
            depth: (H, W), metres; what is not finite stays not finite.

        Returns:
            (H, W, 3) points in C, metres.

        Raises:
            ValueError: If the image is not of this camera's size.
        """
        depth = np.asarray(depth, dtype=np.float64)
        if depth.shape != self.shape:
            raise ValueError(
                f"depth image must have shape {self.shape}, got {depth.shape}"
            )
        with np.errstate(invalid="ignore"):  # 0 * inf on the optical axis
            return self.rays * depth[..., None]

    def project(self, p_C: FloatArray) -> FloatArray:
        """Returns the continuous image coordinates of points in C.

        Args:
            p_C: (..., 3), metres.

        Returns:
            (..., 2) columns and rows; NaN for points not in front of the camera.
        """
        p_C = np.asarray(p_C, dtype=np.float64)
        z = np.where(p_C[..., 2] > 0.0, p_C[..., 2], np.nan)
        return np.stack(
            [
                self.fx * p_C[..., 0] / z + self.cx,
                self.fy * p_C[..., 1] / z + self.cy,
            ],
            axis=-1,
        )
