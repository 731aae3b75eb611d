"""How fast the flow is followed: one law for every roll-out and for the robot."""

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.field.navigation import NavigationField, flow_direction
from bath_drake.notation import FloatArray

NEVER_SLOWS = float(np.finfo(np.float64).tiny)
"""As ``slow_radius``: full speed up to the goal, for fields that are left before it."""


def canonical_velocity(
    q: ArrayLike,
    field: NavigationField,
    *,
    speed: float,
    half_extents: ArrayLike = (1.0, 1.0),
    slow_radius: float = 0.1,
) -> FloatArray:
    """Velocity of the canonical point (paper, Eq. 2, with its speed normalised).

    The direction is the flow's, whose integral curves do not depend on the
    speed. ``half_extents`` maps N to the skin: with the body's in metres,
    |diag(half_extents) v| = ``speed`` in m/s wherever the body is wider or
    taller. Within ``slow_radius`` of the goal it falls in proportion to the distance.

    Args:
        q: Points in N, shape (..., 2).
        field: The field to follow.
        speed: Along the skin, m/s (per unit of N with unit half extents), >= 0.
        half_extents: Shape (2,), positive.
        slow_radius: In units of N, > 0.

    Returns:
        v_NQ in 1/s, shape (..., 2); zero at the goal and outside free space.

    Raises:
        ValueError: An argument is out of its range.
    """
    extents = np.asarray(half_extents, dtype=np.float64)
    if extents.shape != (2,) or not (extents > 0.0).all():
        raise ValueError(f"half_extents must be two positive numbers, got {extents}")
    if not (0.0 <= speed < np.inf):
        raise ValueError(f"speed must be finite and >= 0, got {speed}")
    if not slow_radius > 0.0:
        raise ValueError(f"slow_radius must be positive, got {slow_radius}")
    direction = flow_direction(q, field)
    along_skin = np.linalg.norm(direction * extents, axis=-1, keepdims=True)
    d = np.asarray(q, dtype=np.float64) - field.goal
    distance = np.hypot(d[..., :1], d[..., 1:])
    share = np.minimum(distance / slow_radius, 1.0)
    safe = np.where(along_skin > 0.0, along_skin, 1.0)
    return np.asarray(direction * (speed * share / safe))
