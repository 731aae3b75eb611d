"""The vector a learner moves: obstacles and kappa without constraints.

x = (cx, cy, ln a, ln b, angle) for each of Q ellipses, then ln kappa. Logarithms
keep axes and kappa positive and make a step mean the same at every size.
"""

import numpy as np

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.learning import _kernels
from bath_drake.notation import FloatArray

GENES = 5

_CENTRE = 0.85  # of the workspace's semi-axes
_AXES = (np.log(0.03), np.log(0.9))
_RATIO = np.log(4.0)
_KAPPA = (0.0, np.log(200.0))


def obstacle_count(x: FloatArray) -> int:
    """Q of a vector (..., 5 Q + 1)."""
    return int(x.shape[-1] - 1) // GENES


def scales(count: int) -> FloatArray:
    """What counts as one large step in each entry, shape (5 Q + 1,)."""
    return np.append(np.tile([0.3, 0.3, 0.7, 0.7, 1.0], count), 0.7)


def clip(xs: FloatArray, workspace: Workspace) -> FloatArray:
    """Vectors (..., 5 Q + 1) moved into their bounds; angles are left alone."""
    xs = np.array(xs, dtype=np.float64)
    within = limits(workspace)
    for x in xs.reshape(-1, xs.shape[-1]):
        _kernels.clip_member(x, within)
    return xs


def limits(workspace: Workspace) -> FloatArray:
    """The bounds as `_kernels.clip_member` takes them, shape (9,)."""
    span = _CENTRE * workspace.semi_axes
    low, high = workspace.centre - span, workspace.centre + span
    return np.array(
        [low[0], high[0], low[1], high[1], *_AXES, _RATIO, *_KAPPA], dtype=np.float64
    )


def encode(field: NavigationField) -> FloatArray:
    """The vector of a field; exponents other than one have no place in it.

    Raises:
        ValueError: An exponent is not one.
    """
    if (field.obstacles.powers != 1.0).any():
        raise ValueError("only obstacles of exponent 1 can be encoded")
    rows = field.obstacles.theta.copy()
    rows[:, 2:4] = np.log(rows[:, 2:4])
    return np.append(rows.ravel(), np.log(field.kappa))


def decode(x: FloatArray, workspace: Workspace, goal: FloatArray) -> NavigationField:
    """The field of a vector; a is made the longer axis and the angle put in +-pi/2."""
    rows = x[:-1].reshape(-1, GENES).copy()
    swap = rows[:, 2] < rows[:, 3]
    rows[swap, 2:4] = rows[swap, 3:1:-1]
    rows[swap, 4] += 0.5 * np.pi
    rows[:, 4] -= np.pi * np.round(rows[:, 4] / np.pi)
    rows[:, 2:4] = np.exp(rows[:, 2:4])
    kappa = float(np.exp(x[-1]))
    return NavigationField(workspace, goal, kappa, ObstacleSet(rows))
