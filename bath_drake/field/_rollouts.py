"""Compiled roll-outs; for the field's arguments see `bath_drake.field._kernels`."""

import math

import numpy as np

from bath_drake.field._boundaries import compiled, crosses, sharpest
from bath_drake.field._kernels import flow, flow_psi
from bath_drake.notation import FloatArray, IntArray

ARRIVED, TRAPPED, LEFT, OUT_OF_STEPS = 0, 1, 2, 3


@compiled
def roll_out(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
    step: float,
    tolerance: float,
    path: FloatArray,
) -> tuple[int, int, float, float]:
    """Guarded roll-out into ``path`` (T, 2).

    Returns the points written, the status, the least beta and the arc length.
    Midpoint steps of arc length ``step`` (shorter near the goal); a step is
    halved until psi, and with it phi, falls and the whole way to the new point is free.
    """
    path[0, 0] = x
    path[0, 1] = y
    length = 0.0
    fx, fy, clear, value = flow_psi(x, y, workspace, gx, gy, kappa, forms, 0.0, True)
    if not clear > 0.0:  # or not a number
        return 1, LEFT, clear, length
    h = step
    # In an ellipse's own norm, sqrt(beta + 1), a step over it must begin or end within
    # half its length of the boundary; elsewhere there is no need to look.
    tight = (1.0 + 0.5 * step * sharpest(forms)) ** 2 - 1.0
    least = clear
    for n in range(1, path.shape[0] + 1):
        distance = math.sqrt((x - gx) * (x - gx) + (y - gy) * (y - gy))
        if distance <= tolerance:
            return n, ARRIVED, clear, length
        if n == path.shape[0]:
            break
        # Grow again after a tight spot, but never beyond the asked step.
        h = min(min(2.0 * h, step), distance)
        while True:
            mx, my, free = flow(
                x + 0.5 * h * fx,
                y + 0.5 * h * fy,
                workspace,
                gx,
                gy,
                kappa,
                forms,
                0.0,
            )
            nx = x + h * mx
            ny = y + h * my
            if free > 0.0:
                # The next step's first direction comes with this one's test.
                ax, ay, free, after = flow_psi(
                    nx, ny, workspace, gx, gy, kappa, forms, 0.0, True
                )
                close = min(least, free) < tight
                if after < value and not (
                    close and crosses(x, y, h * mx, h * my, forms)
                ):
                    break
            h *= 0.5
            # Far below any step worth taking: a critical point holds it.
            if h < 1e-7 * step:
                return n, TRAPPED, clear, length
        x = nx
        y = ny
        fx = ax
        fy = ay
        value = after
        length += h
        least = free
        clear = min(clear, least)
        path[n, 0] = x
        path[n, 1] = y
    return path.shape[0], OUT_OF_STEPS, clear, length


@compiled
def _copy(source: FloatArray, count: int, target: FloatArray, to: int) -> None:
    # Assigned slices take numba seconds to compile.
    for i in range(count):
        target[to + i, 0] = source[i, 0]
        target[to + i, 1] = source[i, 1]


@compiled
def roll_outs(
    starts: FloatArray,
    which: IntArray,
    constants: FloatArray,
    forms: FloatArray,
    offsets: IntArray,
    step: float,
    tolerance: float,
    max_steps: int,
    keep: bool,
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Roll-outs from starts (n, 2), each under the field ``which`` (n,) names.

    Field f has the row ``constants[f]`` (workspace, goal, kappa), shape (F, 8), and
    the forms from ``offsets[f]`` to ``offsets[f + 1]``.

    Returns:
        Points written and status (n, 2); end point, least beta and length (n, 4);
        and, if ``keep``, all points behind each other (N, 2), else none.
    """
    n = starts.shape[0]
    codes = np.empty((n, 2), dtype=np.int64)
    facts = np.empty((n, 4))
    path = np.empty((max_steps + 1, 2))
    points = np.empty((64 * n if keep else 0, 2))
    used = 0
    for i in range(n):
        f = which[i]
        count, status, clear, length = roll_out(
            starts[i, 0],
            starts[i, 1],
            constants[f, :5],
            constants[f, 5],
            constants[f, 6],
            constants[f, 7],
            forms[offsets[f] : offsets[f + 1]],
            step,
            tolerance,
            path,
        )
        codes[i, 0] = count
        codes[i, 1] = status
        facts[i, 0] = path[count - 1, 0]
        facts[i, 1] = path[count - 1, 1]
        facts[i, 2] = clear
        facts[i, 3] = length
        if keep:
            if used + count > points.shape[0]:
                more = np.empty((2 * (used + count), 2))
                _copy(points, used, more, 0)
                points = more
            _copy(path, count, points, used)
            used += count
    return codes, facts, points[:used]


@compiled
def unpack(points: FloatArray, codes: IntArray, paths: FloatArray) -> None:
    """Spreads what `roll_outs` kept over rows of ``paths`` (n, T, 2), ends repeated."""
    k = 0
    for i in range(paths.shape[0]):
        count = codes[i, 0]
        for t in range(paths.shape[1]):
            j = k + min(t, count - 1)
            paths[i, t, 0] = points[j, 0]
            paths[i, t, 1] = points[j, 1]
        k += count
