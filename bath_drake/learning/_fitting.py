"""Levenberg-Marquardt on short roll-outs, compiled as a whole.

One member's descent never returns to the interpreter: threads share a population
without waiting for each other, and every sum has one order, whatever their number.
"""

import math

import numpy as np

from bath_drake.field._boundaries import compiled
from bath_drake.learning._coupling import couple_windows
from bath_drake.learning._hinges import (
    HINGE,
    add_hinges,
    hinge_count,
    member_forms,
    member_hinges,
)
from bath_drake.learning._kernels import clip_member, shoot_member
from bath_drake.learning._sensitivities import Cut, World, add_normal_equations
from bath_drake.notation import FloatArray

Room = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""Paths, hinges, weights and pulls of the coupling, its table: overwritten."""

# Dampings tried in an iteration, and how they grow and shrink.
_TRIALS = 5
_MORE = 12.0
_LESS = 8.0


@compiled
def _solve(
    matrix: FloatArray, damping: FloatArray, right: FloatArray, out: FloatArray
) -> bool:
    """(matrix + diag(damping)) out = -right by Cholesky; False if not definite."""
    n = right.shape[0]
    low = np.empty((n, n))
    for i in range(n):
        for j in range(i + 1):
            total = matrix[i, j]
            if i == j:
                total += damping[i]
            for k in range(j):
                total -= low[i, k] * low[j, k]
            if i > j:
                low[i, j] = total / low[j, j]
            elif total > 0.0:
                low[i, i] = math.sqrt(total)
            else:
                return False
    for i in range(n):
        total = -right[i]
        for k in range(i):
            total -= low[i, k] * out[k]
        out[i] = total / low[i, i]
    for i in range(n - 1, -1, -1):
        total = out[i]
        for k in range(i + 1, n):
            total -= low[k, i] * out[k]
        out[i] = total / low[i, i]
    return True


@compiled
def _room(size: int, windows: Cut) -> Room:
    """Memory for a member of ``size`` entries."""
    starts, targets, _, _, counts, _ = windows
    longest = counts.max() + 1
    return (
        np.empty((starts.shape[0], longest, 2)),
        np.zeros((hinge_count((size - 1) // 5), HINGE)),
        np.zeros((starts.shape[0], longest)),
        np.zeros((starts.shape[0], longest, 2)),
        np.empty((longest, targets.shape[1])),
    )


@compiled
def _cost(
    x: FloatArray,
    windows: Cut,
    world: World,
    power: float,
    mu: float,
    room: Room,
) -> float:
    """Windows' cost and mu / 2 times the squared hinges; fills the room."""
    starts, targets, lengths, steps, counts, weights = windows
    workspace, goal, floor, points, margins = world
    paths, rows, weight, pull, table = room
    forms = member_forms(x)
    kappa = math.exp(x[x.shape[0] - 1])
    shoot_member(forms, kappa, starts, steps, counts, workspace, goal, floor, paths)
    total = couple_windows(
        paths, counts, targets, lengths, weights, power, weight, pull, table
    )
    member_hinges(x, forms, points, workspace, goal, margins, rows)
    for n in range(rows.shape[0]):
        total += 0.5 * mu * rows[n, 0] * rows[n, 0]
    return total


@compiled
def costs(
    xs: FloatArray,
    windows: Cut,
    world: World,
    power: float,
    mu: float,
) -> FloatArray:
    """`_cost` of members (n, P), shape (n,)."""
    room = _room(xs.shape[1], windows)
    out = np.empty(xs.shape[0])
    for k in range(xs.shape[0]):
        out[k] = _cost(
            xs[k],
            windows,
            world,
            power,
            mu,
            room,
        )
    return out


@compiled
def linearise(
    x: FloatArray,
    windows: Cut,
    world: World,
    power: float,
    mu: float,
) -> tuple[float, FloatArray, FloatArray]:
    """The cost at x (P,), J^T J and J^T r of the held coupling and the hinges."""
    room = _room(x.shape[0], windows)
    cost = _cost(
        x,
        windows,
        world,
        power,
        mu,
        room,
    )
    matrix = np.zeros((x.shape[0], x.shape[0]))
    gradient = np.zeros(x.shape[0])
    _, rows, weight, pull, _ = room
    add_normal_equations(x, windows, world, weight, pull, matrix, gradient)
    add_hinges(rows, mu, matrix, gradient)
    return cost, matrix, gradient


@compiled
def fit(
    x: FloatArray,
    windows: Cut,
    world: World,
    power: float,
    mu: float,
    scale: FloatArray,
    limits: FloatArray,
    iterations: int,
) -> tuple[FloatArray, float, int]:
    """Levenberg-Marquardt from x (P,): the new x, its cost, members rolled out."""
    size = x.shape[0]
    x = x.copy()
    clip_member(x, limits)
    trial = np.empty(size)
    damped = np.empty(size)
    room = _room(size, windows)
    damping = 1e-2
    slow = 0
    evaluations = 1
    cost, matrix, gradient = linearise(x, windows, world, power, mu)
    for _ in range(iterations):
        # As bold as the last step allows; then ever more careful.
        better = False
        for _ in range(_TRIALS):
            for p in range(size):
                least = 1.0 / (scale[p] * scale[p])
                damped[p] = damping * (matrix[p, p] + 1e-9 * least) + 1e-12 * least
            if _solve(matrix, damped, gradient, trial):
                large = 1.0
                for p in range(size):
                    large = max(large, abs(trial[p]) / scale[p])
                for p in range(size):
                    trial[p] = x[p] + trial[p] / large
                clip_member(trial, limits)
                tried = _cost(trial, windows, world, power, mu, room)
                evaluations += 1
                if tried < cost:
                    better = True
                    break
            damping *= _MORE
        if not better:
            break
        slow = slow + 1 if cost - tried < 1e-3 * cost else 0
        for p in range(size):
            x[p] = trial[p]
        cost = tried
        damping = max(damping / _LESS, 1e-7)
        if slow >= 3:
            break
        cost, matrix, gradient = linearise(x, windows, world, power, mu)
        evaluations += 1
    return x, cost, evaluations
