"""Reproduction of a motion: the flow followed from a start (paper, Eq. 2)."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.field import _rollout_batches, _rollouts
from bath_drake.field.navigation import NavigationField
from bath_drake.field.speed import canonical_velocity
from bath_drake.notation import BoolArray, FloatArray, IntArray
from bath_drake.threads import parallel_map, parts

_NO_GATE = np.zeros(5)


class RolloutStatus(Enum):
    """How a roll-out ended."""

    ARRIVED = _rollouts.ARRIVED
    """Within the tolerance of the goal."""
    TRAPPED = _rollouts.TRAPPED
    """No step lowers phi any more: a critical point other than the goal."""
    LEFT = _rollouts.LEFT
    """The start is not in free space (guarded steps never leave it)."""
    OUT_OF_STEPS = _rollouts.OUT_OF_STEPS
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
class Rollouts:
    """Many paths, padded to one length; the leading shape (...) is `rollouts`'s.

    Attributes:
        paths: Points, shape (..., T, 2); behind its end a path stays there.
        counts: Points of each path up to its end, shape (...), at least 1.
        statuses: How each ended, the values of `RolloutStatus`, shape (...).
        min_betas: The smallest beta_i met at each path's points, shape (...).
        lengths: Arc lengths, in units of N, shape (...).
    """

    paths: FloatArray
    counts: IntArray
    statuses: IntArray
    min_betas: FloatArray
    lengths: FloatArray

    @property
    def arrived(self) -> BoolArray:
        """Which ended at the goal, shape (...)."""
        return np.asarray(self.statuses == RolloutStatus.ARRIVED.value)

    def __getitem__(self, index: int | tuple[int, ...]) -> Rollout:
        """One of them, as `rollout` returns it."""
        return Rollout(
            self.paths[index][: self.counts[index]].copy(),
            RolloutStatus(int(self.statuses[index])),
            float(self.min_betas[index]),
            float(self.lengths[index]),
        )


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


def check_rollout(step: float, max_steps: int, goal_tolerance: float) -> None:
    """Raises ValueError unless these are a roll-out's settings."""
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
    have unit speed and are halved until phi falls and every beta_i stays positive,
    all the way from point to point.

    Args:
        start: Shape (2,), in N.
        field: The field.
        step: Arc length of a step, units of N.
        max_steps: How many steps at most.
        goal_tolerance: Distance to the goal that counts as arrived.

    Raises:
        ValueError: An argument is out of its range.
    """
    check_rollout(step, max_steps, goal_tolerance)
    x, y = np.asarray(start, dtype=np.float64).tolist()
    path = np.empty((max_steps + 1, 2))
    workspace, gx, gy, kappa, forms = field.kernel_arguments
    count, status, clear, length = _rollouts.roll_out(
        x, y, workspace, gx, gy, kappa, forms, step, goal_tolerance, _NO_GATE, path
    )
    return Rollout(path[:count].copy(), RolloutStatus(status), clear, length)


def rollouts(
    starts: ArrayLike,
    fields: NavigationField | Sequence[NavigationField],
    *,
    step: float = 0.01,
    max_steps: int = 5000,
    goal_tolerance: float = 1e-3,
) -> Rollouts:
    """`rollout` from every start under every field, on all cores.

    Args:
        starts: Shape (..., 2), in N.
        fields: One field, and the results have the shape of the starts, (...); or F
            of them, and theirs is (F, ...).
        step: As in `rollout`.
        max_steps: As in `rollout`.
        goal_tolerance: As in `rollout`.

    Raises:
        ValueError: An argument is out of its range, or there is no field.
    """
    many = _roll(starts, fields, step, max_steps, goal_tolerance, keep=True)
    counts = many.codes[:, 0]
    paths = np.empty((len(counts), int(counts.max(initial=1)), 2))
    row = 0
    for points, part in many.pieces:
        _rollout_batches.unpack(points, part, paths[row : row + len(part)])
        row += len(part)
    shape = many.shape
    return Rollouts(
        paths.reshape(*shape, *paths.shape[1:]),
        counts.reshape(shape),
        many.codes[:, 1].reshape(shape),
        many.facts[:, 2].reshape(shape),
        many.facts[:, 3].reshape(shape),
    )


def rollout_ends(
    starts: ArrayLike,
    field: NavigationField,
    *,
    step: float = 0.02,
    max_steps: int = 5000,
    goal_tolerance: float = 1e-3,
) -> tuple[tuple[RolloutStatus, ...], FloatArray]:
    """Where roll-outs from many starts (n, 2) end: statuses and end points (n, 2)."""
    many = _roll(starts, field, step, max_steps, goal_tolerance, keep=False)
    return tuple(map(RolloutStatus, many.codes[:, 1].tolist())), many.facts[:, :2]


@dataclass(frozen=True, eq=False)
class _Batch:
    """What the kernel says of a batch, in the order of fields, then starts."""

    shape: tuple[int, ...]
    codes: IntArray
    facts: FloatArray
    pieces: list[tuple[FloatArray, IntArray]]


def _roll(
    starts: ArrayLike,
    fields: NavigationField | Sequence[NavigationField],
    step: float,
    max_steps: int,
    goal_tolerance: float,
    *,
    keep: bool,
) -> _Batch:
    check_rollout(step, max_steps, goal_tolerance)
    q = np.asarray(starts, dtype=np.float64)
    if q.ndim == 0 or q.shape[-1] != 2:
        raise ValueError(f"starts must have shape (..., 2), got {q.shape}")
    shape = q.shape[:-1]
    if isinstance(fields, NavigationField):
        fields = [fields]
    else:
        shape = (len(fields), *shape)
    if not fields:
        raise ValueError("fields must not be empty")
    flat = q.reshape(-1, 2)
    points = np.tile(flat, (len(fields), 1))
    which = np.repeat(np.arange(len(fields)), len(flat))
    arguments = [f.kernel_arguments for f in fields]
    constants = np.array([[*w, gx, gy, k] for w, gx, gy, k, _ in arguments])
    forms = np.concatenate([a[4] for a in arguments])
    offsets = np.cumsum([0, *(len(a[4]) for a in arguments)])

    def roll(part: slice) -> tuple[IntArray, FloatArray, FloatArray]:
        return _rollout_batches.roll_outs(
            points[part],
            which[part],
            constants,
            forms,
            offsets,
            step,
            goal_tolerance,
            max_steps,
            keep,
        )

    found = parallel_map(roll, parts(len(points)))
    codes, facts, paths = zip(*found, strict=True)
    pieces = list(zip(paths, codes, strict=True))
    return _Batch(shape, np.concatenate(codes), np.concatenate(facts), pieces)


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
    exact for the slow-down on a straight way into the goal. For many paths at once
    see `rollouts` and `path_times`.

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
    times = path_times(
        found.path,
        field,
        speed=speed,
        half_extents=half_extents,
        slow_radius=slow_radius,
        goal_tolerance=goal_tolerance,
    )
    return TimedRollout(times, found.path, found.status)


def path_times(
    paths: ArrayLike,
    field: NavigationField,
    *,
    speed: float,
    half_extents: ArrayLike = (1.0, 1.0),
    slow_radius: float = 0.1,
    goal_tolerance: float = 1e-3,
) -> FloatArray:
    """When `canonical_velocity` passes the points of paths (..., T, 2): (..., T).

    In seconds since the first point; where a padded path stays, so does its time.

    Raises:
        ValueError: An argument is out of its range (the speed must be positive).
    """
    if not speed > 0.0:
        raise ValueError(f"speed must be positive, got {speed}")
    q = np.asarray(paths, dtype=np.float64)
    velocity = canonical_velocity(
        q, field, speed=speed, half_extents=half_extents, slow_radius=slow_radius
    )
    v = np.linalg.norm(velocity, axis=-1)
    # The last point may lie on the goal itself, where the speed is zero; arrival
    # is counted where the tolerance is crossed.
    widest = float(np.max(np.asarray(half_extents, dtype=np.float64)))
    least = speed / widest * min(goal_tolerance / slow_radius, 1.0)
    v = np.maximum(v, least)
    length = np.linalg.norm(np.diff(q, axis=-2), axis=-1)
    times = np.zeros(v.shape)
    np.cumsum(length / _logarithmic_mean(v), axis=-1, out=times[..., 1:])
    return times


def _logarithmic_mean(v: FloatArray) -> FloatArray:
    """(v1 - v0) / ln(v1 / v0) of neighbours: length over it is the exact time."""
    a, b = v[..., :-1], v[..., 1:]
    ratio = b / a
    close = np.abs(ratio - 1.0) < 1e-6  # there the mean is exact to 1e-13
    safe = np.where(close, 2.0, ratio)
    return np.where(close, 0.5 * (a + b), a * (safe - 1.0) / np.log(safe))
