"""Which pixels may show the robot, from its joint positions alone."""

from collections.abc import Sequence
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from bath_drake.notation import BoolArray, FloatArray
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.offsets import less

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
    for outline in _outlines(hulls_W, camera, R_WC, p_WC):
        cv2.fillConvexPoly(canvas, outline, 1, lineType=cv2.LINE_8, shift=4)
    x, y, width, height = cv2.boundingRect(canvas)
    if dilation_px > 0 and width > 0:
        size = 2 * dilation_px + 1
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
        window = (
            slice(max(y - dilation_px, 0), y + height + dilation_px),
            slice(max(x - dilation_px, 0), x + width + dilation_px),
        )
        canvas[window] = cv2.dilate(canvas[window], disc)
    return canvas.view(np.bool_)


def _outlines(
    hulls_W: Sequence[FloatArray],
    camera: PinholeCamera,
    R_WC: FloatArray,
    p_WC: FloatArray,
) -> list[NDArray[np.int32]]:
    """Returns the hulls' projections (n, 1, 2) in sixteenths of a pixel."""
    if len(hulls_W) == 0:
        return []
    p_C = less(np.concatenate(hulls_W), p_WC) @ R_WC
    ends = np.cumsum([len(hull) for hull in hulls_W])[:-1]
    hulls_C = np.split(p_C, ends)
    if not (p_C[:, 2] >= NEAR).all():
        hulls_C = [_clip_near(hull) for hull in hulls_C]
        p_C = np.concatenate(hulls_C)
        ends = np.cumsum([len(hull) for hull in hulls_C])[:-1]
    places = np.clip(camera.project(p_C) - 0.5, -FAR_PIXEL, FAR_PIXEL)
    pixels = places.astype(np.float32).reshape(-1, 1, 2)
    # Four fractional bits keep the outline to a sixteenth of a pixel.
    fixed = np.round(pixels * 16.0).astype(np.int32)
    outlines = []
    pairs = zip(np.split(pixels, ends), np.split(fixed, ends), strict=True)
    for hull, corners in pairs:
        if len(hull) > 0:
            around = cv2.convexHull(hull, returnPoints=False).ravel()
            outlines.append(corners[around])
    return outlines


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
