"""Reproduction of a motion: the flow followed from a start (paper, Eq. 2)."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.field import _kernels
from bath_drake.field.navigation import NavigationField
from bath_drake.field.speed import canonical_velocity
from bath_drake.notation import FloatArray


class RolloutStatus(Enum):
    """How a roll-out ended."""

    ARRIVED = _kernels.ARRIVED
    """Within the tolerance of the goal."""
    TRAPPED = _kernels.TRAPPED
    """No step lowers phi any more: a critical point other than the goal."""
    LEFT = _kernels.LEFT
    """The start is not in free space (guarded steps never leave it)."""
    OUT_OF_STEPS = _kernels.OUT_OF_STEPS
    """Neither, after the steps allowed."""


@dataclass(frozen=True, eq=False)
class Rollout:
    """A path through canonical space.

    Attributes:
        path: Points, shape (T, 2), the start first.
        status: How it ended.
        min_beta: The smallest beta_i met at the path's points.
        length: Arc length, in units of N.
    """

    path: FloatArray
    status: RolloutStatus
    min_beta: float
    length: float


@dataclass(frozen=True, eq=False)
class TimedRollout:
    """A path with times.

    Attributes:
        times: Seconds since the start, shape (T,), strictly increasing.
        path: Points, shape (T, 2).
        status: How it ended.
    """

    times: FloatArray
    path: FloatArray
    status: RolloutStatus


def _check(step: float, max_steps: int, goal_tolerance: float) -> None:
    if not step > 0.0:
        raise ValueError(f"step must be positive, got {step}")
    if max_steps < 1:
        raise ValueError(f"max_steps must be at least 1, got {max_steps}")
    if not goal_tolerance > 0.0:
        raise ValueError(f"goal_tolerance must be positive, got {goal_tolerance}")


def rollout(
    start: ArrayLike,
    field: NavigationField,
    *,
    step: float = 0.01,
    max_steps: int = 5000,
    goal_tolerance: float = 1e-3,
) -> Rollout:
    """Follows the flow in guarded steps of equal arc length.

    Fixed steps along -grad phi cut into obstacles or crawl; these midpoint steps
    have unit speed and are halved until phi falls and every beta_i stays positive.

    Args:
        start: Shape (2,), in N.
        field: The field.
        step: Arc length of a step, units of N.
        max_steps: How many steps at most.
        goal_tolerance: Distance to the goal that counts as arrived.

    Raises:
        ValueError: An argument is out of its range.
    """
    _check(step, max_steps, goal_tolerance)
    x, y = np.asarray(start, dtype=np.float64).tolist()
    path = np.empty((max_steps + 1, 2))
    workspace, gx, gy, kappa, forms = field.kernel_arguments
    count, status, clear = _kernels.roll_out(
        x, y, workspace, gx, gy, kappa, forms, step, goal_tolerance, path
    )
    path = path[:count].copy()
    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    return Rollout(path, RolloutStatus(status), float(clear), length)


def rollout_ends(
    starts: ArrayLike,
    field: NavigationField,
    *,
    step: float = 0.02,
    max_steps: int = 5000,
    goal_tolerance: float = 1e-3,
) -> tuple[tuple[RolloutStatus, ...], FloatArray]:
    """Where roll-outs from many starts (n, 2) end: statuses and end points (n, 2)."""
    _check(step, max_steps, goal_tolerance)
    points = np.array(starts, dtype=np.float64).reshape(-1, 2)
    workspace, _, _, kappa, forms = field.kernel_arguments
    status, ends = _kernels.roll_outs(
        points,
        workspace,
        field.goal.copy(),
        kappa,
        forms,
        step,
        goal_tolerance,
        max_steps,
    )
    return tuple(RolloutStatus(int(s)) for s in status), ends


def timed_rollout(
    start: ArrayLike,
    field: NavigationField,
    *,
    speed: float,
    half_extents: ArrayLike = (1.0, 1.0),
    slow_radius: float = 0.1,
    step: float = 0.01,
    max_steps: int = 5000,
    goal_tolerance: float = 1e-3,
) -> TimedRollout:
    """The same path with the times at which `canonical_velocity` passes it.

    Between two points the speed is taken to be linear in arc length, which is
    exact for the slow-down on a straight way into the goal.

    Raises:
        ValueError: An argument is out of its range (the speed must be positive).
    """
    if not speed > 0.0:
        raise ValueError(f"speed must be positive, got {speed}")
    found = rollout(
        start,
        field,
        step=step,
        max_steps=max_steps,
        goal_tolerance=goal_tolerance,
    )
    velocity = canonical_velocity(
        found.path,
        field,
        speed=speed,
        half_extents=half_extents,
        slow_radius=slow_radius,
    )
    v = np.linalg.norm(velocity, axis=-1)
    # The last point may lie on the goal itself, where the speed is zero; arrival
    # is counted where the tolerance is crossed.
    widest = float(np.max(np.asarray(half_extents, dtype=np.float64)))
    least = speed / widest * min(goal_tolerance / slow_radius, 1.0)
    v = np.maximum(v, least)
    length = np.linalg.norm(np.diff(found.path, axis=0), axis=1)
    times = np.concatenate([[0.0], np.cumsum(length / _logarithmic_mean(v))])
    return TimedRollout(times, found.path, found.status)


def _logarithmic_mean(v: FloatArray) -> FloatArray:
    """(v1 - v0) / ln(v1 / v0) of neighbours: length over it is the exact time."""
    a, b = v[:-1], v[1:]
    ratio = b / a
    close = np.abs(ratio - 1.0) < 1e-6  # there the mean is exact to 1e-13
    safe = np.where(close, 2.0, ratio)
    return np.where(close, 0.5 * (a + b), a * (safe - 1.0) / np.log(safe))
