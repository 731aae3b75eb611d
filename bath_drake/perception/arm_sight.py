"""Whether a camera shows the arm where its joints say it is.

A camera that was knocked, or whose pose was never right, sees what is behind the arm in
pixels that the arm must hide.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from bath_drake.notation import BoolArray, FloatArray
from bath_drake.perception import morphology
from bath_drake.shared import Shared

# m: hulls hold a little more than the arm. px: and depth is vague at its rim.
RIM, LEAST_RIM = 0.013, 4.0
# Fewer pixels of the arm than this say nothing.
LEAST_PIXELS = 100
# m: depth this much behind the arm's far side is not the arm's.
_BEHIND = 0.03
# Frames in a row that must agree, and for how long what they say stands, s.
_FRAMES, _STANDS = 3, 1.0


def rim_width(depth: FloatArray, robot_mask: BoolArray, focal: float) -> float:
    """Returns how wide a silhouette's rim says nothing, px.

    Args:
        depth: (h, w) of some of the image's pixels, m.
        robot_mask: (h, w) of them, the silhouette.
        focal: The camera's focal length, px.
    """
    known = depth[robot_mask & np.isfinite(depth) & (depth > 0.0)]
    return max(RIM * focal / float(np.median(known)), LEAST_RIM) if len(known) else 0.0


def arm_core(robot_mask: BoolArray, rim: float) -> BoolArray:
    """Returns the pixels (H, W) that must show the arm or what is before it.

    Args:
        robot_mask: (H, W) the arm's silhouette and a little more.
        rim: Of what width it may be more, px.
    """
    core = np.zeros_like(robot_mask)
    rows, columns = (np.flatnonzero(robot_mask.any(axis=k)) for k in (1, 0))
    if len(rows):
        # With what is around it: a rim is where the arm ends, not where the image does.
        wide = int(np.ceil(rim))
        window = (
            slice(max(rows[0] - wide, 0), rows[-1] + wide + 1),
            slice(max(columns[0] - wide, 0), columns[-1] + wide + 1),
        )
        core[window] = morphology.erode(robot_mask[window], rim)
    return core


@njit(cache=True)
def seen_through(
    depth: FloatArray,
    rays: FloatArray,
    core: BoolArray,
    R_WC: FloatArray,
    p_WC: FloatArray,
    capsules_W: FloatArray,
) -> float:
    """Returns the share of the arm's pixels that show what is behind it.

    What is before the arm, and what has no depth, counts for nothing.

    Args:
        depth: (H, W) along the optical axis, m; zero or not finite for nothing.
        rays: (H, W, 3) the pixels' rays at depth 1, in C.
        core: (H, W) of `arm_core`.
        R_WC: (3, 3) the camera's orientation.
        p_WC: (3,) its place, m.
        capsules_W: (n, 7) around the arm's links: both ends and a radius, m.

    Returns:
        In [0, 1]; zero where fewer than `LEAST_PIXELS` show the arm.
    """
    looked = behind = 0
    rows, columns = core.shape
    ray = np.empty(3)
    for v in range(rows):
        for u in range(columns):
            z = depth[v, u]
            if not (core[v, u] and 0.0 < z < np.inf):
                continue
            for i in range(3):
                ray[i] = 0.0
                for j in range(3):
                    ray[i] += R_WC[i, j] * rays[v, u, j]
            near, far = np.inf, -np.inf
            for k in range(len(capsules_W)):
                middle, half = _within(p_WC, ray, capsules_W[k])
                if half >= 0.0:
                    near, far = min(near, middle - half), max(far, middle + half)
            # Before the camera there is a capsule, and the pixel not before that.
            if far > 0.0 and z >= near - _BEHIND:
                looked += 1
                behind += z > far + _BEHIND
    return behind / looked if looked >= LEAST_PIXELS else 0.0


@njit(cache=True)
def _within(
    p_WC: FloatArray, ray: FloatArray, capsule: FloatArray
) -> tuple[float, float]:
    """Where on a ray its part inside a capsule has its middle, and half its length.

    In units of the ray; the half is negative where the ray misses the capsule. The part
    is that in a ball around the segment's point nearest to the ray: no longer than the
    true one.
    """
    rr = uu = ru = rw = uw = 0.0
    for i in range(3):
        r, u, w = ray[i], capsule[3 + i] - capsule[i], p_WC[i] - capsule[i]
        rr, uu, ru = rr + r * r, uu + u * u, ru + r * u
        rw, uw = rw + r * w, uw + u * w
    det = rr * uu - ru * ru
    # Along the ray any point of the segment is as near as another.
    t = (rr * uw - ru * rw) / det if det > 1e-12 * rr * uu else 0.0
    t = min(max(t, 0.0), 1.0)
    s = max((t * ru - rw) / rr, 0.0)
    away2 = 0.0
    for i in range(3):
        u, w = capsule[3 + i] - capsule[i], p_WC[i] - capsule[i]
        away2 += (w + s * ray[i] - t * u) ** 2
    left2 = capsule[6] ** 2 - away2
    return s, np.sqrt(left2 / rr) if left2 >= 0.0 else -1.0


@dataclass(frozen=True, eq=False)
class ArmSight(Shared):
    """What the last frames say; before the first, nothing.

    Attributes:
        frames: Stamp, s, and share seen through of each of the last, oldest first.
    """

    frames: tuple[tuple[float, float], ...] = ()

    def next(self, stamp: float, share: float) -> "ArmSight":
        """Returns it after one more frame."""
        kept = (f for f in self.frames if f[0] >= stamp - _STANDS)
        return ArmSight((*kept, (stamp, share)))

    @property
    def share(self) -> float:
        """The greatest share of the last second that some frames in a row agree on."""
        shares = [share for _, share in self.frames]
        runs = range(len(shares) - _FRAMES + 1)
        return max((min(shares[k : k + _FRAMES]) for k in runs), default=0.0)
