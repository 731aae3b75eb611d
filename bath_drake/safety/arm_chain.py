"""An arm of seven joints in plain arrays: how its links hang together, and their shape.

In the arm's base frame B. Each link's frame has its joint's axis along z; the nozzle is
counted as link 8 and told in link 7's frame.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray, IntArray
from bath_drake.safety.limits import JOINTS

NOZZLE = JOINTS + 1
# Pairs of links with so many joints between them may come to touch: nearer ones meet in
# a joint, or its range keeps them apart. Of the nozzle and link 5, link 6 is between.
_APART, _NOZZLE_APART = 3, 4


@dataclass(frozen=True, eq=False)
class ArmChain:
    """An arm.

    Attributes:
        origins: (7, 3) each joint's origin in the frame of the link before it, m.
        turns: (7, 3, 3) its frame's axes there, while the joint is at zero.
        tip: (3, 4) axes and origin of the nozzle's frame E in link 7's.
        low: (7,) least positions, rad.
        high: (7,) greatest positions, rad.
        speed: (7,) greatest speeds, rad/s.
        capsules: (n, 8) link, by ascending number; its segment's two ends in the
            link's frame, m; radius, m. Each link's shape is inside its own.
        pairs: (m, 2) rows of `capsules` that must not touch; by default those far
            enough apart along the chain.
    """

    origins: FloatArray
    turns: FloatArray
    tip: FloatArray
    low: FloatArray
    high: FloatArray
    speed: FloatArray
    capsules: FloatArray
    pairs: IntArray = field(default_factory=lambda: np.zeros((0, 2), np.int64))

    def __post_init__(self) -> None:
        """Fills the pairs in; raises ValueError on a wrong shape or order."""
        for name, shape in (
            ("origins", (JOINTS, 3)),
            ("turns", (JOINTS, 3, 3)),
            ("tip", (3, 4)),
            ("low", (JOINTS,)),
            ("high", (JOINTS,)),
            ("speed", (JOINTS,)),
            ("capsules", (len(self.capsules), 8)),
        ):
            value = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            if value.shape != shape or not np.isfinite(value).all():
                raise ValueError(f"{name} must be finite and {shape}, got {value}")
            object.__setattr__(self, name, value)
        links = self.capsules[:, 0].astype(np.int64)
        if not (np.diff(links) >= 0).all() or not set(links) <= set(range(NOZZLE + 1)):
            raise ValueError(f"capsules must be of links 0 to 8 in turn, got {links}")
        object.__setattr__(self, "pairs", _pairs(links))

    def with_tool(self, capsules_E: FloatArray) -> "ArmChain":
        """Returns the arm with a tool at its nozzle.

        Args:
            capsules_E: (k, 7) a segment's ends in E, m, and a radius, m, each.
        """
        R, p = self.tip[:, :3], self.tip[:, 3]
        ends = capsules_E[:, :6].reshape(-1, 2, 3) @ R.T + p
        rows = np.column_stack(
            [np.full(len(ends), NOZZLE), ends.reshape(-1, 6), capsules_E[:, 6]]
        )
        return replace(self, capsules=np.vstack([self.capsules, rows]))


def _pairs(links: IntArray) -> IntArray:
    pairs = [
        (i, j)
        for i in range(len(links))
        for j in range(i + 1, len(links))
        if links[j] - links[i] >= (_NOZZLE_APART if links[j] == NOZZLE else _APART)
    ]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


@njit(cache=True)
def next_link(
    p: FloatArray,
    before: FloatArray,
    after: FloatArray,
    origin: FloatArray,
    turn: FloatArray,
    angle: float,
) -> None:
    """Goes from one link to the next, in place.

    Args:
        p: (3,) the link's origin in B; then the next one's.
        before: (3, 3) its axes in B.
        after: (3, 3) out, the next one's.
        origin: (3,) the next one's in this.
        turn: (3, 3) likewise its axes while the joint is at zero.
        angle: The joint's position, rad.
    """
    s, c = np.sin(angle), np.cos(angle)
    for i in range(3):
        for j in range(3):
            p[i] += before[i, j] * origin[j]
        x = y = z = 0.0
        for j in range(3):
            x += before[i, j] * turn[j, 0]
            y += before[i, j] * turn[j, 1]
            z += before[i, j] * turn[j, 2]
        after[i, 0] = c * x + s * y
        after[i, 1] = c * y - s * x
        after[i, 2] = z


@njit(cache=True)
def link_frames(
    q: FloatArray, origins: FloatArray, turns: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Returns axes (n + 1, 3, 3) and origins (n + 1, 3), m, of base and links in B."""
    R, p = np.empty((len(q) + 1, 3, 3)), np.empty((len(q) + 1, 3))
    for i in range(3):
        p[0, i] = 0.0
        for j in range(3):
            R[0, i, j] = 1.0 if i == j else 0.0
    for k in range(len(q)):
        for i in range(3):
            p[k + 1, i] = p[k, i]
        next_link(p[k + 1], R[k], R[k + 1], origins[k], turns[k], q[k])
    return R, p


@njit(cache=True)
def place_segment(
    R: FloatArray, p: FloatArray, capsule: FloatArray, ends: FloatArray
) -> int:
    """Writes both ends (2, 3) of a capsule's segment in B, and returns its link.

    Args:
        R: Axes as of `link_frames`.
        p: Origins as of `link_frames`.
        capsule: (8,) a row of `ArmChain.capsules`.
        ends: (2, 3) out, m.
    """
    link = int(capsule[0])
    # The nozzle, the last, is told in the frame of the link before it.
    told = min(link, len(p) - 1)
    for end in range(2):
        for i in range(3):
            ends[end, i] = p[told, i]
            for j in range(3):
                ends[end, i] += R[told, i, j] * capsule[1 + 3 * end + j]
    return link


@njit(cache=True)
def slope_of_turn(
    R: FloatArray, p: FloatArray, joint: int, point: FloatArray, way: FloatArray
) -> float:
    """How fast a point of a link moves along a way as a joint before it turns, m/rad.

    Args:
        R: Axes as of `link_frames`.
        p: Origins as of `link_frames`.
        joint: From 0.
        point: (3,) in B, m.
        way: (3,) in B; of length one for metres a radian.
    """
    x, y, z = point - p[joint + 1]
    u, v, w = R[joint + 1, :, 2]
    along = way[0] * (v * z - w * y) + way[1] * (w * x - u * z)
    return float(along + way[2] * (u * y - v * x))
