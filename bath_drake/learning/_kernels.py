"""Compiled kernels of the learner, each over a whole population at once.

A member of a population is a vector x (5 Q + 1,): per obstacle centre x, centre y,
ln a, ln b and the angle, then ln kappa (see `bath_drake.learning.genome`).

All release the interpreter lock, so that threads share a population's members;
each is serial in itself: forking inside costs more than these batches do.

After a change of `bath_drake.field`'s kernels, numba's cache of this file is stale:
touch this file too.
"""

import math

import numpy as np
from numba import njit

from bath_drake.field._kernels import flow
from bath_drake.field._rollouts import ARRIVED, LEFT, roll_out
from bath_drake.learning._frechet import frechet
from bath_drake.learning._hinges import member_forms
from bath_drake.notation import FloatArray, IntArray


@njit(cache=True, nogil=True)
def whole_costs(
    xs: FloatArray,
    demonstrations: FloatArray,
    grid: FloatArray,
    workspace: FloatArray,
    goal: FloatArray,
    step: float,
    tolerance: float,
    max_steps: int,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Guarded roll-outs from the demonstrations' starts to the goal.

    Demonstrations are (D, T, 2). Returns the Fréchet distance to each (n, D), the
    share of them that arrive (n,), and the share of free grid points (G, 2) whose
    roll-out arrives (n,).
    """
    n = xs.shape[0]
    count = demonstrations.shape[0]
    distances = np.empty((n, count))
    arrived = np.zeros(n)
    reached = np.ones(n)
    nowhere = np.zeros(5)  # no gate
    for k in range(n):
        forms = member_forms(xs[k])
        kappa = math.exp(xs[k, xs.shape[1] - 1])
        path = np.empty((max_steps + 1, 2))
        for d in range(count):
            length, status, _, _ = roll_out(
                demonstrations[d, 0, 0],
                demonstrations[d, 0, 1],
                workspace,
                goal[0],
                goal[1],
                kappa,
                forms,
                step,
                tolerance,
                nowhere,
                path,
            )
            if status == ARRIVED:
                arrived[k] += 1.0 / count
            distances[k, d] = frechet(path, length, demonstrations[d])
        free = 0
        good = 0
        for g in range(grid.shape[0]):
            # Coarse steps will do: only the end matters.
            _, status, _, _ = roll_out(
                grid[g, 0],
                grid[g, 1],
                workspace,
                goal[0],
                goal[1],
                kappa,
                forms,
                3.0 * step,
                tolerance,
                nowhere,
                path,
            )
            if status != LEFT:
                free += 1
            if status == ARRIVED:
                good += 1
        if free > 0:
            reached[k] = good / free
    return distances, arrived, reached


@njit(cache=True, nogil=True)
def shoot_member(
    forms: FloatArray,
    kappa: float,
    starts: FloatArray,
    steps: FloatArray,
    counts: IntArray,
    workspace: FloatArray,
    goal: FloatArray,
    floor: float,
    paths: FloatArray,
) -> None:
    """Short roll-outs of equal arc steps, smooth in the field: paths (W, T, 2).

    Window w starts at starts[w] and makes counts[w] midpoint steps of steps[w];
    a point that comes within a step of the goal goes there and stays.
    """
    gx = goal[0]
    gy = goal[1]
    for w in range(starts.shape[0]):
        x = starts[w, 0]
        y = starts[w, 1]
        h = steps[w]
        paths[w, 0, 0] = x
        paths[w, 0, 1] = y
        for i in range(1, counts[w] + 1):
            if (x - gx) * (x - gx) + (y - gy) * (y - gy) < h * h:
                x = gx
                y = gy
            else:
                fx, fy, _ = flow(x, y, workspace, gx, gy, kappa, forms, floor)
                mx = x + 0.5 * h * fx
                my = y + 0.5 * h * fy
                fx, fy, _ = flow(mx, my, workspace, gx, gy, kappa, forms, floor)
                x += h * fx
                y += h * fy
            paths[w, i, 0] = x
            paths[w, i, 1] = y


@njit(cache=True, nogil=True)
def clip_member(x: FloatArray, limits: FloatArray) -> None:
    """Moves a member into its bounds; see `bath_drake.learning.genome.clip`."""
    q = (x.shape[0] - 1) // 5
    for i in range(q):
        for k in range(2):
            at = 5 * i + k
            x[at] = min(max(x[at], limits[2 * k]), limits[2 * k + 1])
        mean = 0.5 * (x[5 * i + 2] + x[5 * i + 3])
        half = 0.5 * (x[5 * i + 2] - x[5 * i + 3])
        half = min(max(half, -0.5 * limits[6]), 0.5 * limits[6])
        x[5 * i + 2] = min(max(mean + half, limits[4]), limits[5])
        x[5 * i + 3] = min(max(mean - half, limits[4]), limits[5])
    x[5 * q] = min(max(x[5 * q], limits[7]), limits[8])
