"""Smooths the canonical map over frames.

A mask's edge flickers by a pixel or two, and what the arm hides is a guess; the
canonical frame must not follow either, or the nozzle would, and hide something
else in turn. Where the skin is under the nozzle comes from the newest frame all the
same: only the place *along* the back is smoothed, and bodies move slowly there.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from bath_drake.notation import FloatArray
from bath_drake.perception.canonical import CanonicalMap


@dataclass(frozen=True, kw_only=True)
class MapFilter:
    """Time constants of the first-order filters on the map.

    Attributes:
        pose_time: Of the back's frame, s. A back that shifts at 5 mm/s along
            itself is then followed 2.5 mm late.
        size_time: Of the box's extents, s: a body does not change its size.
    """

    pose_time: float = 0.5
    size_time: float = 3.0

    def __post_init__(self) -> None:
        """Raises ValueError unless both are positive and finite."""
        for name, value in vars(self).items():
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} must be positive and finite, got {value}")

    def next(self, smooth: CanonicalMap, seen: CanonicalMap, dt: float) -> CanonicalMap:
        """Returns the smoothed map, `dt` seconds after `smooth` was.

        Args:
            smooth: The smoothed map so far.
            seen: The newest frame's own map.
            dt: s.
        """
        pose, size = (1.0 - math.exp(-dt / t) for t in (self.pose_time, self.size_time))
        turn = Rotation.from_matrix(smooth.R_WP.T @ seen.R_WP).as_rotvec()
        R_WP: FloatArray = smooth.R_WP @ Rotation.from_rotvec(pose * turn).as_matrix()
        # Thousands of products drift off the rotations by rounding.
        u, _, vt = np.linalg.svd(R_WP)
        return CanonicalMap(
            u @ vt,
            smooth.p_WP + pose * (seen.p_WP - smooth.p_WP),
            smooth.half_extents + size * (seen.half_extents - smooth.half_extents),
        )
