"""Skin that the robot hides now, as it is known from before, moved with the body."""

from dataclasses import dataclass, field

import numpy as np

from bath_drake.notation import FloatArray
from bath_drake.perception.height_field import CELL, CELLS, counted
from bath_drake.perception.tracked_map import TrackedBody
from bath_drake.shared import Shared


@dataclass(frozen=True, eq=False)
class RecalledSkin(Shared):
    """Points of skin that a frame does not show.

    Attributes:
        points_W: (n, 3) m, a centimetre apart.
    """

    points_W: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))


def recall(body: TrackedBody, points_W: FloatArray) -> RecalledSkin:
    """Returns the known skin of the cells in which a frame has no points.

    Args:
        body: As it is in that frame.
        points_W: (m, 3) the points that the frame shows, m.
    """
    seen = counted(body.pose.unbent(points_W))
    i, j = np.nonzero(body.skin.known & (seen == 0.0))
    x, y = (np.stack([i, j]) - CELLS // 2 + 0.5) * CELL
    p_B = np.column_stack([x, y, body.skin.surface[i, j, 0]])
    return RecalledSkin(body.pose.bent(p_B))
