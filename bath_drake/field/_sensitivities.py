"""Compiled derivatives of a roll-out to everything its field is made of.

The flow is a unit vector, so its derivative is one angle's: forward sensitivities of
a roll-out cost one scalar row per parameter, hardly more than the roll-out itself,
where differences would cost a roll-out for each.

The parameters' order, here and in `bath_drake.learning`: centre x and y, ln a, ln b
and the angle of each obstacle; ln kappa; the exponent of each obstacle; the goal's x
and y; the start's x and y. A caller who needs the first few only asks for those.
"""

import math

import numpy as np

from bath_drake.field._boundaries import compiled, even_powers, inlined
from bath_drake.field._rollouts import ARRIVED, LEFT, OUT_OF_STEPS, TRAPPED
from bath_drake.notation import FloatArray

# Columns of an obstacle's row: centre, cosine and sine of its angle, 1/a^2, 1/b^2,
# exponent, and what `_angle` notes for its second pass.
ROW = 11


@compiled
def obstacle_rows(theta: FloatArray, exponents: FloatArray) -> FloatArray:
    """Rows (Q, ROW) for `sensitive_step` of ellipses (Q, 5) and exponents (Q,)."""
    rows = np.empty((theta.shape[0], ROW))
    for i in range(theta.shape[0]):
        rows[i, 0] = theta[i, 0]
        rows[i, 1] = theta[i, 1]
        rows[i, 2] = math.cos(theta[i, 4])
        rows[i, 3] = math.sin(theta[i, 4])
        rows[i, 4] = 1.0 / (theta[i, 2] * theta[i, 2])
        rows[i, 5] = 1.0 / (theta[i, 3] * theta[i, 3])
        rows[i, 6] = exponents[i]
    return rows


@inlined
def _angle(
    x: float,
    y: float,
    rows: FloatArray,
    kappa: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    floor: float,
    rates: FloatArray,
) -> tuple[float, float, float]:
    """The flow's direction and the least beta; in ``rates`` the angle's derivatives.

    ``rates`` (2 + 6 Q + 3,) holds those to x and y, then to the parameters but the
    start. Where a beta is held at the floor, its own change no longer counts.
    """
    count = rows.shape[0]
    u, bx, bxx = even_powers((x - workspace[0]) / workspace[2], workspace[4])
    v, by, byy = even_powers((y - workspace[1]) / workspace[3], workspace[4])
    least = 1.0 - u - v
    rim = 1.0 / max(least, floor)
    rim_held = 1.0 if least > floor else 0.0
    bx *= -rim / workspace[2]
    by *= -rim / workspace[3]
    bxx *= -rim / (workspace[2] * workspace[2])
    byy *= -rim / (workspace[3] * workspace[3])
    sx = bx
    sy = by
    for i in range(count):
        dx = x - rows[i, 0]
        dy = y - rows[i, 1]
        c = rows[i, 2]
        s = rows[i, 3]
        u = c * dx + s * dy
        v = c * dy - s * dx
        gu = rows[i, 4] * u
        gv = rows[i, 5] * v
        b = u * gu + v * gv - 1.0
        least = min(least, b)
        r = 2.0 / max(b, floor)
        rows[i, 7] = u
        rows[i, 8] = v
        rows[i, 9] = r
        rows[i, 10] = 1.0 if b > floor else 0.0
        r *= rows[i, 6]
        sx += r * (c * gu - s * gv)
        sy += r * (s * gu + c * gv)
    dx = x - gx
    dy = y - gy
    gamma = dx * dx + dy * dy
    vx = gamma * sx - 2.0 * kappa * dx
    vy = gamma * sy - 2.0 * kappa * dy
    n = max(math.sqrt(vx * vx + vy * vy), 1e-300)
    fx = vx / n
    fy = vy / n
    # The normal over |v|: it turns a change of v into one of the angle.
    nx = -fy / n
    ny = fx / n
    pull = 2.0 * (nx * sx + ny * sy)
    goal = 2 + 6 * count + 1
    rates[goal] = 2.0 * kappa * nx - pull * dx
    rates[goal + 1] = 2.0 * kappa * ny - pull * dy
    rates[2 + 5 * count] = -2.0 * kappa * (nx * dx + ny * dy)
    nx *= gamma
    ny *= gamma
    held = rim_held * (nx * bx + ny * by)
    # A shift of the point is one of all centres and of the goal, the other way.
    rates[0] = nx * bxx - held * bx - rates[goal]
    rates[1] = ny * byy - held * by - rates[goal + 1]
    for i in range(count):
        c = rows[i, 2]
        s = rows[i, 3]
        ia = rows[i, 4]
        ib = rows[i, 5]
        u = rows[i, 7]
        v = rows[i, 8]
        r = rows[i, 9]
        nu = c * nx + s * ny
        nv = c * ny - s * nx
        gu = ia * u
        gv = ib * v
        # In the ellipse's own axes: half its gradient (gu, gv), the normal's share.
        share = r * (nu * gu + nv * gv)
        rates[3 + 5 * count + i] = share
        r *= rows[i, 6]
        held = rows[i, 10] * r * share
        du = held * gu - r * ia * nu
        dv = held * gv - r * ib * nv
        cx = c * du - s * dv
        cy = s * du + c * dv
        k = 2 + 5 * i
        rates[k] = cx
        rates[k + 1] = cy
        rates[k + 2] = gu * (held * u - 2.0 * r * nu)
        rates[k + 3] = gv * (held * v - 2.0 * r * nv)
        rates[k + 4] = (ia - ib) * (r * (v * nu + u * nv) - held * u * v)
        rates[0] -= cx
        rates[1] -= cy
    return fx, fy, least


@inlined
def sensitive_step(
    x: float,
    y: float,
    h: float,
    rows: FloatArray,
    kappa: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    floor: float,
    rates: FloatArray,
    path: FloatArray,
) -> tuple[float, float, float]:
    """One midpoint step of arc length h; returns the new point and the least beta met.

    ``path`` (2, P) holds the derivatives of (x, y) to the first P parameters and is
    carried on; ``rates`` (2, max(2 + 6 Q + 3, 2 + P)) is room to work in, zeros
    behind its first 2 + 6 Q + 3 columns.
    """
    first = rates[0]
    second = rates[1]
    fx, fy, a = _angle(x, y, rows, kappa, workspace, gx, gy, floor, first)
    mx = x + 0.5 * h * fx
    my = y + 0.5 * h * fy
    ex, ey, b = _angle(mx, my, rows, kappa, workspace, gx, gy, floor, second)
    for p in range(path.shape[1]):
        turn = first[0] * path[0, p] + first[1] * path[1, p] + first[2 + p]
        across = path[0, p] - 0.5 * h * fy * turn
        along = path[1, p] + 0.5 * h * fx * turn
        turn = second[0] * across + second[1] * along + second[2 + p]
        path[0, p] -= h * ey * turn
        path[1, p] += h * ex * turn
    return x + h * ex, y + h * ey, min(a, b)


@inlined
def _note(
    x: float, y: float, carried: FloatArray, point: FloatArray, out: FloatArray
) -> bool:
    """Writes a point and its derivatives (2, P); whether all of them are finite."""
    point[0] = x
    point[1] = y
    total = 0.0
    for p in range(carried.shape[1]):
        out[0, p] = carried[0, p]
        out[1, p] = carried[1, p]
        total += carried[0, p] + carried[1, p]
    return math.isfinite(total)


@compiled
def sensitive_roll_out(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    rows: FloatArray,
    step: float,
    path: FloatArray,
    jacobian: FloatArray,
) -> tuple[int, int]:
    """Equal steps into ``path`` (T, 2) and ``jacobian`` (T, 2, 6 Q + 5).

    Returns the points written and the status. A point within a step of the goal is
    followed by the goal itself.
    """
    size = jacobian.shape[2]
    rates = np.zeros((2, 2 + size))
    carried = np.zeros((2, size))
    carried[0, size - 2] = 1.0
    carried[1, size - 1] = 1.0
    _note(x, y, carried, path[0], jacobian[0])
    for n in range(1, path.shape[0]):
        dx = x - gx
        dy = y - gy
        if dx * dx + dy * dy < step * step:
            carried = np.zeros((2, size))
            carried[0, size - 4] = 1.0
            carried[1, size - 3] = 1.0
            _note(gx, gy, carried, path[n], jacobian[n])
            return n + 1, ARRIVED
        x, y, least = sensitive_step(
            x, y, step, rows, kappa, workspace, gx, gy, 0.0, rates, carried
        )
        if not least > 0.0:
            return n, LEFT
        if not _note(x, y, carried, path[n], jacobian[n]):
            return n, TRAPPED
    return path.shape[0], OUT_OF_STEPS
