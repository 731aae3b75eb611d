"""Compiled Euler roll-outs of the paper's Eq. 2, as plain as Sec. III-C writes them.

Nothing keeps a step out of an obstacle. Inside one, beta is negative and Eq. 1 still
says where phi falls: outwards, as long as gamma^kappa + beta is positive. Where two
obstacles overlap, the signs of their beta_i cancel and it points inwards again.
"""

import math

import numpy as np

from bath_drake.field._boundaries import (
    compiled,
    crosses,
    inlined,
    log_beta,
    quadratic_forms,
    unit,
)
from bath_drake.learning._frechet import frechet
from bath_drake.notation import FloatArray, IntArray


@inlined
def _inside(x: float, y: float, forms: FloatArray) -> int:
    """How many obstacles a point is inside of."""
    count = 0
    for i in range(forms.shape[0]):
        dx = x - forms[i, 0]
        dy = y - forms[i, 1]
        r = forms[i, 2] * dx * dx + 2.0 * forms[i, 3] * dx * dy + forms[i, 4] * dy * dy
        count += 1 if r < 1.0 else 0
    return count


@compiled
def _direction(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
) -> tuple[float, float, bool]:
    """Unit vector along -grad phi, whatever beta's sign, and whether beta_i > 0 all."""
    # No floor: every quotient keeps the sign of its beta_i.
    sx, sy, least, _ = log_beta(x, y, workspace, forms, -math.inf, False)
    dx = x - gx
    dy = y - gy
    gamma = dx * dx + dy * dy
    fx, fy = unit(gamma * sx - 2.0 * kappa * dx, gamma * sy - 2.0 * kappa * dy)
    if least > 0.0:
        return fx, fy, True
    # -grad phi is this times beta: odd numbers of negative beta_i turn it round.
    u = (x - workspace[0]) / workspace[2]
    v = (y - workspace[1]) / workspace[3]
    beyond = 1 if abs(u) ** workspace[4] + abs(v) ** workspace[4] > 1.0 else 0
    if (_inside(x, y, forms) + beyond) % 2 == 1:
        return -fx, -fy, False
    return fx, fy, False


@compiled
def euler_path(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
    dt: float,
    tolerance: float,
    path: FloatArray,
) -> tuple[int, bool, int]:
    """Rolls out into ``path`` (T, 2): points written, whether it arrives, entries.

    An entry is a step that takes the point out of free space, or over an obstacle.
    """
    path[0, 0] = x
    path[0, 1] = y
    entries = 0
    was_free = True
    px = x
    py = y
    for n in range(1, path.shape[0] + 1):
        fx, fy, free = _direction(x, y, workspace, gx, gy, kappa, forms)
        if was_free and (not free or crosses(px, py, x - px, y - py, forms)):
            entries += 1
        distance = math.sqrt((x - gx) * (x - gx) + (y - gy) * (y - gy))
        if distance <= tolerance:
            return n, True, entries
        if n == path.shape[0] or not fx * fx + fy * fy > 0.5:
            return n, False, entries
        h = min(dt, distance)
        px = x
        py = y
        was_free = free
        x += h * fx
        y += h * fy
        path[n, 0] = x
        path[n, 1] = y
    return path.shape[0], False, entries


@compiled
def euler_costs(
    xs: FloatArray,
    demonstrations: FloatArray,
    workspace: FloatArray,
    goal: FloatArray,
    kappa: float,
    dt: float,
    tolerance: float,
    max_steps: int,
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Members (n, 4 Q) rolled out from the starts of demonstrations (D, T, 2).

    Returns the discrete Fréchet distance to each (n, D), the share of them that
    arrive (n,), and the entries of all of them together (n,).
    """
    n = xs.shape[0]
    count = demonstrations.shape[0]
    obstacles = xs.shape[1] // 4
    distances = np.empty((n, count))
    arrived = np.zeros(n)
    entries = np.zeros(n, dtype=np.int64)
    path = np.empty((max_steps + 1, 2))
    theta = np.zeros((obstacles, 5))
    for k in range(n):
        for i in range(obstacles):
            for j in range(4):
                theta[i, j] = xs[k, 4 * i + j]
        forms = quadratic_forms(theta, np.ones(obstacles))
        for d in range(count):
            length, there, entered = euler_path(
                demonstrations[d, 0, 0],
                demonstrations[d, 0, 1],
                workspace,
                goal[0],
                goal[1],
                kappa,
                forms,
                dt,
                tolerance,
                path,
            )
            arrived[k] += 1.0 / count if there else 0.0
            entries[k] += entered
            distances[k, d] = frechet(path, length, demonstrations[d])
    return distances, arrived, entries
