"""One key frame of a run: its images, and canonical points laid onto its skin."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.field.parameters import unpack_field
from bath_drake.notation import BoolArray, ByteArray, FloatArray
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.simulation_log import SimulationLog

# Depth steps above this between neighbours are edges, not slanted skin, m.
_JUMP = 0.03
# Every second row and column keeps the triangulation in tens of milliseconds.
_STRIDE = 2


@dataclass(frozen=True, eq=False)
class Keyframe:
    """What the camera and the loop saw at one instant; nothing true in it.

    Attributes:
        log: The run.
        index: Which of its key frames.
    """

    log: SimulationLog
    index: int

    @property
    def time(self) -> float:
        """When it was taken, s."""
        return float(self.log.keyframe_time[self.index])

    @cached_property
    def camera(self) -> PinholeCamera:
        """The camera."""
        width, height, fx, fy, cx, cy = self.log.intrinsics.tolist()
        return PinholeCamera(int(width), int(height), fx, fy, cx, cy)

    @property
    def colour(self) -> ByteArray:
        """(H, W, 3)."""
        return np.asarray(self.log.keyframe_colour[self.index][..., :3])

    @property
    def depth(self) -> FloatArray:
        """(H, W) m, NaN where nothing is."""
        depth = np.asarray(self.log.keyframe_depth[self.index], dtype=np.float64)
        return np.where(np.isfinite(depth), depth, np.nan)

    @property
    def mask(self) -> BoolArray:
        """(H, W) the segmented back."""
        return np.asarray(self.log.keyframe_mask[self.index], dtype=bool)

    @property
    def robot(self) -> BoolArray:
        """(H, W) the robot's own pixels."""
        return np.asarray(self.log.keyframe_robot[self.index], dtype=bool)

    @cached_property
    def canonical_map(self) -> CanonicalMap:
        """The map of this frame."""
        row = self.log.keyframe_map[self.index]
        return CanonicalMap(row[:9].reshape(3, 3), row[9:12], row[12:14])

    @cached_property
    def areas(self) -> ObstacleSet:
        """The restricted areas sensed in it, in N."""
        rows = self.log.keyframe_areas
        return ObstacleSet(rows[rows[:, 0] == self.index, 1:6])

    @cached_property
    def world(self) -> NavigationField:
        """The field in force then: learned and sensed obstacles, reconciled."""
        return unpack_field(self.log.keyframe_world[self.index])

    @cached_property
    def points_W(self) -> FloatArray:
        """(H, W, 3) what each pixel shows, in W, m; NaN where nothing is."""
        X_WC = self.log.X_WC
        points_C = self.camera.deproject(self.depth)
        return np.asarray(points_C @ X_WC[:3, :3].T + X_WC[:3, 3])

    @cached_property
    def normals_W(self) -> FloatArray:
        """(H, W, 3) unit normals towards the camera; zero at edges of depth.

        For shading; too coarse to wash by.
        """
        points = self.points_W
        along = np.zeros_like(points)
        down = np.zeros_like(points)
        along[:, 2:-2] = points[:, 4:] - points[:, :-4]
        down[2:-2] = points[4:] - points[:-4]
        flat = _step(self.depth, 1) & _step(self.depth, 0)
        with np.errstate(invalid="ignore"):
            normals = np.cross(down, along)
            length = np.linalg.norm(normals, axis=2, keepdims=True)
        good = flat[..., None] & (length > 1e-12)
        return np.asarray(np.divide(normals, length, out=0 * points, where=good))

    @cached_property
    def _drape(self) -> LinearNDInterpolator:
        usable = self.mask & np.isfinite(self.depth)
        thin = np.zeros_like(usable)
        thin[::_STRIDE, ::_STRIDE] = True
        rows, columns = np.nonzero(usable & thin)
        points = self.points_W[rows, columns]
        places = np.column_stack([columns + 0.5, rows + 0.5, points])
        return LinearNDInterpolator(
            self.canonical_map.canonical_from_world(points), places
        )

    def on_skin(self, p_N: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lays canonical points (n, 2) onto the skin this frame shows.

        Returns:
            Image coordinates (n, 2) and points in W (n, 3); NaN off the mask, and
            everywhere in a frame without an image.
            What the robot hides is filled linearly from around it.
        """
        if not np.isfinite(self.depth).any():
            nowhere = np.full((np.size(p_N) // 2, 5), np.nan)
            return nowhere[:, :2], nowhere[:, 2:]
        places = np.asarray(self._drape(np.asarray(p_N).reshape(-1, 2)))
        return places[:, :2], places[:, 2:]


def _step(depth: FloatArray, axis: int) -> BoolArray:
    """Where the four neighbours along an axis lie on one surface."""
    flat = np.zeros(depth.shape, dtype=bool)
    with np.errstate(invalid="ignore"):
        if axis == 1:
            flat[:, 2:-2] = np.abs(depth[:, 4:] - depth[:, :-4]) < _JUMP
        else:
            flat[2:-2] = np.abs(depth[4:] - depth[:-4]) < _JUMP
    return flat
