"""Compiled roll-outs of many starts, sixteen abreast, and under many fields.

Each is bit by bit the one of `bath_drake.field._rollouts`: the same operations in the
same order, only for several points at a time, so that registers are filled.
"""

import math

import numpy as np

from bath_drake.field._boundaries import (
    LANES,
    compiled,
    crosses,
    inlined,
    sharpest,
    slopes,
    unit,
    values,
)
from bath_drake.field._kernels import flow_psi, log_gamma
from bath_drake.field._rollouts import ARRIVED, LEFT, OUT_OF_STEPS, TRAPPED, roll_out
from bath_drake.notation import FloatArray, IntArray

# All lanes cost about what six roll-outs by themselves do.
_FEW = 8


@inlined
def _direction(
    lanes: FloatArray, j: int, gx: float, gy: float, kappa: float
) -> tuple[float, float, float]:
    """`flow` at point j of `slopes`, and gamma; the least beta there is positive."""
    dx = lanes[j] - gx
    dy = lanes[LANES + j] - gy
    gamma = dx * dx + dy * dy
    fx, fy = unit(
        gamma * lanes[2 * LANES + j] - 2.0 * kappa * dx,
        gamma * lanes[3 * LANES + j] - 2.0 * kappa * dy,
    )
    return fx, fy, gamma


@compiled
def _abreast(
    starts: FloatArray,
    first: int,
    stop: int,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
    step: float,
    tolerance: float,
    paths: FloatArray,
    state: FloatArray,
    codes: IntArray,
    facts: FloatArray,
) -> None:
    """`roll_out`, bit by bit, from starts first..stop, at most LANES of them at once.

    ``paths`` (LANES, T, 2); ``state`` (LANES, 8) is room to work in: whether it runs
    (a half where the midpoint is not free), the flow at its last point, psi there, the
    step, the least beta there, and the step's direction.
    """
    tight = (1.0 + 0.5 * step * sharpest(forms)) ** 2 - 1.0
    lanes = np.zeros(5 * LANES)
    logs = np.empty(2 * LANES)
    count = stop - first
    running = 0
    for j in range(LANES):
        state[j, 0] = 0.0
        if j >= count:
            lanes[j] = starts[first, 0]
            lanes[LANES + j] = starts[first, 1]
            continue
        x = starts[first + j, 0]
        y = starts[first + j, 1]
        lanes[j] = x
        lanes[LANES + j] = y
        paths[j, 0, 0] = x
        paths[j, 0, 1] = y
        fx, fy, clear, value = flow_psi(
            x, y, workspace, gx, gy, kappa, forms, 0.0, True
        )
        codes[first + j, 0] = 1
        codes[first + j, 1] = LEFT
        facts[first + j, 2] = clear
        facts[first + j, 3] = 0.0
        if clear > 0.0:
            state[j, 0] = 1.0
            state[j, 1] = fx
            state[j, 2] = fy
            state[j, 3] = value
            state[j, 4] = step
            state[j, 5] = clear
            running += _begin(j, first, gx, gy, step, tolerance, paths, state, codes)
    while running > 0:
        for j in range(count):
            if state[j, 0] > 0.0:
                n = codes[first + j, 0]
                h = state[j, 4]
                lanes[j] = paths[j, n - 1, 0] + 0.5 * h * state[j, 1]
                lanes[LANES + j] = paths[j, n - 1, 1] + 0.5 * h * state[j, 2]
        slopes(lanes, workspace, forms)
        for j in range(count):
            if state[j, 0] > 0.0:
                n = codes[first + j, 0]
                h = state[j, 4]
                state[j, 6] = 0.0
                state[j, 7] = 0.0
                free = lanes[4 * LANES + j] > 0.0
                if free:
                    mx, my, _ = _direction(lanes, j, gx, gy, kappa)
                    state[j, 6] = mx
                    state[j, 7] = my
                lanes[j] = paths[j, n - 1, 0] + h * state[j, 6]
                lanes[LANES + j] = paths[j, n - 1, 1] + h * state[j, 7]
                state[j, 0] = 1.0 if free else 0.5
        slopes(lanes, workspace, forms)
        values(lanes, workspace, forms, logs)
        for j in range(count):
            if state[j, 0] == 0.0:
                continue
            n = codes[first + j, 0]
            h = state[j, 4]
            free = lanes[4 * LANES + j]
            good = False
            if state[j, 0] == 1.0 and free > 0.0:
                ax, ay, gamma = _direction(lanes, j, gx, gy, kappa)
                nx = lanes[j]
                ny = lanes[LANES + j]
                after = kappa * log_gamma(nx - gx, ny - gy, gamma) - logs[j]
                if after < state[j, 3]:
                    good = not (
                        min(state[j, 5], free) < tight
                        and crosses(
                            paths[j, n - 1, 0],
                            paths[j, n - 1, 1],
                            h * state[j, 6],
                            h * state[j, 7],
                            forms,
                        )
                    )
            state[j, 0] = 1.0
            if good:
                state[j, 1] = ax
                state[j, 2] = ay
                state[j, 3] = after
                state[j, 5] = free
                paths[j, n, 0] = nx
                paths[j, n, 1] = ny
                codes[first + j, 0] = n + 1
                facts[first + j, 2] = min(facts[first + j, 2], free)
                facts[first + j, 3] += h
                running -= 1
                running += _begin(
                    j, first, gx, gy, step, tolerance, paths, state, codes
                )
            else:
                state[j, 4] = 0.5 * h
                if state[j, 4] < 1e-7 * step:
                    codes[first + j, 1] = TRAPPED
                    state[j, 0] = 0.0
                    running -= 1
    for j in range(count):
        n = codes[first + j, 0]
        facts[first + j, 0] = paths[j, n - 1, 0]
        facts[first + j, 1] = paths[j, n - 1, 1]


@inlined
def _begin(
    j: int,
    first: int,
    gx: float,
    gy: float,
    step: float,
    tolerance: float,
    paths: FloatArray,
    state: FloatArray,
    codes: IntArray,
) -> int:
    """Begins lane j's next step, 1, or finds that there is none, 0."""
    n = codes[first + j, 0]
    dx = paths[j, n - 1, 0] - gx
    dy = paths[j, n - 1, 1] - gy
    distance = math.sqrt(dx * dx + dy * dy)
    if distance <= tolerance:
        codes[first + j, 1] = ARRIVED
        state[j, 0] = 0.0
        return 0
    if n == paths.shape[1]:
        codes[first + j, 1] = OUT_OF_STEPS
        state[j, 0] = 0.0
        return 0
    state[j, 4] = min(min(2.0 * state[j, 4], step), distance)
    return 1


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
    paths = np.empty((LANES, max_steps + 1, 2))
    state = np.empty((LANES, 8))
    nowhere = np.zeros(5)  # no gate
    points = np.empty((64 * n if keep else 0, 2))
    used = 0
    i = min(0, n)  # for a literal, numba would compile `_abreast` once more
    while i < n:
        f = which[i]
        stop = i + 1
        while stop < n and stop < i + LANES and which[stop] == f:
            stop += 1
        workspace = constants[f, :5]
        gx, gy, kappa = constants[f, 5], constants[f, 6], constants[f, 7]
        own = forms[offsets[f] : offsets[f + 1]]
        if stop - i < _FEW:
            for j in range(i, stop):
                path = paths[j - i]
                codes[j, 0], codes[j, 1], facts[j, 2], facts[j, 3] = roll_out(
                    starts[j, 0],
                    starts[j, 1],
                    workspace,
                    gx,
                    gy,
                    kappa,
                    own,
                    step,
                    tolerance,
                    nowhere,
                    path,
                )
                facts[j, 0] = path[codes[j, 0] - 1, 0]
                facts[j, 1] = path[codes[j, 0] - 1, 1]
        else:
            _abreast(
                starts,
                i,
                stop,
                workspace,
                gx,
                gy,
                kappa,
                own,
                step,
                tolerance,
                paths,
                state,
                codes,
                facts,
            )
        for j in range(i, stop if keep else i):
            count = codes[j, 0]
            if used + count > points.shape[0]:
                more = np.empty((2 * (used + count), 2))
                for k in range(used):
                    more[k, 0] = points[k, 0]
                    more[k, 1] = points[k, 1]
                points = more
            for k in range(count):
                points[used + k, 0] = paths[j - i, k, 0]
                points[used + k, 1] = paths[j - i, k, 1]
            used += count
        i = stop
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
