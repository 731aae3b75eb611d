"""What the arm's links must keep off: the person, as far as the back tells, and things.

Everything is boxes: of the person seven, laid out from the back's box as perception has
it (no other part of a person is looked for), the stool and the pedestal one each. The
person's are larger than all our people at rest are, arms beside the trunk included; an
arm that is raised towards the robot is not in them.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.notation import FloatArray, IntArray
from bath_drake.safety.arm_chain import NOZZLE
from bath_drake.shared import Shared

# Rows: low and high corner of a box along x (to the person's right), y (to the head)
# and z (outward) of the back's plane P. Each corner is a share of the back's half
# extents along x and y plus metres; along z metres alone.
# Trunk; shoulders; upper arms; forearms; seat; legs; head and neck: the farther out to
# the sides, the farther to the front.
_SHARES = np.array(
    [
        [[-1.0, -1.0], [1.0, 1.0]],
        [[-1.4, -1.0], [1.4, 1.0]],
        [[-1.65, -1.0], [1.65, 1.0]],
        [[-1.9, -1.0], [1.9, 1.0]],
        [[-2.2, -1.0], [2.2, -1.0]],
        [[-2.8, -1.0], [2.8, -1.0]],
        [[0.0, 1.0], [0.0, 1.0]],
    ]
)
_METRES = np.array(
    [
        [[0.0, -0.01, -0.85], [0.0, 0.03, 0.055]],
        [[0.0, -0.01, -0.85], [0.0, 0.03, 0.02]],
        [[0.0, -0.01, -0.85], [0.0, 0.03, -0.05]],
        [[0.0, -0.01, -0.85], [0.0, 0.03, -0.17]],
        [[0.0, -0.55, -0.9], [0.0, 0.0, 0.05]],
        [[0.0, -0.55, -0.9], [0.0, 0.0, -0.2]],
        [[-0.12, 0.0, -0.33], [0.12, 0.30, -0.01]],
    ]
)


# Links that keep off a person: all but the nozzle, which is meant to be near.
_ALL_LINKS = (0, NOZZLE - 1)


@dataclass(frozen=True, eq=False)
class Boxes(Shared):
    """Boxes, n of them.

    Attributes:
        axes: (n, 3, 3) each one's axes in W or wherever they are told, in columns.
        centres: (n, 3) m.
        halves: (n, 3) half its sides, m.
        minded: (n, 2) the first and the last link that keeps off it.
    """

    axes: FloatArray = field(default_factory=lambda: np.zeros((0, 3, 3)))
    centres: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    halves: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    minded: IntArray = field(default_factory=lambda: np.zeros((0, 2), np.int64))

    def __post_init__(self) -> None:
        """Raises ValueError on a wrong shape or what is not finite."""
        n = len(self.centres)
        for name, shape in (
            ("axes", (n, 3, 3)),
            ("centres", (n, 3)),
            ("halves", (n, 3)),
            ("minded", (n, 2)),
        ):
            kind = np.int64 if name == "minded" else np.float64
            value = np.ascontiguousarray(getattr(self, name), dtype=kind)
            if value.shape != shape or not np.isfinite(value).all():
                raise ValueError(f"{name} must be finite and {shape}, got {value}")
            object.__setattr__(self, name, value)

    def __add__(self, other: "Boxes") -> "Boxes":
        """Both."""
        mine, others = vars(self), vars(other)
        return Boxes(**{k: np.concatenate([mine[k], others[k]]) for k in mine})

    def seen_from(self, X: FloatArray) -> "Boxes":
        """Returns them as told in a frame whose pose (4, 4) here is X."""
        R, p = X[:3, :3], X[:3, 3]
        return replace(self, axes=R.T @ self.axes, centres=(self.centres - p) @ R)


def upright_box(
    low: ArrayLike, high: ArrayLike, links: tuple[int, int] = _ALL_LINKS
) -> Boxes:
    """Returns the box between two corners (3,), m, along the axes it is told in."""
    low, high = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    return Boxes(
        axes=np.eye(3)[None],
        centres=0.5 * (low + high)[None],
        halves=0.5 * (high - low)[None],
        minded=np.array([links]),
    )


def person_boxes(R_WP: FloatArray, p_WP: FloatArray, half: FloatArray) -> Boxes:
    """Returns the boxes of a person in W, from the back's box.

    Args:
        R_WP: (3, 3) axes of the back's plane: right, head, outward.
        p_WP: (3,) the middle of its box, m.
        half: (2,) half its extents along the first two, m.
    """
    corners = _METRES.copy()
    corners[..., :2] += _SHARES * half
    low, high = corners[:, 0], corners[:, 1]
    return Boxes(
        axes=np.broadcast_to(R_WP, (len(corners), 3, 3)),
        centres=p_WP + 0.5 * (low + high) @ np.asarray(R_WP).T,
        halves=0.5 * (high - low),
        minded=np.broadcast_to(_ALL_LINKS, (len(corners), 2)),
    )
