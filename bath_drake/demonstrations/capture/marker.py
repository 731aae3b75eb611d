"""Finds the marker in a frame and lifts it to 3-D.

The marker is taken for a ball. A ball of known radius is fitted to the points of its
pixels: a ball half behind a finger is then not half a radius off, and pixels whose
depth mixes marker and background do not count.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from bath_drake.demonstrations.capture.marker_colour import MarkerColour
from bath_drake.notation import BoolArray, ByteArray, FloatArray, IntArray
from bath_drake.perception import morphology
from bath_drake.perception.camera import PinholeCamera

# A blob of fewer pixels is noise.
MIN_PIXELS = 5
# Less of the ball than this is too little to tell where it is.
MIN_VISIBLE = 0.3
# Of several blobs that may be the marker it is the one that is this near to where it
# just was, m.
NEAR = 0.08
# A blob wider than the marker by this is something else.
LARGEST = 1.6
# Radii that a marker may have, m.
RADII = (0.003, 0.05)
FIT_STEPS = 10


@dataclass(frozen=True, eq=False)
class Blob:
    """Pixels of the marker's colour that hang together.

    Attributes:
        rows: (n,) of its pixels.
        columns: (n,) of its pixels.
        depth: Their median depth, m; NaN if none is known.
    """

    rows: IntArray
    columns: IntArray
    depth: float

    @property
    def pixels(self) -> int:
        """How many pixels it has."""
        return len(self.rows)


@dataclass(frozen=True, eq=False)
class MarkerSight:
    """The marker in one frame.

    Attributes:
        p_C: (3,) the ball's centre in the camera's frame, m; NaN if not seen.
        reason: Why it is not seen; empty if it is.
        blob: Its pixels; None if it is not seen.
    """

    p_C: FloatArray
    reason: str = ""
    blob: Blob | None = None

    @property
    def seen(self) -> bool:
        """Whether there is a position."""
        return not self.reason


def _unseen(reason: str) -> MarkerSight:
    return MarkerSight(np.full(3, np.nan), reason)


def find_blobs(
    colour: ByteArray,
    depth: FloatArray,
    marker: MarkerColour,
    camera: PinholeCamera,
) -> list[Blob]:
    """Returns the blobs of the marker's colour and possible size, the largest first.

    A wall or a shirt of the same colour is no marker. Blobs without depth stay.
    """
    mask = marker.mask(colour)
    if not mask.any():
        return []
    left, top, width, height = cv2.boundingRect(mask.view(np.uint8))
    window: BoolArray = mask[top : top + height, left : left + width]
    # A specular spot or a finger's edge must not cut it in two.
    whole = morphology.closed(np.pad(window, 2), 1.5)[2:-2, 2:-2]
    count, labels, stats, _ = cv2.connectedComponentsWithStats(whole.view(np.uint8))
    blobs = []
    for k in range(1, count):
        if stats[k, cv2.CC_STAT_AREA] < MIN_PIXELS:
            continue
        rows, columns = np.nonzero((labels == k) & window)
        if len(rows) < MIN_PIXELS:
            continue
        z = depth[rows + top, columns + left]
        z = z[z > 0.0]
        middle = float(np.median(z)) if len(z) else np.nan
        blob = Blob(rows + top, columns + left, middle)
        if not blob_radius(blob, camera) > RADII[1]:
            blobs.append(blob)
    return sorted(blobs, key=lambda blob: -blob.pixels)


def blob_radius(blob: Blob, camera: PinholeCamera) -> float:
    """Returns the radius of the ball whose outline has as many pixels, m."""
    return float(blob.depth * np.sqrt(blob.pixels / np.pi / (camera.fx * camera.fy)))


def locate(
    blobs: list[Blob],
    depth: FloatArray,
    camera: PinholeCamera,
    radius: float,
    last: FloatArray | None,
    reach: float = NEAR,
) -> MarkerSight:
    """Lifts the marker's blob to the ball's centre.

    Args:
        blobs: As of `find_blobs`.
        depth: (H, W) m, 0 where unknown.
        camera: The camera.
        radius: The ball's, m.
        last: (3,) where the ball was last, in the camera's frame, if known.
        reach: How far it may be from there, m; decides between blobs that all may be
            the marker.
    """
    if not blobs:
        return _unseen("hidden")
    measured = [blob for blob in blobs if blob.depth > 0.0]
    if not measured:
        return _unseen("no depth")
    # Too wide, or too little of it: the whole ball never looks so.
    whole = np.pi * camera.fx * camera.fy * radius**2
    likely = [
        blob
        for blob in measured
        if MIN_VISIBLE * whole <= blob.pixels * blob.depth**2 <= LARGEST**2 * whole
    ]
    places = [_ball(blob, depth, camera, radius) for blob in likely]
    picks = list(range(len(likely)))
    if len(picks) > 1 and last is not None:
        picks = [k for k in picks if np.linalg.norm(places[k] - last) <= reach]
    if len(picks) != 1:
        return _unseen("ambiguous" if likely else "hidden")
    return MarkerSight(places[picks[0]], "", likely[picks[0]])


def _ball(
    blob: Blob, depth: FloatArray, camera: PinholeCamera, radius: float
) -> FloatArray:
    """Fits a ball's centre (3,) to a blob's points by robust Gauss-Newton steps."""
    z = depth[blob.rows, blob.columns]
    known = np.abs(z - blob.depth) <= max(2.0 * radius, 0.02)
    z = z[known]
    rays = camera.rays[blob.rows[known], blob.columns[known]]
    points = rays * z[:, None]
    ray = rays.mean(axis=0)
    # The mean of the front of a ball is two thirds of its radius before its centre.
    centre = points.mean(axis=0) + 2.0 / 3.0 * radius * ray / np.linalg.norm(ray)
    if radius <= RADII[0] or len(z) < MIN_PIXELS:
        return np.asarray(np.median(points, axis=0))
    for _ in range(FIT_STEPS):
        away = points - centre
        distance = np.maximum(np.linalg.norm(away, axis=1), 1e-6)
        residual = distance - radius
        weight = 1.0 / (1.0 + (residual / 0.004) ** 2)
        normals = away / distance[:, None]
        # Weakly held in place: a few pixels in a row do not hold it across.
        matrix = (normals * weight[:, None]).T @ normals + 0.02 * len(z) * np.eye(3) / 9
        step = np.linalg.solve(matrix, (normals * weight[:, None]).T @ residual)
        centre = centre + step
        if np.abs(step).max() < 1e-5:
            break
    return np.asarray(centre)
