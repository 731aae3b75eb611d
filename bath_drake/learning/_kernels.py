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

from bath_drake.field._boundaries import quadratic_forms
from bath_drake.field._kernels import flow
from bath_drake.field._rollouts import ARRIVED, LEFT, roll_out
from bath_drake.learning._frechet import frechet
from bath_drake.notation import FloatArray, IntArray


@njit(cache=True, nogil=True)
def _forms(x: FloatArray) -> FloatArray:
    q = (x.shape[0] - 1) // 5
    theta = np.empty((q, 5))
    for i in range(q):
        theta[i, 0] = x[5 * i]
        theta[i, 1] = x[5 * i + 1]
        theta[i, 2] = math.exp(x[5 * i + 2])
        theta[i, 3] = math.exp(x[5 * i + 3])
        theta[i, 4] = x[5 * i + 4]
    return quadratic_forms(theta, np.ones(q))


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
        forms = _forms(xs[k])
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
def _ray_gap(x: float, y: float, forms: FloatArray, i: int) -> float:
    """Distance of a point from ellipse i along the ray from its centre; < 0 within."""
    dx = x - forms[i, 0]
    dy = y - forms[i, 1]
    r = forms[i, 2] * dx * dx + 2.0 * forms[i, 3] * dx * dy + forms[i, 4] * dy * dy
    d = math.sqrt(dx * dx + dy * dy)
    if r < 1e-12:
        return -1.0 / math.sqrt(max(forms[i, 2], forms[i, 4]))
    return d - d / math.sqrt(r)


@njit(cache=True, nogil=True)
def _reach(x: FloatArray, i: int, ux: float, uy: float) -> float:
    c = math.cos(x[5 * i + 4])
    s = math.sin(x[5 * i + 4])
    a = math.exp(x[5 * i + 2]) * (c * ux + s * uy)
    b = math.exp(x[5 * i + 3]) * (c * uy - s * ux)
    return math.sqrt(a * a + b * b)


@njit(cache=True, nogil=True)
def _pair_gap(x: FloatArray, i: int, j: int) -> float:
    """Width of the widest slit between two ellipses over 24 directions (from below)."""
    dx = x[5 * j] - x[5 * i]
    dy = x[5 * j + 1] - x[5 * i + 1]
    best = -1e9
    start = math.atan2(dy, dx)
    for k in range(-6, 7):
        # Beyond 90 degrees off the line of centres no slit can be.
        t = start + k * (math.pi / 14.0)
        ux = math.cos(t)
        uy = math.sin(t)
        gap = dx * ux + dy * uy - _reach(x, i, ux, uy) - _reach(x, j, ux, uy)
        best = max(best, gap)
    return best


@njit(cache=True, nogil=True)
def _hinges(
    x: FloatArray,
    points: FloatArray,
    workspace: FloatArray,
    goal: FloatArray,
    margins: FloatArray,
    out: FloatArray,
) -> None:
    """What one member lacks in validity, each entry >= 0; see `hinges`."""
    q = (x.shape[0] - 1) // 5
    forms = _forms(x)
    n = 0
    for i in range(q):
        for j in range(i):
            out[n] = max(0.0, margins[0] - _pair_gap(x, i, j))
            n += 1
    for i in range(q):
        u = x[5 * i] - workspace[0]
        v = x[5 * i + 1] - workspace[1]
        big = math.exp(max(x[5 * i + 2], x[5 * i + 3]))
        room = min(workspace[2], workspace[3]) - math.sqrt(u * u + v * v) - big
        out[n] = max(0.0, margins[1] - room)
        n += 1
        least = 1e9
        for k in range(points.shape[0]):
            least = min(least, _ray_gap(points[k, 0], points[k, 1], forms, i))
        out[n] = max(0.0, margins[2] - least)
        n += 1
        out[n] = max(0.0, margins[3] - _ray_gap(goal[0], goal[1], forms, i))
        n += 1
        # The evolute test of `curvature_margin`, with logarithms for scale.
        a = math.exp(x[5 * i + 2])
        b = math.exp(x[5 * i + 3])
        c = math.cos(x[5 * i + 4])
        s = math.sin(x[5 * i + 4])
        dx = goal[0] - x[5 * i]
        dy = goal[1] - x[5 * i + 1]
        reach = (a * abs(c * dx + s * dy)) ** (2.0 / 3.0)
        reach += (b * abs(c * dy - s * dx)) ** (2.0 / 3.0)
        evolute = abs(a * a - b * b) ** (2.0 / 3.0)
        lack = 0.0
        if evolute * (1.0 + margins[5]) > reach:
            lack = math.log(evolute * (1.0 + margins[5]) / max(reach, 1e-9))
        out[n] = 0.1 * lack
        n += 1
    lack = math.log(max(margins[4] * q, 1e-9)) - x[x.shape[0] - 1]
    out[n] = 0.1 * max(0.0, lack)


@njit(cache=True, nogil=True)
def hinges(
    xs: FloatArray,
    points: FloatArray,
    workspace: FloatArray,
    goal: FloatArray,
    margins: FloatArray,
) -> FloatArray:
    """Validity hinges (n, Q (Q - 1) / 2 + 4 Q + 1), zero where all is well.

    Pairs first, then per obstacle: rim, demonstration ``points`` (K, 2), goal,
    curvature; kappa last. ``margins`` (6,): gaps to pairs, rim, points and goal,
    kappa per obstacle, curvature.
    """
    q = (xs.shape[1] - 1) // 5
    out = np.empty((xs.shape[0], q * (q - 1) // 2 + 4 * q + 1))
    for k in range(xs.shape[0]):
        _hinges(xs[k], points, workspace, goal, margins, out[k])
    return out


@njit(cache=True, nogil=True)
def shoot(
    xs: FloatArray,
    starts: FloatArray,
    steps: FloatArray,
    counts: IntArray,
    longest: int,
    workspace: FloatArray,
    goal: FloatArray,
    floor: float,
) -> FloatArray:
    """Short roll-outs of equal arc steps, smooth in x: (n, W, longest + 1, 2).

    Window w starts at starts[w] and makes counts[w] midpoint steps of steps[w];
    a point that comes within a step of the goal goes there and stays.
    """
    n = xs.shape[0]
    paths = np.empty((n, starts.shape[0], longest + 1, 2))
    for k in range(n):
        forms = _forms(xs[k])
        kappa = math.exp(xs[k, xs.shape[1] - 1])
        gx = goal[0]
        gy = goal[1]
        for w in range(starts.shape[0]):
            x = starts[w, 0]
            y = starts[w, 1]
            h = steps[w]
            paths[k, w, 0, 0] = x
            paths[k, w, 0, 1] = y
            for i in range(1, counts[w] + 1):
                if (x - gx) * (x - gx) + (y - gy) * (y - gy) < h * h:
                    x = gx
                    y = gy
                else:
                    fx, fy, _ = flow(x, y, workspace, gx, gy, kappa, forms, floor)
                    fx, fy, _ = flow(
                        x + 0.5 * h * fx,
                        y + 0.5 * h * fy,
                        workspace,
                        gx,
                        gy,
                        kappa,
                        forms,
                        floor,
                    )
                    x += h * fx
                    y += h * fy
                paths[k, w, i, 0] = x
                paths[k, w, i, 1] = y
    return paths
