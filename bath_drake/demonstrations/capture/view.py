"""Finds the back in one picture, whatever way the camera stands."""

import cv2
import numpy as np

from bath_drake.demonstrations.capture.rigid_tracking import RigidSurface
from bath_drake.notation import BoolArray, ByteArray, FloatArray
from bath_drake.perception import morphology
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.canonical import CanonicalMap, fit_canonical_map
from bath_drake.perception.pixels import (
    inside_box,
    pixel_areas,
    pixel_normals,
    points_in_world,
)
from bath_drake.perception.segmentation import (
    SegmentationConfig,
    pixel_pitch,
    segment_back,
    skin_mask,
)

# The tracked surface reaches so far over the back's edge, m: shoulders hold it in
# place along itself, the depth of a flat back alone does not.
RIM, RIM_DEPTH = 0.035, 0.25
# Depths are smoothed over so many pixels before normals are taken.
SMOOTHING = 1.5


class View:
    """A camera, the box in its frame C that holds the back, and which way is up.

    The segmenter wants a frame whose z points up; W is such a one at the camera.
    """

    def __init__(
        self,
        camera: PinholeCamera,
        low: FloatArray,
        high: FloatArray,
        up_C: FloatArray,
    ) -> None:
        """Takes the box's corners (3,), m, and up (3,), all in C."""
        self.camera, self.low, self.high = camera, low, high
        self.up_C = up_C / np.linalg.norm(up_C)
        z = self.up_C
        x = np.eye(3)[int(np.argmin(np.abs(z)))]
        x = x - (x @ z) * z
        x /= np.linalg.norm(x)
        self._R_WC = np.ascontiguousarray(np.stack([x, np.cross(z, x), z]))
        reach = np.linalg.norm(np.abs(np.stack([low, high])).max(axis=0))
        self.config = SegmentationConfig(
            box_low_W=np.full(3, -reach),
            box_high_W=np.full(3, reach),
            # The body's frames are gathered: single ones' noise does not narrow it.
            regain_rim=False,
        )

    def points_C(self, depth: FloatArray) -> FloatArray:
        """Returns the points (H, W, 3) a depth image shows, m in C; NaN if unknown."""
        return points_in_world(depth, self.camera.rays, np.eye(3), np.zeros(3))

    def back(self, colour: ByteArray, depth: FloatArray) -> BoolArray:
        """Returns which pixels (H, W) show the back."""
        inside = inside_box(self.points_C(depth), self.low, self.high)
        depth = np.where(inside, depth, 0.0)
        points_W = points_in_world(depth, self.camera.rays, self._R_WC, np.zeros(3))
        nobody = np.zeros(depth.shape, dtype=np.bool_)
        skin = skin_mask(colour, self.config)
        visible, _ = segment_back(skin, points_W, nobody, self.config)
        return visible

    def areas(self, depth: FloatArray, back: BoolArray) -> FloatArray:
        """Returns the surface (H, W) behind each pixel of a back, m^2."""
        focal2 = self.camera.fx * self.camera.fy
        return pixel_areas(self.points_C(depth), depth, back, np.zeros(3), focal2)

    def first_map(self, depth: FloatArray, back: BoolArray) -> CanonicalMap:
        """Returns the canonical map of what is seen of a back, with C for W."""
        points, areas = self.points_C(depth)[back], self.areas(depth, back)[back]
        return fit_canonical_map(points, self.up_C, np.zeros(3), areas)

    def skin(self, colour: ByteArray, depth: FloatArray, back: BoolArray) -> BoolArray:
        """Returns which pixels (H, W) show the skin of a back and a rim around it."""
        pitch = pixel_pitch(self.points_C(depth), back)
        near = np.abs(depth - float(np.median(depth[back]))) <= RIM_DEPTH
        skin = morphology.dilate(back, RIM / pitch) & near
        return skin & (skin_mask(colour, self.config) | back)

    def surface(self, depth: FloatArray, mask: BoolArray) -> RigidSurface:
        """Returns the surface of a mask, smoothed, in C."""
        points, normals = self.smoothed(depth, mask)
        known = mask & (np.linalg.norm(normals, axis=2) > 0.5)
        return RigidSurface(points[known], normals[known])

    def smoothed(
        self, depth: FloatArray, mask: BoolArray
    ) -> tuple[FloatArray, FloatArray]:
        """Returns smoothed points and normals (H, W, 3) of one surface, in C."""
        weight = cv2.GaussianBlur(mask.astype(np.float64), (0, 0), SMOOTHING)
        smooth = cv2.GaussianBlur(np.where(mask, depth, 0.0), (0, 0), SMOOTHING)
        points = self.points_C(np.where(mask, smooth / np.maximum(weight, 1e-9), 0.0))
        return points, pixel_normals(points, mask, 2)
