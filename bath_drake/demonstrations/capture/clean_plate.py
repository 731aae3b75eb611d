"""The person without the carer: one still picture out of many frames.

The frames are laid over one another along the body's motion. What belongs to the
body stays at one depth then, what moves in front of it does not. Film makers call
such a picture a clean plate.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bath_drake.demonstrations.capture.rigid_tracking import TrackedPose
from bath_drake.notation import BoolArray, ByteArray, FloatArray
from bath_drake.perception import morphology
from bath_drake.perception.camera import PinholeCamera

# Depths within this of one another are one surface, m.
LAYER = 0.025
# A surface is there if it was seen in so many frames, ...
MIN_SEEN = 3
# ... and the farthest one is the body's that has this share of the most frequent.
MIN_SHARE = 0.5
# Under a hand that lingers it has less: this share, so many pixels off the body's edge,
# where what is farther is the room; there, neighbours are so far apart, m.
LINGERING_SHARE, EDGE, EDGE_JUMP = 0.15, 4.0, 0.06

# Half the memory of doubles: all frames are kept side by side.
Layers = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class CleanPlate:
    """A still picture of the body, in the reference frame's camera.

    Attributes:
        colour: (H, W, 3) RGB.
        depth: (H, W) m, 0 where nothing is known.
        seen: (H, W) in how many frames the surface was seen.
    """

    colour: ByteArray
    depth: FloatArray
    seen: FloatArray


def clean_plate(
    frames: Iterable[tuple[ByteArray, FloatArray, TrackedPose]],
    camera: PinholeCamera,
    count: int,
    low: FloatArray,
    high: FloatArray,
) -> CleanPlate:
    """Lays frames over one another.

    Args:
        frames: Colour (H, W, 3), depth (H, W) and the body's pose; that of the
            reference frame is `AT_REST`.
        camera: The camera.
        count: How many frames come, at most.
        low: (3,) lower corner, in the reference frame's camera, of what matters.
        high: (3,) its upper corner.
    """
    pinhole = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
    depths = np.full((*camera.shape, count), np.inf, dtype=np.float32)
    colours = np.zeros((*camera.shape, count, 3), dtype=np.uint8)
    for k, (colour, depth, pose) in enumerate(frames):
        _lay(colour, depth, pinhole, pose.R, pose.p, low, high, depths, colours, k)
    colour, depth, seen = _farthest_layer(depths, colours, MIN_SHARE)
    below = _farthest_layer(depths, colours, LINGERING_SHARE)
    deeper = below[1] - depth
    edge = morphology.dilate(_jumps(below[1]), EDGE)
    hand = (deeper > 0.0) & (depth > 0.0) & ~edge
    colour[hand], depth[hand], seen[hand] = (part[hand] for part in below)
    return CleanPlate(colour, depth, seen)


def _jumps(depth: FloatArray) -> BoolArray:
    """Where neighbours are on different surfaces, or not known."""
    jumps: BoolArray = depth == 0.0
    for axis in (0, 1):
        far = np.abs(np.diff(depth, axis=axis)) > EDGE_JUMP
        if axis == 0:
            jumps[1:] |= far
        else:
            jumps[:, 1:] |= far
    return jumps


@njit(cache=True)
def _lay(
    colour: ByteArray,
    depth: FloatArray,
    pinhole: FloatArray,
    R: FloatArray,
    p: FloatArray,
    low: FloatArray,
    high: FloatArray,
    depths: Layers,
    colours: ByteArray,
    k: int,
) -> None:
    """Carries a frame's points back along the body's motion into layer k."""
    rows, columns = depth.shape
    fx, fy, cx, cy = pinhole
    m, q = np.empty(3), np.empty(3)
    for v in range(rows):
        for u in range(columns):
            z = depth[v, u]
            if not z > 0.0:
                continue
            m[0] = (u + 0.5 - cx) / fx * z - p[0]
            m[1] = (v + 0.5 - cy) / fy * z - p[1]
            m[2] = z - p[2]
            inside = True
            for c in range(3):
                q[c] = R[0, c] * m[0] + R[1, c] * m[1] + R[2, c] * m[2]
                inside = inside and low[c] <= q[c] <= high[c]
            if not inside or q[2] <= 0.05:
                continue
            a, b = fx * q[0] / q[2] + cx, fy * q[1] / q[2] + cy
            if not (0.0 <= a < columns and 0.0 <= b < rows):
                continue
            column, row = int(a), int(b)
            if q[2] < depths[row, column, k]:
                depths[row, column, k] = q[2]
                for c in range(3):
                    colours[row, column, k, c] = colour[v, u, c]


@njit(cache=True)
def _farthest_layer(
    depths: Layers, colours: ByteArray, share: float
) -> tuple[ByteArray, FloatArray, FloatArray]:
    rows, columns, count = depths.shape
    colour = np.zeros((rows, columns, 3), dtype=np.uint8)
    depth = np.zeros((rows, columns))
    seen = np.zeros((rows, columns))
    for v in range(rows):
        for u in range(columns):
            sample = depths[v, u]
            order = np.argsort(sample)
            known = 0
            while known < count and sample[order[known]] < np.inf:
                known += 1
            if known < MIN_SEEN:
                continue
            best_first, best_last, best, most = 0, 0, 0, 0
            for turn in range(2):
                first = 0
                for last in range(known):
                    while sample[order[last]] - sample[order[first]] > LAYER:
                        first += 1
                    size = last - first + 1
                    if turn == 0:
                        most = max(most, size)
                    elif size >= max(share * most, MIN_SEEN) and (
                        size >= best or sample[order[first]] > sample[order[best_last]]
                    ):
                        best_first, best_last, best = first, last, size
            if best == 0:
                continue
            total = 0.0
            rgb = np.zeros(3)
            for i in range(best_first, best_last + 1):
                total += sample[order[i]]
                for c in range(3):
                    rgb[c] += colours[v, u, order[i], c]
            depth[v, u] = total / best
            seen[v, u] = best
            for c in range(3):
                colour[v, u, c] = np.uint8(rgb[c] / best + 0.5)
    return colour, depth, seen
