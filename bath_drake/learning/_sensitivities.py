"""Normal equations of short roll-outs from their exact sensitivities, compiled."""

import math

import numpy as np

from bath_drake.field._boundaries import compiled
from bath_drake.field._sensitivities import obstacle_rows, sensitive_step
from bath_drake.notation import FloatArray, IntArray

Cut = tuple[FloatArray, FloatArray, IntArray, FloatArray, IntArray, FloatArray]
"""Windows: starts (W, 2), targets (W, T, 2), lengths, steps, counts, weights (W,)."""
World = tuple[FloatArray, FloatArray, float, FloatArray, FloatArray]
"""Workspace (5,), goal (2,), floor of beta, points to be left clear, margins."""


@compiled
def add_normal_equations(
    member: FloatArray,
    windows: Cut,
    world: World,
    weight: FloatArray,
    pull: FloatArray,
    matrix: FloatArray,
    gradient: FloatArray,
) -> None:
    """Adds J^T W J (P, P) and J^T W r (P,) of the roll-outs of `shoot_member`.

    ``weight`` (W, T) and ``pull`` (W, T, 2) are the coupling's at this member, whose
    entries are the first 5 Q + 1 of `bath_drake.field._sensitivities`' parameters.
    ``matrix`` is symmetric before and after.
    """
    starts, _, _, steps, counts, _ = windows
    workspace, goal, floor, _, _ = world
    size = member.shape[0]
    q = size // 5
    theta = np.empty((q, 5))
    for i in range(q):
        for k in range(5):
            theta[i, k] = member[5 * i + k]
        theta[i, 2] = math.exp(theta[i, 2])
        theta[i, 3] = math.exp(theta[i, 3])
    rows = obstacle_rows(theta, np.ones(q))
    kappa = math.exp(member[5 * q])
    gx = goal[0]
    gy = goal[1]
    rates = np.zeros((2, 2 + 6 * q + 3))
    row = np.empty((2, size))
    for w in range(starts.shape[0]):
        x = starts[w, 0]
        y = starts[w, 1]
        h = steps[w]
        row[:] = 0.0
        for k in range(1, counts[w] + 1):
            if (x - gx) * (x - gx) + (y - gy) * (y - gy) < h * h:
                break  # it goes to the goal and stays: nothing changes any more
            x, y, _ = sensitive_step(
                x, y, h, rows, kappa, workspace, gx, gy, floor, rates, row
            )
            f = weight[w, k]
            if f == 0.0:
                continue
            for p in range(size):
                a = f * row[0, p]
                b = f * row[1, p]
                gradient[p] += a * pull[w, k, 0] + b * pull[w, k, 1]
                for r in range(p + 1):
                    matrix[p, r] += a * row[0, r] + b * row[1, r]
    for p in range(size):
        for r in range(p):
            matrix[r, p] = matrix[p, r]
