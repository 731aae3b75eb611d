"""How near the arm's links come to the person, the stool and the pedestal.

Links are the capsules of `ArmChain`, all else boxes (`bath_drake.safety.obstacles`):
less than the truth is told, never more, as far as what is there is in the boxes.
"""

from math import isfinite, nan

import numpy as np

from bath_drake.notation import FloatArray
from bath_drake.safety._box_distance import ArmArrays, BoxArrays, gaps, least_gap
from bath_drake.safety.arm_chain import ArmChain
from bath_drake.safety.limits import JOINTS
from bath_drake.safety.obstacles import Boxes
from bath_drake.safety.self_distance import LOOKAHEAD

# Farther than this nobody needs to know how far, m.
FAR = 0.15
# Places on the way there that are looked at, the first and last included.
_LOOKS = 3


def link_gaps(
    q: FloatArray, arm: ArmChain, boxes: Boxes, near: float = FAR
) -> FloatArray:
    """Returns how near each capsule of the arm is to a box, and how that changes.

    Args:
        q: (7,) joint positions, rad.
        arm: Whose.
        boxes: In the arm's base frame B.
        near: Farther than this a bound from below is told, m, and no derivatives.

    Returns:
        (n, 8) distance, m, negative where they overlap and infinite where there is
        nothing; its derivatives by the joints' positions, m/rad.

    Raises:
        ValueError: If q is not of shape (7,).
    """
    q = np.ascontiguousarray(q, dtype=np.float64)
    if q.shape != (JOINTS,):
        raise ValueError(f"q must have shape ({JOINTS},), got {q.shape}")
    rows = np.empty((len(arm.capsules), 1 + JOINTS))
    gaps(q, arm_arrays(arm), box_arrays(boxes), near, rows)
    return rows


def obstacle_distance_ahead(
    q: FloatArray,
    v: FloatArray,
    arm: ArmChain,
    boxes: Boxes,
    lookahead: float = LOOKAHEAD,
) -> float:
    """Returns the least distance, m, on the way the arm takes while it brakes.

    Args:
        q: (7,) joint positions, rad.
        v: (7,) joint velocities, rad/s.
        arm: Whose.
        boxes: In the arm's base frame B; they stand still meanwhile.
        lookahead: For how long the arm goes on at its speed, s.

    Returns:
        At most `FAR`; NaN where a position or velocity is no finite number.

    Raises:
        ValueError: If q or v is not of shape (7,), or lookahead is negative or not
            finite.
    """
    if not (isfinite(lookahead) and lookahead >= 0.0):
        raise ValueError(f"lookahead must be >= 0 and finite, got {lookahead}")
    for name, value in (("q", q), ("v", v)):
        if np.shape(value) != (JOINTS,):
            raise ValueError(
                f"{name} must have shape ({JOINTS},), got {np.shape(value)}"
            )
    way = lookahead * np.asarray(v, dtype=np.float64)
    # A great number and a sum that is none are no positions either.
    if not np.isfinite(q + way).all():
        return nan
    return float(
        least_gap(
            np.ascontiguousarray(q, dtype=np.float64),
            way,
            _LOOKS if way.any() else 1,
            arm_arrays(arm),
            box_arrays(boxes),
            FAR,
        )
    )


def arm_arrays(arm: ArmChain) -> ArmArrays:
    """Returns what the compiled distances take of an arm."""
    return arm.origins, arm.turns, arm.capsules


def box_arrays(boxes: Boxes) -> BoxArrays:
    """Returns what the compiled distances take of boxes."""
    return boxes.axes, boxes.centres, boxes.halves, boxes.minded
