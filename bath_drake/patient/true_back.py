"""The back as it truly is, told in the words of perception.

For runs in which perception is taken as perfect (`perception.source: ideal`): what a
camera, its segmenter and its map would say if they made no error and nothing hid the
person. No image is rendered.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from numba import njit

from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import BoolArray, ByteArray, FloatArray, IntArray
from bath_drake.patient.bending import BendingSkin
from bath_drake.patient.motion import Bend
from bath_drake.patient.people import Person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.wound import WoundPatch
from bath_drake.perception.area_memory import merge_areas
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.body_rim import body_rim
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.ellipses import enclosing_ellipse
from bath_drake.perception.given_areas import given_areas

# Places of skin are so far apart in N, 3 to 6 mm, as a camera's pixels are, and lie
# within so much of the middle.
PITCH, REACH = 0.025, 1.4
# Skin seen this far from along it stands for no more area, as a cosine.
_LEAST_COSINE = 0.2


class TrueBack:
    """Places of skin all over a person's back, which go where the skin goes.

    The canonical map is that of the labelled back at rest. Of a back that bends it is
    carried along by the rigid motion nearest to that of the skin within its box.

    Attributes:
        rim: Of the back in N (`bath_drake.perception.body_rim`), or None.
        areas: What is to be kept off, in N.
    """

    rim: Workspace | None
    areas: ObstacleSet

    def __init__(
        self,
        person: Person,
        *,
        bends: bool,
        wound: WoundPatch | None,
        given: Sequence[Sequence[Sequence[float]]],
        margin: float,
        camera: PinholeCamera,
        R_WC: FloatArray,
        p_WC: FloatArray,
    ) -> None:
        """Chooses the places and finds all that does not change.

        Args:
            person: Whose back.
            bends: Whether the skin will bend.
            wound: The true one, at rest, or None.
            given: Polygons in N that the carer wants kept off.
            margin: Kept around wound and polygons along the back's plane, m.
            camera: Whose pixels the places fall onto.
            R_WC: (3, 3) its orientation.
            p_WC: (3,) where it is, m.

        Raises:
            ScenarioError: If the person is to bend and has no sound rig.
        """
        skin = TrueSkin(person)
        self._map = skin.canonical_map
        p_N, self._rest, normals = _places(skin)
        cosine = np.maximum(normals @ self._map.normal_W, _LEAST_COSINE)
        cell = PITCH**2 * self._map.half_extents.prod()
        self._areas: FloatArray = cell / cosine
        self._bending: BendingSkin | None = None
        if bends:
            follower = bending_skin(person).follower(*skin.bind(self._rest))
            self._bending = follower.resting_at(self._rest)
        in_box = np.abs(p_N).max(axis=1) <= 1.0
        self._share = np.where(in_box, self._areas, 0.0) / self._areas[in_box].sum()
        self._camera = camera
        self._R_WC, self._p_WC = np.array(R_WC), np.array(p_WC)
        self._no_robot = np.zeros(camera.shape, dtype=bool)
        self._colours = np.zeros((len(p_N), 3), dtype=np.uint8)
        self._ages = np.zeros(len(p_N))
        self.rim = body_rim(p_N)
        self.areas = _areas_to_keep_off(self._map, wound, given, margin)

    def observe(
        self, R_WM: FloatArray, p_WM: FloatArray, bend: Bend, stamp: float
    ) -> BodyObservation:
        """Returns what perfect perception says of the back.

        Its `tracked_map` is the true map. Colours are black, for nothing is rendered,
        and of the mask the places' own pixels and their neighbours are set.

        Args:
            R_WM: (3, 3) orientation of the person.
            p_WM: (3,) place of the person, m.
            bend: The trunk's shape; of a person that does not bend it is ignored.
            stamp: When that is, s.
        """
        p_M = self._rest if self._bending is None else self._bending.points(bend)
        moved = self._map if self._bending is None else self._carried(p_M)
        points_W = p_M @ R_WM.T + p_WM
        pixels, mask = self._in_image(points_W)
        area = float(self._areas.sum())
        return BodyObservation(
            stamp=stamp,
            mask=mask,
            robot_mask=self._no_robot,
            points_W=points_W,
            pixels=pixels,
            colours=self._colours,
            point_areas=self._areas,
            completed_points_W=points_W,
            completed_areas=self._areas,
            completed_ages=self._ages,
            area=area,
            tracked_map=CanonicalMap(
                R_WM @ moved.R_WP, R_WM @ moved.p_WP + p_WM, moved.half_extents
            ),
            reference_area=area,
            visible_fraction=1.0,
            found=True,
            R_WC=self._R_WC,
            p_WC=self._p_WC,
        )

    def _carried(self, p_M: FloatArray) -> CanonicalMap:
        """The map of the bent back in M: the nearest rigid motion (Kabsch 1976)."""
        before, after = self._share @ self._rest, self._share @ p_M
        spread = (self._rest - before).T @ ((p_M - after) * self._share[:, None])
        u, _, vt = np.linalg.svd(spread)
        # Turns alone, no reflections.
        sign = np.array([1.0, 1.0, np.sign(np.linalg.det(vt.T @ u.T))])
        R = vt.T @ (sign[:, None] * u.T)
        return CanonicalMap(
            R @ self._map.R_WP,
            after + R @ (self._map.p_WP - before),
            self._map.half_extents,
        )

    def _in_image(self, points_W: FloatArray) -> tuple[IntArray, BoolArray]:
        """Pixels (n, 2) of points, the nearest ones of those beside it, and a mask."""
        camera = self._camera
        mask = np.zeros(camera.shape, dtype=np.uint8)
        lens = camera.fx, camera.fy, camera.cx, camera.cy
        pixels = _look_at(points_W, self._R_WC, self._p_WC, lens, mask)
        # Places are further apart than pixels where the camera is near.
        mask = np.asarray(cv2.dilate(mask, np.ones((3, 3), np.uint8)))
        return pixels, mask.view(np.bool_)


@njit(cache=True)
def _look_at(
    points_W: FloatArray,
    R_WC: FloatArray,
    p_WC: FloatArray,
    lens: tuple[float, float, float, float],
    mask: ByteArray,
) -> IntArray:
    """Sets the pixels of points in a mask; returns them, or what is nearest there."""
    height, width = mask.shape
    fx, fy, cx, cy = lens
    pixels = np.zeros((len(points_W), 2), dtype=np.int64)
    for i in range(len(points_W)):
        # Number by number: a small array for each point would take most of the time.
        a, b = points_W[i, 0] - p_WC[0], points_W[i, 1] - p_WC[1]
        c = points_W[i, 2] - p_WC[2]
        z = a * R_WC[0, 2] + b * R_WC[1, 2] + c * R_WC[2, 2]
        if not z > 0.0:
            continue
        x = a * R_WC[0, 0] + b * R_WC[1, 0] + c * R_WC[2, 0]
        y = a * R_WC[0, 1] + b * R_WC[1, 1] + c * R_WC[2, 1]
        u, v = fx * x / z + cx, fy * y / z + cy
        column, row = min(max(u, 0.0), width - 1.0), min(max(v, 0.0), height - 1.0)
        pixels[i, 0], pixels[i, 1] = int(column), int(row)
        if 0.0 <= u < width and 0.0 <= v < height:
            mask[int(row), int(column)] = 1
    return pixels


def _places(skin: TrueSkin) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Places of the back in N (n, 2) and M (n, 3), and the normals there (n, 3)."""
    steps = np.arange(-REACH, REACH + PITCH / 2.0, PITCH)
    p_N = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    p_M, met = skin.under(p_N)
    p_N, p_M = p_N[met], p_M[met]
    back = skin.on_back(p_M)
    p_N, p_M = p_N[back], p_M[back]
    return p_N, p_M, skin.nearest(p_M)[2]


def _areas_to_keep_off(
    canonical_map: CanonicalMap,
    wound: WoundPatch | None,
    given: Sequence[Sequence[Sequence[float]]],
    margin: float,
) -> ObstacleSet:
    polygons = [np.array(corners, dtype=np.float64) for corners in given]
    areas = given_areas(polygons, canonical_map, margin)
    if wound is not None:
        outline = canonical_map.plane_from_world(wound.outline)[:, :2]
        ellipse = enclosing_ellipse(outline, margin)
        row = canonical_map.ellipse_to_canonical(ellipse)
        areas = merge_areas(areas, ObstacleSet(row[None]), tolerance=0.0)
    return areas
