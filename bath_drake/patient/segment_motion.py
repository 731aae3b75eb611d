"""How the skin that is touched moves: a chain of slabs that hang on joints.

Each slab moves as one, by the rigid motion nearest to that of its skin (Kabsch, 1976).
In a plant it hangs in the world by three sliding joints along the axes M has at first
and then three that turn, about z, y and x: yaw, pitch and roll.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bath_drake.notation import FloatArray, IntArray
from bath_drake.patient.bending import BendingSkin
from bath_drake.patient.motion import Bend, MotionConfig, trunk_bend

Pose = tuple[FloatArray, FloatArray]


@dataclass(frozen=True, eq=False)
class SkinSegment:
    """One slab of skin at rest.

    Attributes:
        centre: (3,) in M, m: the slab's own origin, its axes are M's.
        nodes: (n, 3) of its mesh about the centre, m, in three layers of as many: on
            the skin, at the depth of the greatest pressure, and twice as deep.
        tetrahedra: (m, 4) indices of nodes, each of positive volume.
        triangles: (t, 3) indices of those on the skin, counter-clockwise from outside.
    """

    centre: FloatArray
    nodes: FloatArray
    tetrahedra: IntArray
    triangles: IntArray


@dataclass(frozen=True, eq=False)
class SegmentedSkin:
    """The slabs of a person's back, and how they move.

    Attributes:
        segments: From the pelvis up.
        places: How the skin of all slabs, without overlaps, moves; None of a person
            that does not bend.
        owners: (k,) the slab of each place, rising.
    """

    segments: tuple[SkinSegment, ...]
    places: BendingSkin | None
    owners: IntArray

    def poses(self, bend: Bend) -> tuple[FloatArray, FloatArray]:
        """Returns rotations (n, 3, 3) and origins (n, 3), m, of the slabs in M.

        Args:
            bend: The trunk's shape; of a person that does not bend it is ignored.
        """
        if self.places is None:
            return np.tile(np.eye(3), (len(self.segments), 1, 1)), self.centres
        begins, sizes, before, a = self._at_rest
        now = self.places.points(bend)
        after = np.add.reduceat(now, begins) / sizes
        b = now - after[self.owners]
        spread = np.add.reduceat(a[:, :, None] * b[:, None, :], begins)
        u, _, vt = np.linalg.svd(spread)
        # Turns alone, no reflections.
        vt[:, 2] *= np.linalg.det(u @ vt)[:, None]
        R = np.swapaxes(u @ vt, 1, 2)
        return R, after + np.einsum("nij,nj->ni", R, self.centres - before)

    @cached_property
    def centres(self) -> FloatArray:
        """The slabs' origins (n, 3) in M at rest, m."""
        return np.array([segment.centre for segment in self.segments])

    @cached_property
    def _at_rest(self) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
        """Each slab's first place, their number and mean; the places about that."""
        assert self.places is not None
        count = len(self.segments)
        begins = np.searchsorted(self.owners, np.arange(count))
        sizes = np.bincount(self.owners, minlength=count)[:, None].astype(np.float64)
        rest = self.places.moments.sum(axis=1)
        before = np.add.reduceat(rest, begins) / sizes
        return begins, sizes, before, rest - before[self.owners]


def segment_positions(
    skin: SegmentedSkin, motion: MotionConfig, t: float, *, start: Pose, person: Pose
) -> FloatArray:
    """Returns the joints' positions (6 n,): m, m, m, rad, rad, rad a slab.

    All are zero where person and trunk are as at the start.

    Args:
        skin: The n slabs.
        motion: How the trunk bends.
        t: When that is, s.
        start: X_WM that the joints are measured from: rotation (3, 3), origin (3,).
        person: X_WM at t, likewise.
    """
    R_MS, p_MS = skin.poses(trunk_bend(t, motion))
    R = start[0].T @ person[0]
    p = p_MS @ R.T + start[0].T @ (person[1] - start[1]) - skin.centres
    return np.hstack([p, yaw_pitch_roll(R @ R_MS)]).ravel()


def yaw_pitch_roll(R: FloatArray) -> FloatArray:
    """Returns angles (n, 3), rad, of Rz(yaw) Ry(pitch) Rx(roll) = R (n, 3, 3)."""
    return np.stack(
        [
            np.arctan2(R[:, 1, 0], R[:, 0, 0]),
            np.arcsin(np.clip(-R[:, 2, 0], -1.0, 1.0)),
            np.arctan2(R[:, 2, 1], R[:, 2, 2]),
        ],
        axis=1,
    )
