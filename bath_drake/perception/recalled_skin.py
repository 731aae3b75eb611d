"""Skin that the robot hides now, as it is known from before, moved with the body."""

from dataclasses import dataclass, field

import numpy as np
from numba import njit

from bath_drake.notation import BoolArray, FloatArray, IntArray
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.completion import pixel_indices
from bath_drake.perception.height_field import CELL, CELLS, counted
from bath_drake.perception.tracked_map import TrackedBody
from bath_drake.shared import Shared

# px: next to the robot no skin is seen either, for its mask's rim is eroded.
_BESIDE = 4


@dataclass(frozen=True, eq=False)
class RecalledSkin(Shared):
    """Points of skin that a frame does not show.

    Attributes:
        points_W: (n, 3) m, a centimetre apart.
    """

    points_W: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))


def recall(body: TrackedBody, observation: BodyObservation) -> RecalledSkin:
    """Returns the known skin of the cells that a frame does not show for the robot.

    What glare, water or anybody else hides is not recalled: something may be there.

    Args:
        body: As it is in that frame.
        observation: The frame.
    """
    camera = observation.camera
    if camera is None or not observation.robot_mask.any():
        return RecalledSkin()
    unseen_W = _unseen(body, observation.points_W)
    indices = pixel_indices(unseen_W, camera, observation.R_WC, observation.p_WC)
    return RecalledSkin(unseen_W[_beside(observation.robot_mask, indices, _BESIDE)])


def _unseen(body: TrackedBody, points_W: FloatArray) -> FloatArray:
    """The known skin (n, 3) of the cells in which none of the points (m, 3) is, m."""
    seen = counted(body.pose.unbent(points_W))
    whole, heights = body.skin.whole_cells
    i, j = np.nonzero(whole & (seen == 0.0))
    x, y = (np.stack([i, j]) - CELLS // 2 + 0.5) * CELL
    return body.pose.bent(np.column_stack([x, y, heights[i, j]]))


@njit(cache=True)
def _beside(mask: BoolArray, indices: IntArray, reach: int) -> BoolArray:
    """Which of some pixels (n, 2), row and column, -1 if none, a mask is near to."""
    rows, columns = mask.shape
    found = np.zeros(len(indices), dtype=np.bool_)
    for i in range(len(indices)):
        v, u = indices[i, 0], indices[i, 1]
        if v < 0:
            continue
        for row in range(max(v - reach, 0), min(v + reach + 1, rows)):
            for column in range(max(u - reach, 0), min(u + reach + 1, columns)):
                if mask[row, column]:
                    found[i] = True
    return found
