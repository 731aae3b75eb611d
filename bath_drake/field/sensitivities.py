"""How a path moves when its field does: exact derivatives of roll-outs.

The roll-out is the one of equal arc-length midpoint steps, without guards: those
depend on the field by jumps. What is differentiated is that path itself, step by
step, not the curve it approximates.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.field import _sensitivities
from bath_drake.field.navigation import NavigationField
from bath_drake.field.rollout import RolloutStatus, check_rollout
from bath_drake.notation import FloatArray


@dataclass(frozen=True, eq=False)
class PathSensitivities:
    """A path of T points and its derivatives, each point's two coordinates first.

    Attributes:
        path: Points, shape (T, 2), the start first; if it arrived, the goal last.
        status: 'ARRIVED'; 'LEFT' before a step (or its midpoint) out of free space;
            'TRAPPED' before a point without a direction; else 'OUT_OF_STEPS'.
        obstacles: To (centre x, centre y, a, b, angle, exponent), shape (T, 2, Q, 6).
        kappa: Shape (T, 2).
        goal: Shape (T, 2, 2), the goal's coordinates last.
        start: Shape (T, 2, 2), the start's coordinates last.
    """

    path: FloatArray
    status: RolloutStatus
    obstacles: FloatArray
    kappa: FloatArray
    goal: FloatArray
    start: FloatArray


def path_sensitivities(
    start: ArrayLike,
    field: NavigationField,
    *,
    step: float = 0.01,
    max_steps: int = 5000,
) -> PathSensitivities:
    """Rolls out in equal steps and carries the derivatives along (forward mode).

    Args:
        start: Shape (2,), in N.
        field: The field.
        step: Arc length of a step, units of N. A point closer to the goal than this
            is followed by the goal itself, and the path ends.
        max_steps: How many steps at most.

    Raises:
        ValueError: An argument is out of its range.
    """
    check_rollout(step, max_steps, step)
    x, y = np.asarray(start, dtype=np.float64).tolist()
    theta, powers = field.obstacles.theta, field.obstacles.powers
    count = len(theta)
    path = np.empty((max_steps + 1, 2))
    jacobian = np.empty((max_steps + 1, 2, 6 * count + 5))
    workspace, gx, gy, kappa, _ = field.kernel_arguments
    length, status = _sensitivities.sensitive_roll_out(
        x,
        y,
        workspace,
        gx,
        gy,
        kappa,
        _sensitivities.obstacle_rows(theta.copy(), powers.copy()),
        step,
        path,
        jacobian,
    )
    ellipses, ln_kappa, exponents, goal, begin = np.split(
        jacobian[:length], np.cumsum([5 * count, 1, count, 2]), axis=2
    )
    obstacles = np.empty((length, 2, count, 6))
    obstacles[..., :5] = ellipses.reshape(length, 2, count, 5)
    obstacles[..., 2:4] /= theta[:, 2:4]  # the kernel's are to ln a and ln b
    obstacles[..., 5] = exponents
    return PathSensitivities(
        path[:length].copy(),
        RolloutStatus(status),
        obstacles,
        ln_kappa[..., 0] / kappa,
        goal.copy(),
        begin.copy(),
    )
