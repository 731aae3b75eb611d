"""The rim of the seen back in canonical space: where the motion must stay.

The paper's beta_0 is the body part's limit. A back is broad above and below and narrow
at the waist; the superellipse taken here is as broad as that allows. What is left out
is at the corners: shoulders and hips.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_fill_holes

from bath_drake.field.obstacles import Workspace
from bath_drake.notation import FloatArray

# Sixth power: nine tenths of a back are within, and beta_0 is flat where strokes are.
POWER = 6

# Along the body the box's own limits, 1 to 99 % of the skin.
LENGTH = 1.0

# Half breadths tried, in N; a back narrower than the last has no such rim.
BROADEST, NARROWEST, STEP = 1.0, 0.5, 0.01

# The share of the superellipse that is on the back: its edge flickers by a pixel.
ON_BACK = 0.985

# Cells of the grid it is counted on, in N, and how far the grid reaches.
CELL, REACH = 0.04, 1.4


@dataclass(frozen=True)
class SeenRim:
    """What a frame tells of a back's rim.

    Attributes:
        workspace: The rim in N; None where none is known.
    """

    workspace: Workspace | None = None


def body_rim(p_N: FloatArray) -> Workspace | None:
    """Returns the broadest superellipse that is on the back; None if it is too narrow.

    Args:
        p_N: (n, 2) points of the back in canonical space, what the robot hides
            included.
    """
    count = round(2.0 * REACH / CELL)
    edges = np.linspace(-REACH, REACH, count + 1)
    hits, _, _ = np.histogram2d(p_N[:, 0], p_N[:, 1], bins=[edges, edges])
    back = binary_fill_holes(hits > 0)
    middles = (edges[:-1] + edges[1:]) / 2.0
    x, y = np.meshgrid(middles, middles, indexing="ij")
    along = np.abs(y / LENGTH) ** POWER
    for half_breadth in np.arange(BROADEST, NARROWEST - STEP / 2.0, -STEP):
        inside = np.abs(x / half_breadth) ** POWER + along <= 1.0
        if np.count_nonzero(back & inside) >= ON_BACK * np.count_nonzero(inside):
            return Workspace(np.zeros(2), np.array([half_breadth, LENGTH]), POWER)
    return None


def share_within(rim: Workspace, p_N: FloatArray, areas: FloatArray) -> float:
    """Returns the share of a back's surface that is within a rim.

    Args:
        rim: Of `body_rim`.
        p_N: (n, 2) points of the back in canonical space.
        areas: (n,) surface each stands for.
    """
    return float(areas[rim.beta(p_N) > 0.0].sum() / areas.sum())
