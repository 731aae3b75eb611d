"""A skin that follows the bending spine: linear blend skinning, compiled.

Of the rig's joints only those of the spine turn, so all others move with the nearest
spine joint below them, and a vertex's many weights become one for each of a few
bodies. What is left is linear in the bodies' transforms.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.spatial.transform import Rotation

from bath_drake.notation import FloatArray, IntArray
from bath_drake.patient.motion import Bend


@dataclass(frozen=True, eq=False)
class BendingSkin:
    """Points that follow the pelvis (body 0) and the joints of the spine.

    Attributes:
        pivots: (g, 3) joints of the spine at rest in M, m, from the pelvis up.
        shares: (n, g + 1) how much of each point follows each body; rows sum to 1.
        moments: (n, g + 1, 3) its place at rest times the shares, blended: the sum
            over the bodies is the point at rest in M, m.
        swelling: (n, 3) where it goes when the chest swells by one metre.
    """

    pivots: FloatArray
    shares: FloatArray
    moments: FloatArray
    swelling: FloatArray

    def __post_init__(self) -> None:
        """Makes the arrays contiguous for the kernel and checks their shapes."""
        n, bodies = len(self.shares), len(self.pivots) + 1
        for name, shape in (
            ("pivots", (bodies - 1, 3)),
            ("shares", (n, bodies)),
            ("moments", (n, bodies, 3)),
            ("swelling", (n, 3)),
        ):
            value = np.array(getattr(self, name), dtype=np.float64, order="C")
            if value.shape != shape or not np.isfinite(value).all():
                raise ValueError(f"{name} must be finite with shape {shape}")
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        """How many points there are."""
        return len(self.shares)

    def points(self, bend: Bend) -> FloatArray:
        """Returns the points (n, 3) in M, metres, of a bent trunk."""
        return _blend(
            *body_transforms(self.pivots, bend),
            self.shares,
            self.moments,
            self.swelling,
            bend.swell,
        )

    def follower(self, vertices: IntArray, weights: FloatArray) -> "BendingSkin":
        """Returns other points that follow the same way.

        Args:
            vertices: (m, 3) indices of the points that each new one follows.
            weights: (m, 3) how much of each; rows sum to 1.
        """
        return BendingSkin(
            self.pivots,
            *(
                np.einsum("mk,mk...->m...", weights, array[vertices])
                for array in (self.shares, self.moments, self.swelling)
            ),
        )

    def resting_at(self, p_M: FloatArray) -> "BendingSkin":
        """Returns the same skin with its points (n, 3) at other places at rest."""
        offsets = np.asarray(p_M, dtype=np.float64) - self.moments.sum(axis=1)
        moments = self.moments + self.shares[:, :, None] * offsets[:, None]
        return BendingSkin(self.pivots, self.shares, moments, self.swelling)


def body_transforms(pivots: FloatArray, bend: Bend) -> tuple[FloatArray, FloatArray]:
    """Returns how the bodies have moved from rest, rotations and translations.

    Each joint of the spine turns by the same share of the bend, about the axes of M:
    x to the person's left, y to the back, z up.

    Args:
        pivots: (g, 3) the joints at rest, m.
        bend: The trunk's shape.

    Returns:
        (g + 1, 3, 3) and (g + 1, 3), the pelvis, which does not move, first.
    """
    count = len(pivots)
    angles = np.array([bend.flexion, bend.side_bend, bend.twist]) / max(count, 1)
    turn = Rotation.from_euler("xyz", angles).as_matrix()
    rotations = np.tile(np.eye(3), (count + 1, 1, 1))
    translations = np.zeros((count + 1, 3))
    for k, pivot in enumerate(pivots):
        rotations[k + 1] = rotations[k] @ turn
        translations[k + 1] = translations[k] + rotations[k] @ (pivot - turn @ pivot)
    return rotations, translations


@njit(cache=True)
def _blend(
    rotations: FloatArray,
    translations: FloatArray,
    shares: FloatArray,
    moments: FloatArray,
    swelling: FloatArray,
    swell: float,
) -> FloatArray:
    count, bodies = shares.shape
    points = np.zeros((count, 3))
    for i in range(count):
        for g in range(bodies):
            share = shares[i, g]
            if share == 0.0:
                continue
            x = moments[i, g, 0] + share * swell * swelling[i, 0]
            y = moments[i, g, 1] + share * swell * swelling[i, 1]
            z = moments[i, g, 2] + share * swell * swelling[i, 2]
            for k in range(3):
                points[i, k] += (
                    rotations[g, k, 0] * x
                    + rotations[g, k, 1] * y
                    + rotations[g, k, 2] * z
                    + translations[g, k] * share
                )
    return points
