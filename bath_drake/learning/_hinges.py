"""What a member lacks in validity, with exact derivatives, compiled.

Each hinge depends on one obstacle or on two, so a row of its derivatives has ten
entries at most and is written as such.

A member is a vector x as in `bath_drake.learning._kernels`.
"""

import math

import numpy as np

from bath_drake.field._boundaries import compiled, quadratic_forms
from bath_drake.notation import FloatArray, IntArray

# A row: value, first obstacle, second obstacle (-1: none; -2: kappa alone), ten slopes.
HINGE = 13
# A point this near to the centre, in beta + 1, has no ray.
_CENTRE = 1e-12
_DIRECTIONS = 6  # on each side of the line of centres


@compiled
def member_forms(x: FloatArray) -> FloatArray:
    """The obstacles of a member as rows of quadratic forms (Q, 6)."""
    q = (x.shape[0] - 1) // 5
    theta = np.empty((q, 5))
    for i in range(q):
        for k in range(5):
            theta[i, k] = x[5 * i + k]
        theta[i, 2] = math.exp(x[5 * i + 2])
        theta[i, 3] = math.exp(x[5 * i + 3])
    return quadratic_forms(theta, np.ones(q))


@compiled
def hinge_count(q: int) -> int:
    """How many hinges q obstacles have."""
    return q * (q - 1) // 2 + 4 * q + 1


@compiled
def _reach(axes: FloatArray, ux: float, uy: float) -> float:
    """How far an ellipse (a, b, cos, sin) reaches from its centre along u."""
    p = axes[0] * (axes[2] * ux + axes[3] * uy)
    q = axes[1] * (axes[2] * uy - axes[3] * ux)
    return math.sqrt(p * p + q * q)


@compiled
def _reach_slopes(axes: FloatArray, ux: float, uy: float, out: FloatArray) -> None:
    """Derivatives of `_reach` to ln a, ln b and the angle."""
    p = axes[2] * ux + axes[3] * uy
    q = axes[2] * uy - axes[3] * ux
    a2 = axes[0] * axes[0]
    b2 = axes[1] * axes[1]
    reach = max(math.sqrt(a2 * p * p + b2 * q * q), 1e-12)
    out[0] = a2 * p * p / reach
    out[1] = b2 * q * q / reach
    out[2] = (a2 - b2) * p * q / reach


@compiled
def _pair(
    x: FloatArray, axes: FloatArray, i: int, j: int, margin: float, row: FloatArray
) -> None:
    """The widest slit between two ellipses over some directions, from below."""
    dx = x[5 * j] - x[5 * i]
    dy = x[5 * j + 1] - x[5 * i + 1]
    d = math.sqrt(dx * dx + dy * dy)
    big = max(axes[i, 0], axes[i, 1]) + max(axes[j, 0], axes[j, 1])
    row[0] = 0.0
    if d - big >= margin:
        return
    best = -1e9
    bx = 1.0
    by = 0.0
    # Beyond 90 degrees off the line of centres no slit can be.
    for k in range(-_DIRECTIONS, _DIRECTIONS + 1):
        t = k * (0.5 * math.pi / (_DIRECTIONS + 1))
        c = math.cos(t)
        s = math.sin(t)
        if d > 0.0:
            ux = (c * dx - s * dy) / d
            uy = (c * dy + s * dx) / d
        else:
            ux = c
            uy = s
        gap = dx * ux + dy * uy - _reach(axes[i], ux, uy) - _reach(axes[j], ux, uy)
        if gap > best:
            best = gap
            bx = ux
            by = uy
    if best >= margin:
        return
    row[0] = margin - best
    _reach_slopes(axes[i], bx, by, row[5:8])
    _reach_slopes(axes[j], bx, by, row[10:13])
    # The directions turn with the line of centres.
    turn = (dy * bx - dx * by + row[7] + row[12]) / max(d * d, 1e-12)
    row[3] = bx - turn * dy
    row[4] = by + turn * dx
    row[8] = -row[3]
    row[9] = -row[4]


@compiled
def _ray(
    x: FloatArray,
    axes: FloatArray,
    i: int,
    px: float,
    py: float,
    margin: float,
    row: FloatArray,
) -> None:
    """Distance of a point from ellipse i along the ray from its centre; < 0 within."""
    dx = px - x[5 * i]
    dy = py - x[5 * i + 1]
    a, b, c, s = axes[i, 0], axes[i, 1], axes[i, 2], axes[i, 3]
    u = c * dx + s * dy
    v = c * dy - s * dx
    gu = u / (a * a)
    gv = v / (b * b)
    r = u * gu + v * gv
    if r < _CENTRE:
        row[0] = margin + min(a, b)
        row[3:8] = 0.0
        return
    d = math.sqrt(dx * dx + dy * dy)
    root = 1.0 / math.sqrt(r)
    gap = d - d * root
    row[0] = 0.0
    if gap >= margin:
        return
    row[0] = margin - gap
    cube = d * root / r
    row[3] = dx / d * (1.0 - root) + cube * (c * gu - s * gv)
    row[4] = dy / d * (1.0 - root) + cube * (s * gu + c * gv)
    row[5] = cube * u * gu
    row[6] = cube * v * gv
    row[7] = -cube * u * v * (1.0 / (a * a) - 1.0 / (b * b))


@compiled
def _flatness(
    cx: float, cy: float, a: float, b: float, t: float, goal: FloatArray, margin: float
) -> float:
    """The evolute test of `curvature_margin`, with logarithms for scale."""
    c = math.cos(t)
    s = math.sin(t)
    dx = goal[0] - cx
    dy = goal[1] - cy
    reach = (a * abs(c * dx + s * dy)) ** (2.0 / 3.0)
    reach += (b * abs(c * dy - s * dx)) ** (2.0 / 3.0)
    evolute = abs(a * a - b * b) ** (2.0 / 3.0)
    if evolute * (1.0 + margin) > reach:
        return 0.1 * math.log(evolute * (1.0 + margin) / max(reach, 1e-9))
    return 0.0


@compiled
def member_hinges(
    x: FloatArray,
    forms: FloatArray,
    points: FloatArray,
    workspace: FloatArray,
    goal: FloatArray,
    margins: FloatArray,
    out: FloatArray,
) -> None:
    """The hinges of one member into ``out`` (H, HINGE); see `hinges`."""
    q = forms.shape[0]
    axes = np.empty((q, 4))
    for i in range(q):
        axes[i, 0] = math.exp(x[5 * i + 2])
        axes[i, 1] = math.exp(x[5 * i + 3])
        axes[i, 2] = math.cos(x[5 * i + 4])
        axes[i, 3] = math.sin(x[5 * i + 4])
    n = 0
    for i in range(q):
        for j in range(i):
            out[n, 1] = i
            out[n, 2] = j
            _pair(x, axes, i, j, margins[0], out[n])
            n += 1
    inner = min(workspace[2], workspace[3])
    for i in range(q):
        for k in range(4):
            out[n + k, 1] = i
            out[n + k, 2] = -1
        u = x[5 * i] - workspace[0]
        v = x[5 * i + 1] - workspace[1]
        d = math.sqrt(u * u + v * v)
        big = 0 if axes[i, 0] >= axes[i, 1] else 1
        row = out[n]
        row[0] = max(0.0, margins[1] - (inner - d - axes[i, big]))
        row[3] = u / max(d, 1e-12)
        row[4] = v / max(d, 1e-12)
        row[5] = axes[i, 0] if big == 0 else 0.0
        row[6] = axes[i, 1] if big == 1 else 0.0
        row[7] = 0.0
        nearest = -1
        least = math.inf
        for k in range(points.shape[0]):
            dx = points[k, 0] - x[5 * i]
            dy = points[k, 1] - x[5 * i + 1]
            r = forms[i, 2] * dx * dx + 2.0 * forms[i, 3] * dx * dy
            r = max(r + forms[i, 4] * dy * dy, _CENTRE)
            d = math.sqrt(dx * dx + dy * dy) * (1.0 - 1.0 / math.sqrt(r))
            if d < least:
                least = d
                nearest = k
        _ray(x, axes, i, points[nearest, 0], points[nearest, 1], margins[2], out[n + 1])
        _ray(x, axes, i, goal[0], goal[1], margins[3], out[n + 2])
        row = out[n + 3]
        cx, cy, t = x[5 * i], x[5 * i + 1], x[5 * i + 4]
        a, b = axes[i, 0], axes[i, 1]
        lack = _flatness(cx, cy, a, b, t, goal, margins[5])
        row[0] = lack
        if lack > 0.0:
            e = 1e-6
            row[3] = (_flatness(cx + e, cy, a, b, t, goal, margins[5]) - lack) / e
            row[4] = (_flatness(cx, cy + e, a, b, t, goal, margins[5]) - lack) / e
            more = 1.0 + e
            row[5] = (_flatness(cx, cy, a * more, b, t, goal, margins[5]) - lack) / e
            row[6] = (_flatness(cx, cy, a, b * more, t, goal, margins[5]) - lack) / e
            row[7] = (_flatness(cx, cy, a, b, t + e, goal, margins[5]) - lack) / e
        n += 4
    lack = math.log(max(margins[4] * q, 1e-9)) - x[x.shape[0] - 1]
    out[n, 0] = 0.1 * max(0.0, lack)
    out[n, 1] = -2.0
    out[n, 2] = -1.0
    out[n, 3] = -0.1


@compiled
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
    count = hinge_count((xs.shape[1] - 1) // 5)
    rows = np.zeros((count, HINGE))
    out = np.empty((xs.shape[0], count))
    for k in range(xs.shape[0]):
        forms = member_forms(xs[k])
        member_hinges(xs[k], forms, points, workspace, goal, margins, rows)
        for n in range(count):
            out[k, n] = rows[n, 0]
    return out


@compiled
def _places(row: FloatArray, size: int, at: IntArray) -> int:
    """Which of ``size`` entries a row's slopes belong to: into ``at``, and how many."""
    if row[1] < 0.0:
        at[0] = size - 1
        return 1
    for k in range(5):
        at[k] = 5 * int(row[1]) + k
        at[5 + k] = 5 * int(row[2]) + k
    return 10 if row[2] >= 0.0 else 5


@compiled
def dense(row: FloatArray, size: int) -> FloatArray:
    """A row's slopes to all entries, shape (size,); zeros where nothing lacks."""
    out = np.zeros(size)
    at = np.empty(10, np.int64)
    if row[0] > 0.0:
        for i in range(_places(row, size, at)):
            out[at[i]] = row[3 + i]
    return out


@compiled
def add_hinges(
    rows: FloatArray, mu: float, matrix: FloatArray, gradient: FloatArray
) -> None:
    """Adds mu times the normal equations of active hinges to (P, P) and (P,)."""
    at = np.empty(10, np.int64)
    for n in range(rows.shape[0]):
        lack = rows[n, 0]
        if lack <= 0.0:
            continue
        count = _places(rows[n], gradient.shape[0], at)
        for i in range(count):
            gradient[at[i]] += mu * rows[n, 3 + i] * lack
            for j in range(count):
                matrix[at[i], at[j]] += mu * rows[n, 3 + i] * rows[n, 3 + j]
