"""Exact sensitivities of short roll-outs, compiled.

The flow is a unit vector, so its derivative is one angle's: forward sensitivities of
a roll-out cost one scalar row per parameter, hardly more than the roll-out itself,
where differences would cost a roll-out for each.
"""

import math

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray, IntArray


@njit(cache=True, nogil=True)
def _angle(
    x: float,
    y: float,
    member: FloatArray,
    shapes: FloatArray,
    workspace: FloatArray,
    goal: FloatArray,
    floor: float,
    rates: FloatArray,
) -> tuple[float, float]:
    """The flow's direction, and in ``rates`` the derivatives of its angle.

    ``rates`` (2 + P,) holds those to x and y, then to the member's entries.
    ``shapes`` (Q, 4) holds the cosine and sine of the angle, 1/a^2 and 1/b^2.
    Where a beta is held at the floor, its own change no longer counts.
    """
    q = shapes.shape[0]
    kappa = math.exp(member[5 * q])
    dx = x - goal[0]
    dy = y - goal[1]
    gamma = dx * dx + dy * dy
    rx = (x - workspace[0]) / workspace[2]
    ry = (y - workspace[1]) / workspace[3]
    p = workspace[4]
    px = abs(rx) ** (p - 2.0)
    py = abs(ry) ** (p - 2.0)
    b = 1.0 - px * rx * rx - py * ry * ry
    z = 1.0 if b > floor else 0.0
    b = max(b, floor)
    bx = -p * px * rx / workspace[2]
    by = -p * py * ry / workspace[3]
    sx = bx / b
    sy = by / b
    hxx = -p * (p - 1.0) * px / (workspace[2] * workspace[2]) / b - z * sx * sx
    hyy = -p * (p - 1.0) * py / (workspace[3] * workspace[3]) / b - z * sy * sy
    hxy = -z * sx * sy
    for i in range(q):
        ex = x - member[5 * i]
        ey = y - member[5 * i + 1]
        c = shapes[i, 0]
        s = shapes[i, 1]
        u = c * ex + s * ey
        v = c * ey - s * ex
        ia = shapes[i, 2]
        ib = shapes[i, 3]
        b = u * u * ia + v * v * ib - 1.0
        z = 1.0 if b > floor else 0.0
        b = max(b, floor)
        bx = 2.0 * (c * ia * u - s * ib * v) / b
        by = 2.0 * (s * ia * u + c * ib * v) / b
        sx += bx
        sy += by
        hxx += 2.0 * (c * c * ia + s * s * ib) / b - z * bx * bx
        hxy += 2.0 * c * s * (ia - ib) / b - z * bx * by
        hyy += 2.0 * (s * s * ia + c * c * ib) / b - z * by * by
    vx = gamma * sx - 2.0 * kappa * dx
    vy = gamma * sy - 2.0 * kappa * dy
    n = math.sqrt(vx * vx + vy * vy) + 1e-300
    fx = vx / n
    fy = vy / n
    # The normal over |v|: it turns a change of v into one of the angle.
    nx = -fy / n
    ny = fx / n
    rates[0] = nx * (2.0 * (dx * sx - kappa) + gamma * hxx)
    rates[0] += ny * (2.0 * dx * sy + gamma * hxy)
    rates[1] = nx * (2.0 * dy * sx + gamma * hxy)
    rates[1] += ny * (2.0 * (dy * sy - kappa) + gamma * hyy)
    nx *= gamma
    ny *= gamma
    for i in range(q):
        ex = x - member[5 * i]
        ey = y - member[5 * i + 1]
        c = shapes[i, 0]
        s = shapes[i, 1]
        u = c * ex + s * ey
        v = c * ey - s * ex
        ia = shapes[i, 2]
        ib = shapes[i, 3]
        b = u * u * ia + v * v * ib - 1.0
        z = 1.0 if b > floor else 0.0
        r = 1.0 / max(b, floor)
        nu = c * nx + s * ny
        nv = c * ny - s * nx
        # In the ellipse's own axes: gradient (gu, gv), and the normal's share of it.
        gu = 2.0 * ia * u
        gv = 2.0 * ib * v
        held = z * r * r * (nu * gu + nv * gv)
        du = -2.0 * r * ia * nu + held * gu
        dv = -2.0 * r * ib * nv + held * gv
        rates[2 + 5 * i] = c * du - s * dv
        rates[3 + 5 * i] = s * du + c * dv
        rates[4 + 5 * i] = -2.0 * r * gu * nu + held * gu * u
        rates[5 + 5 * i] = -2.0 * r * gv * nv + held * gv * v
        twist = 2.0 * (ia - ib)
        rates[6 + 5 * i] = twist * (r * (v * nu + u * nv) - held * u * v)
    rates[2 + 5 * q] = -2.0 * kappa * (-fy * dx + fx * dy) / n
    return fx, fy


@njit(cache=True, nogil=True)
def normal_equations(
    member: FloatArray,
    starts: FloatArray,
    steps: FloatArray,
    counts: IntArray,
    workspace: FloatArray,
    goal: FloatArray,
    floor: float,
    weight: FloatArray,
    pull: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """J^T W J (P, P) and J^T W r (P,) of the roll-outs of `_kernels.shoot`.

    ``weight`` (W, T) and ``pull`` (W, T, 2) are the coupling's at this member.
    """
    size = member.shape[0]
    q = size // 5
    shapes = np.empty((q, 4))
    for i in range(q):
        shapes[i, 0] = math.cos(member[5 * i + 4])
        shapes[i, 1] = math.sin(member[5 * i + 4])
        shapes[i, 2] = math.exp(-2.0 * member[5 * i + 2])
        shapes[i, 3] = math.exp(-2.0 * member[5 * i + 3])
    matrix = np.zeros((size, size))
    gradient = np.zeros(size)
    first = np.empty(size + 2)
    second = np.empty(size + 2)
    row = np.empty((2, size))
    for w in range(starts.shape[0]):
        x = starts[w, 0]
        y = starts[w, 1]
        h = steps[w]
        row[:] = 0.0
        for k in range(1, counts[w] + 1):
            dx = x - goal[0]
            dy = y - goal[1]
            if dx * dx + dy * dy < h * h:
                break  # it goes to the goal and stays: nothing changes any more
            fx, fy = _angle(x, y, member, shapes, workspace, goal, floor, first)
            mx = x + 0.5 * h * fx
            my = y + 0.5 * h * fy
            gx, gy = _angle(mx, my, member, shapes, workspace, goal, floor, second)
            f = weight[w, k]
            for p in range(size):
                turn = first[0] * row[0, p] + first[1] * row[1, p] + first[2 + p]
                across = row[0, p] - 0.5 * h * fy * turn
                along = row[1, p] + 0.5 * h * fx * turn
                turn = second[0] * across + second[1] * along + second[2 + p]
                row[0, p] -= h * gy * turn
                row[1, p] += h * gx * turn
            x += h * gx
            y += h * gy
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
    return matrix, gradient
