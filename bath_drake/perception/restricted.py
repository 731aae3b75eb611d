"""Restricted areas on the skin, such as wounds, seen by their colour (Fig. 5)."""

import cv2
import numpy as np

from bath_drake.field.obstacles import ObstacleSet
from bath_drake.notation import BoolArray, FloatArray
from bath_drake.perception import morphology
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.ellipses import enclosing_ellipse
from bath_drake.perception.skin_colour import off_skin, skin_deviations

# At the back's edge, which is where more than this share of a patch's surroundings is
# off the back, skin turns away from the light and mixes with what is behind it: there
# only what is this much darker, brighter or of another colour counts.
EDGE_SHARE = 0.2
EDGE_DARK = float(np.log(0.5))
EDGE_BRIGHT = float(np.log(2.0))
EDGE_COLOUR = 0.3

# Narrower than twice this, in pixels, is the rim of the mask, not an area.
RIM = 1.0


def find_restricted_areas(
    observation: BodyObservation,
    canonical_map: CanonicalMap,
    margin_m: float,
    min_area: float = 2e-4,
) -> ObstacleSet:
    """Finds patches that are no skin: darker, paler or of another colour.

    Args:
        observation: The back; pixels of the robot are not in it.
        canonical_map: Where the back is.
        margin_m: Every point this near to a patch, along the back's plane, is
            restricted too, metres.
        min_area: Smaller patches are not counted, m^2.

    Returns:
        One ellipse in N around each patch: the least one that contains its points
        with the margin around them.

    Raises:
        ValueError: If the margin is negative.
    """
    if not margin_m >= 0.0:
        raise ValueError(f"margin_m must be >= 0, got {margin_m}")
    deviations = skin_deviations(observation)
    if len(deviations) == 0:
        return ObstacleSet()
    view = _View(observation)
    patches = morphology.opened(view.placed(off_skin(deviations)), RIM)
    if not patches.any():
        return ObstacleSet()
    count, labels = cv2.connectedComponents(patches.view(np.uint8), connectivity=8)
    label = labels[view.rows, view.columns]
    areas = np.bincount(label, observation.point_areas, minlength=count)
    p_P = canonical_map.plane_from_world(observation.points_W)[:, :2]
    ellipses = []
    for k in range(1, count):
        if areas[k] < min_area:
            continue
        inside = label == k
        at_edge = view.edge_share(labels == k) > EDGE_SHARE
        if at_edge and not _far_off(deviations[inside].mean(axis=0)):
            continue
        # The skin a pixel stands for reaches half its size beyond its centre.
        reach = margin_m + np.sqrt(observation.point_areas[inside].max() / 2.0)
        ellipse = enclosing_ellipse(p_P[inside], reach)
        ellipses.append(canonical_map.ellipse_to_canonical(ellipse))
    return ObstacleSet(np.array(ellipses).reshape(-1, 5))


def _far_off(mean: FloatArray) -> bool:
    """Whether a patch at the back's edge, of such a mean deviation (3,), counts."""
    return bool(
        not EDGE_DARK < mean[0] < EDGE_BRIGHT or np.abs(mean[1:]).max() > EDGE_COLOUR
    )


class _View:
    """The window of the image in which the back's points are.

    Attributes:
        rows: (n,) of the window, in which each point is.
        columns: (n,) likewise.
    """

    def __init__(self, observation: BodyObservation) -> None:
        """Takes the window with the two pixels around it that may matter."""
        columns, rows = observation.pixels.T
        top, left = max(int(rows.min()) - 2, 0), max(int(columns.min()) - 2, 0)
        window = slice(top, int(rows.max()) + 3), slice(left, int(columns.max()) + 3)
        self.rows, self.columns = rows - top, columns - left
        self._mask = observation.mask[window]
        self._robot_mask = observation.robot_mask[window]

    def placed(self, flags: BoolArray) -> BoolArray:
        """Returns flags (n,) of the points where these are; False elsewhere."""
        image = np.zeros(self._mask.shape, dtype=bool)
        image[self.rows, self.columns] = flags
        return image

    def edge_share(self, area: BoolArray) -> float:
        """Returns the share of an area's surroundings neither back nor robot."""
        ring = morphology.dilate(area, 1.5) & ~area
        outside = ring & ~self._mask & ~self._robot_mask
        return float(outside.sum()) / max(int(ring.sum()), 1)
