"""How fast the body moves, and whether somebody else has come near it."""

from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numba import njit
from scipy import ndimage

from bath_drake.notation import BoolArray, FloatArray, IntArray
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.shared import Shared

# The speed is taken over so many frames: a map's noise of 1 mm is then 15 mm/s.
SPEED_FRAMES = 3
# Side of a voxel, m: what is one body has no wider gaps in a camera's view of it.
VOXEL = 0.08
# So many voxels around what was there count as the same: it moves a little.
_REACH = 2
# Less surface than this, m^2, is a flying pixel, a drop, or a cable; a hand is more.
LEAST_AREA = 0.01
# From frame to frame a back that moves shows no more than this share less or more.
_SAME_VIEW = 0.12
# The map is some frames on its way when another part of the back is seen, s.
SETTLING = 0.6
# Corners and middle of the back, in N.
_PLACES = np.array([[0.0, 0.0], [-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]])


@dataclass(frozen=True, eq=False)
class BodyCheck(Shared):
    """What is known after a frame.

    Attributes:
        stamps: Of the last frames with a map, s.
        area: Of the back that the last of them showed, m^2.
        places: For each, the back's middle and corners in W, m: (5, 3).
        known: Voxels of the workspace box in which the person, or what stood there
            from the beginning, has been seen; None before the first back.
        others: How many more there are in the box.
        settled: From when on the map's motion is the body's, s.
    """

    stamps: tuple[float, ...] = ()
    area: float = 0.0
    places: tuple[FloatArray, ...] = ()
    known: BoolArray | None = field(default=None)
    others: int = 0
    settled: float = -np.inf

    @property
    def speed(self) -> float:
        """Of the back's fastest corner over the last frames, m/s; 0 of one frame."""
        if len(self.stamps) < 2 or self.stamps[-1] < self.settled:
            return 0.0
        way = np.linalg.norm(self.places[-1] - self.places[0], axis=1).max()
        return float(way / (self.stamps[-1] - self.stamps[0]))


def check_body(
    before: BodyCheck,
    stamp: float,
    canonical_map: CanonicalMap | None,
    area: float,
    voxels: IntArray,
    back_voxels: IntArray,
) -> BodyCheck:
    """Checks one frame; one that is no later than the last changes nothing.

    What is in the box as the first back is seen is furniture, or the person. Later,
    a cluster of voxels without the back, where nothing was before, is somebody else.

    Args:
        before: What was known.
        stamp: When it was taken, s.
        canonical_map: Of this frame; None if no back was found.
        area: Of the back that it shows, m^2.
        voxels: (a, b, c) how many m^2 of surface, in units of 1e-4, each voxel of the
            box shows, the robot's own left out.
        back_voxels: Likewise, of the back alone.
    """
    stamps, places = before.stamps, before.places
    if stamps and not stamp > stamps[-1]:
        return before
    if canonical_map is None:
        settled = stamp + SETTLING
        return BodyCheck(known=before.known, others=before.others, settled=settled)
    settled = before.settled
    if not abs(area - before.area) <= _SAME_VIEW * before.area:
        # Something came before the back, or went: its box is another, it did not move.
        stamps, places, settled = (), (), stamp + SETTLING
    now = canonical_map.world_from_canonical(_PLACES)
    stamps = (*stamps, stamp)[-SPEED_FRAMES - 1 :]
    places = (*places, now)[-SPEED_FRAMES - 1 :]
    filled = voxels > 0
    if before.known is None:
        return BodyCheck(stamps, area, places, _grown(filled), settled=settled)
    labels, count = ndimage.label(filled, structure=np.ones((3, 3, 3)))
    own = np.zeros(count + 1, dtype=bool)
    own[np.unique(labels[back_voxels > 0])] = True
    areas = np.bincount(labels.ravel(), voxels.ravel(), count + 1)
    fresh = np.bincount(labels.ravel(), (voxels * ~before.known).ravel(), count + 1)
    # The robot's arm may cut a piece off the person: it is where the person was.
    other = ~own & (fresh > 0.5 * areas) & (areas > LEAST_AREA * 1e4)
    other[0] = False
    known = before.known
    # Whoever touches the person is none of them.
    if not other.any():
        known = known | _grown(filled & own[labels] & (labels > 0))
    return BodyCheck(stamps, area, places, known, int(np.count_nonzero(other)), settled)


@njit(cache=True)
def _grown(filled: BoolArray) -> BoolArray:
    """The voxels, and all that are no more than `_REACH` away along every axis."""
    a, b, c = filled.shape
    grown = np.zeros((a, b, c), dtype=np.bool_)
    for i in range(a):
        for j in range(b):
            for k in range(c):
                if filled[i, j, k]:
                    for x in range(max(i - _REACH, 0), min(i + _REACH + 1, a)):
                        for y in range(max(j - _REACH, 0), min(j + _REACH + 1, b)):
                            for z in range(max(k - _REACH, 0), min(k + _REACH + 1, c)):
                                grown[x, y, z] = True
    return grown


def measured_points(
    depth: FloatArray,
    rays: FloatArray,
    X_WC: tuple[FloatArray, FloatArray],
    robot_mask: BoolArray,
    pixel: float,
) -> tuple[FloatArray, FloatArray]:
    """Returns what a depth image shows beside the robot, one by one.

    Args:
        depth: (H, W), m; zero, NaN or infinite where nothing was measured.
        rays: (H, W, 3) points at depth 1 in C.
        X_WC: The camera's orientation (3, 3) and position (3,) in W, m.
        robot_mask: (H, W) pixels that may show the robot; of another shape, none do.
        pixel: Surface that a pixel shows at depth 1, m^2.

    Returns:
        The points (n, 3) in W, m, and the surface (n,) that each stands for, m^2.
    """
    if robot_mask.shape != depth.shape:
        robot_mask = np.zeros(depth.shape, dtype=bool)
    R_WC, p_WC = (np.ascontiguousarray(part) for part in X_WC)
    return _measured(depth, rays, R_WC, p_WC, np.ascontiguousarray(robot_mask), pixel)


@njit(cache=True)
def _measured(
    depth: FloatArray,
    rays: FloatArray,
    R_WC: FloatArray,
    p_WC: FloatArray,
    robot_mask: BoolArray,
    pixel: float,
) -> tuple[FloatArray, FloatArray]:
    rows, columns = depth.shape
    points, areas = np.empty((rows * columns, 3)), np.empty(rows * columns)
    n = 0
    for v in range(rows):
        for u in range(columns):
            z = depth[v, u]
            if z > 0.0 and z < np.inf and not robot_mask[v, u]:
                x, y = rays[v, u, 0] * z, rays[v, u, 1] * z
                for k in range(3):
                    points[n, k] = (
                        R_WC[k, 0] * x + R_WC[k, 1] * y + R_WC[k, 2] * z + p_WC[k]
                    )
                areas[n] = pixel * (z * z)
                n += 1
    return points[:n], areas[:n]


@cache
def _shape(low: tuple[float, ...], high: tuple[float, ...]) -> tuple[int, int, int]:
    sides = [int(np.ceil((h - n) / VOXEL)) for n, h in zip(low, high, strict=True)]
    return sides[0], sides[1], sides[2]


def filled_voxels(
    points_W: FloatArray, areas: FloatArray, low_W: FloatArray, high_W: FloatArray
) -> IntArray:
    """Returns how much surface each voxel of a box shows, in units of 1e-4 m^2.

    Args:
        points_W: (n, 3) m; those out of the box, and NaN, count nowhere.
        areas: (n,) what each stands for, m^2.
        low_W: (3,) the box's lower corner.
        high_W: (3,) its upper corner.
    """
    shape = _shape(tuple(low_W.tolist()), tuple(high_W.tolist()))
    points_W = np.ascontiguousarray(points_W)
    filled = _filled(points_W, np.ascontiguousarray(areas), low_W, high_W, shape)
    return np.ceil(filled).astype(np.int64)


@njit(cache=True)
def _filled(
    points_W: FloatArray,
    areas: FloatArray,
    low_W: FloatArray,
    high_W: FloatArray,
    shape: tuple[int, int, int],
) -> FloatArray:
    filled, at = np.zeros(shape), np.zeros(3, dtype=np.int64)
    for i in range(len(points_W)):
        inside = True
        for k in range(3):
            inside &= low_W[k] < points_W[i, k] < high_W[k]
            # Rounding must not lead out of the last voxel.
            index = int((points_W[i, k] - low_W[k]) / VOXEL) if inside else 0
            at[k] = min(index, shape[k] - 1)
        if inside:
            filled[at[0], at[1], at[2]] += areas[i] * 1e4
    return filled
