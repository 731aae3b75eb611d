"""Which pixels may show the robot, from its joint positions alone."""

from collections.abc import Sequence
from typing import Protocol

import cv2
import numpy as np

from bath_drake.notation import BoolArray, FloatArray
from bath_drake.perception.camera import PinholeCamera

# Nearer than this to the camera's plane a hull is cut off, metres.
NEAR = 0.02

# Image coordinates are clamped to this many pixels: far outside every image, and
# small enough for the rasteriser's fixed-point numbers.
FAR_PIXEL = 8192.0


class RobotGeometry(Protocol):
    """The robot's links as convex hulls."""

    def hulls_in_world(self, q: FloatArray) -> Sequence[FloatArray]:
        """Returns each link's hull vertices (n, 3) in W at joint positions q."""
        ...


def robot_silhouette(
    hulls_W: Sequence[FloatArray],
    camera: PinholeCamera,
    R_WC: FloatArray,
    p_WC: FloatArray,
    dilation_px: int = 2,
) -> BoolArray:
    """Returns where the robot's links project to, as a mask.

    The projection of a convex body is the convex hull of its vertices'
    projections, so the mask covers the links for certain and a little more.

    Args:
        hulls_W: Convex hull vertices of each link, (n, 3) each, W, metres.
        camera: The camera that takes the image.
        R_WC: (3, 3) orientation of the camera in W.
        p_WC: (3,) position of the camera in W.
        dilation_px: The mask is grown by this many pixels.

    Returns:
        (H, W) mask, True where the robot may be.
    """
    canvas = np.zeros(camera.shape, dtype=np.uint8)
    for hull in hulls_W:
        p_C = (np.asarray(hull, dtype=np.float64) - p_WC) @ R_WC
        p_C = _clip_near(p_C)
        if len(p_C) == 0:
            continue
        pixels = np.clip(camera.project(p_C) - 0.5, -FAR_PIXEL, FAR_PIXEL)
        outline = cv2.convexHull(pixels.astype(np.float32).reshape(-1, 1, 2))
        # Four fractional bits keep the outline to a sixteenth of a pixel.
        fixed = np.round(outline * 16.0).astype(np.int32)
        cv2.fillConvexPoly(canvas, fixed, 1, lineType=cv2.LINE_8, shift=4)
    if dilation_px > 0:
        size = 2 * dilation_px + 1
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
        canvas[:] = cv2.dilate(canvas, disc)
    return canvas.astype(bool)


def _clip_near(p_C: FloatArray) -> FloatArray:
    """Cuts a convex point set at the near plane; its hull's part in front."""
    front = p_C[:, 2] >= NEAR
    if front.all():
        return p_C
    near, far = p_C[front], p_C[~front]
    if len(near) == 0:
        return near
    # Every edge through the plane joins a point before it with one behind it; the
    # other pairs cut the plane inside the hull and do no harm.
    share = (near[:, None, 2] - NEAR) / (near[:, None, 2] - far[None, :, 2])
    cuts = near[:, None] + share[..., None] * (far[None] - near[:, None])
    return np.concatenate([near, cuts.reshape(-1, 3)])
