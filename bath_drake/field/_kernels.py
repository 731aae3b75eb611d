"""Compiled kernels of the field; plain arrays in, plain arrays out.

A field is handed over as four things: ``workspace`` (5,) holding the centre,
the semi-axes and the power; ``goal`` (2,); ``kappa``; and ``forms`` (Q, 6), one
row (cx, cy, A, B, C, w) an obstacle, from `quadratic_forms`, so that

    beta_i = A dx^2 + 2 B dx dy + C dy^2 - 1,

with exponent w. Everything works on logarithms: the powers of the paper's Eq. 1
overflow for the kappa a field of many obstacles needs.

Kernels that call each other live in one file because numba's on-disk cache
notices changes of a function's own file only.
"""

import math

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray

# Points farther out are moved here first: their squares must stay finite.
_FAR = 1e100
# The greatest power of e handed out: exp(690) times a coordinate stays finite.
_MAX_LOG = 690.0

ARRIVED, TRAPPED, LEFT, OUT_OF_STEPS = 0, 1, 2, 3


@njit(cache=True)
def quadratic_forms(theta: FloatArray, exponents: FloatArray) -> FloatArray:
    """Turns ellipse rows (Q, 5) and exponents (Q,) into rows of forms (Q, 6)."""
    forms = np.empty((theta.shape[0], 6))
    for i in range(theta.shape[0]):
        c = math.cos(theta[i, 4])
        s = math.sin(theta[i, 4])
        p = 1.0 / (theta[i, 2] * theta[i, 2])
        r = 1.0 / (theta[i, 3] * theta[i, 3])
        forms[i, 0] = theta[i, 0]
        forms[i, 1] = theta[i, 1]
        forms[i, 2] = c * c * p + s * s * r
        forms[i, 3] = c * s * (p - r)
        forms[i, 4] = s * s * p + c * c * r
        forms[i, 5] = exponents[i]
    return forms


@njit(cache=True)
def _near(x: float) -> float:
    return min(max(x, -_FAR), _FAR)


@njit(cache=True)
def _rim(x: float, y: float, workspace: FloatArray) -> tuple[float, float, float]:
    """beta_0 and its gradient."""
    dx = (x - workspace[0]) / workspace[2]
    dy = (y - workspace[1]) / workspace[3]
    p = workspace[4]
    if p == 2.0:  # by far the most common, and pow is slow
        return (
            1.0 - dx * dx - dy * dy,
            -2.0 * dx / workspace[2],
            -2.0 * dy / workspace[3],
        )
    ex = abs(dx) ** (p - 1.0)
    ey = abs(dy) ** (p - 1.0)
    value = 1.0 - ex * abs(dx) - ey * abs(dy)
    gx = -p * math.copysign(ex, dx) / workspace[2]
    gy = -p * math.copysign(ey, dy) / workspace[3]
    return max(value, -1e300), gx, gy


@njit(cache=True)
def _ellipse(x: float, y: float, form: FloatArray) -> tuple[float, float, float]:
    """beta_i and its gradient."""
    dx = x - form[0]
    dy = y - form[1]
    hx = form[2] * dx + form[3] * dy
    hy = form[3] * dx + form[4] * dy
    return dx * hx + dy * hy - 1.0, 2.0 * hx, 2.0 * hy


@njit(cache=True)
def min_beta(x: float, y: float, workspace: FloatArray, forms: FloatArray) -> float:
    """The smallest of all beta_i, the workspace's own included."""
    x = _near(x)
    y = _near(y)
    least = _rim(x, y, workspace)[0]
    for i in range(forms.shape[0]):
        least = min(least, _ellipse(x, y, forms[i])[0])
    return least


@njit(cache=True)
def flow(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
    floor: float,
) -> tuple[float, float, float]:
    """Unit direction of -grad phi, and the smallest beta.

    ``floor`` = 0 is the field itself: the direction is zero at the goal and
    outside free space, and the inward normal on a boundary. A positive floor
    replaces every smaller beta_i by itself: a learner's roll-out that starts
    inside an obstacle is then pushed out instead of ending there.
    """
    x = _near(x)
    y = _near(y)
    rim, sx, sy = _rim(x, y, workspace)
    least = rim
    for i in range(forms.shape[0]):
        least = min(least, _ellipse(x, y, forms[i])[0])
    if least < 0.0 and floor <= 0.0:
        return 0.0, 0.0, least
    # Everything is multiplied by the smallest beta: no quotient can overflow,
    # and on a boundary what remains is exactly that boundary's normal.
    m = max(least, floor)
    rim = max(rim, floor)
    if rim > m:
        sx *= m / rim
        sy *= m / rim
    for i in range(forms.shape[0]):
        b, bx, by = _ellipse(x, y, forms[i])
        r = forms[i, 5]
        if b > m:
            r *= m / b
        sx += r * bx
        sy += r * by
    dx = x - gx
    dy = y - gy
    gamma = dx * dx + dy * dy
    vx = gamma * sx - 2.0 * kappa * m * dx
    vy = gamma * sy - 2.0 * kappa * m * dy
    big = max(abs(vx), abs(vy))
    if big == 0.0:
        return 0.0, 0.0, least
    vx /= big
    vy /= big
    n = math.sqrt(vx * vx + vy * vy)
    return vx / n, vy / n, least


@njit(cache=True)
def psi(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
) -> float:
    """The potential kappa ln gamma - sum_i w_i ln beta_i; +inf off free space."""
    x = _near(x)
    y = _near(y)
    b = _rim(x, y, workspace)[0]
    if b <= 0.0:
        return math.inf
    total = -math.log(b)
    for i in range(forms.shape[0]):
        b = _ellipse(x, y, forms[i])[0]
        if b <= 0.0:
            return math.inf
        total -= forms[i, 5] * math.log(b)
    gamma = (x - gx) * (x - gx) + (y - gy) * (y - gy)
    if gamma == 0.0:
        return -math.inf
    return total + kappa * math.log(gamma)


@njit(cache=True)
def ln_phi(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
) -> float:
    """The logarithm -softplus(-psi) / kappa: nothing cancels or overflows."""
    t = -psi(x, y, workspace, gx, gy, kappa, forms)
    if t == math.inf:
        return -math.inf
    if t > 0.0:
        return -(t + math.log1p(math.exp(-t))) / kappa
    return -math.log1p(math.exp(t)) / kappa


@njit(cache=True)
def grad_phi(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
) -> tuple[float, float]:
    """Gradient of phi (see `bath_drake.field.navigation.grad_phi`)."""
    x = _near(x)
    y = _near(y)
    rim, sx, sy = _rim(x, y, workspace)
    least = rim
    at = -1
    for i in range(forms.shape[0]):
        b = _ellipse(x, y, forms[i])[0]
        if b < least:
            least = b
            at = i
    if least < 0.0:
        return 0.0, 0.0
    dx = x - gx
    dy = y - gy
    gamma = dx * dx + dy * dy
    if gamma == 0.0:
        return 0.0, 0.0
    # ln beta without the smallest factor, and V = -(beta_min gamma) grad psi.
    rest = 0.0
    if at >= 0:
        rest = math.log(rim) if rim > 0.0 else -math.inf
        if rim > least:
            sx *= least / rim
            sy *= least / rim
    for i in range(forms.shape[0]):
        b, bx, by = _ellipse(x, y, forms[i])
        w = forms[i, 5]
        if i != at:
            rest += w * math.log(b) if b > 0.0 else -math.inf
        if b > least:
            w *= least / b
        sx += w * bx
        sy += w * by
    vx = gamma * sx - 2.0 * kappa * least * dx
    vy = gamma * sy - 2.0 * kappa * least * dy
    w = forms[at, 5] if at >= 0 else 1.0
    ln_least = math.log(least) if least > 0.0 else -math.inf
    over = rest  # ln(beta / beta_min)
    if w != 1.0:
        over += (w - 1.0) * ln_least
    ln_beta = rest + w * ln_least
    t = ln_beta - kappa * math.log(gamma)
    if t > 0.0:
        scale = over - (1.0 + 1.0 / kappa) * (ln_beta + math.log1p(math.exp(-t)))
    else:
        scale = over - (1.0 + 1.0 / kappa) * math.log1p(math.exp(t))
        scale -= (kappa + 1.0) * math.log(gamma)
    f = -math.exp(min(scale - math.log(kappa), _MAX_LOG))
    return f * vx, f * vy


@njit(cache=True)
def grad_hessian_psi(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
) -> tuple[float, float, float, float, float]:
    """(psi_x, psi_y, psi_xx, psi_xy, psi_yy) at an interior point off the goal."""
    dx = x - gx
    dy = y - gy
    g = dx * dx + dy * dy
    k = 2.0 * kappa / g
    fx = k * dx
    fy = k * dy
    hxx = k * (1.0 - 2.0 * dx * dx / g)
    hxy = -2.0 * k * dx * dy / g
    hyy = k * (1.0 - 2.0 * dy * dy / g)
    b, bx, by = _rim(x, y, workspace)
    p = workspace[4]
    ux = abs((x - workspace[0]) / workspace[2]) ** (p - 2.0)
    uy = abs((y - workspace[1]) / workspace[3]) ** (p - 2.0)
    bxx = -p * (p - 1.0) * ux / (workspace[2] * workspace[2])
    byy = -p * (p - 1.0) * uy / (workspace[3] * workspace[3])
    fx -= bx / b
    fy -= by / b
    hxx += bx * bx / (b * b) - bxx / b
    hxy += bx * by / (b * b)
    hyy += by * by / (b * b) - byy / b
    for i in range(forms.shape[0]):
        b, bx, by = _ellipse(x, y, forms[i])
        r = forms[i, 5] / b
        fx -= r * bx
        fy -= r * by
        hxx += r * (bx * bx / b - 2.0 * forms[i, 2])
        hxy += r * (bx * by / b - 2.0 * forms[i, 3])
        hyy += r * (by * by / b - 2.0 * forms[i, 4])
    return fx, fy, hxx, hxy, hyy


@njit(cache=True)
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
) -> tuple[int, int, float]:
    """Guarded roll-out into ``path`` (T, 2): points written, status, least beta.

    Midpoint steps of arc length ``step`` (shorter near the goal); a step is
    halved until psi, and with it phi, falls and the new point is free.
    """
    path[0, 0] = x
    path[0, 1] = y
    value = psi(x, y, workspace, gx, gy, kappa, forms)
    fx, fy, clear = flow(x, y, workspace, gx, gy, kappa, forms, 0.0)
    if clear <= 0.0:
        return 1, LEFT, clear
    h = step
    for n in range(1, path.shape[0] + 1):
        distance = math.hypot(x - gx, y - gy)
        if distance <= tolerance:
            return n, ARRIVED, clear
        if n == path.shape[0]:
            break
        # Grow again after a tight spot, but never beyond the asked step.
        h = min(min(2.0 * h, step), distance)
        while True:
            mx, my, least = flow(
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
            after = math.inf
            if least > 0.0:
                after = psi(nx, ny, workspace, gx, gy, kappa, forms)
            if after < value:
                break
            h *= 0.5
            # Far below any step worth taking: a critical point holds it.
            if h < 1e-7 * step:
                return n, TRAPPED, clear
        x = nx
        y = ny
        value = after
        path[n, 0] = x
        path[n, 1] = y
        fx, fy, least = flow(x, y, workspace, gx, gy, kappa, forms, 0.0)
        clear = min(clear, least)
    return path.shape[0], OUT_OF_STEPS, clear


@njit(cache=True)
def roll_outs(
    starts: FloatArray,
    workspace: FloatArray,
    goal: FloatArray,
    kappa: float,
    forms: FloatArray,
    step: float,
    tolerance: float,
    max_steps: int,
) -> tuple[FloatArray, FloatArray]:
    """Statuses (n,) as floats and end points (n, 2) of a batch of roll-outs."""
    status = np.empty(starts.shape[0])
    ends = np.empty_like(starts)
    path = np.empty((max_steps + 1, 2))
    for i in range(starts.shape[0]):
        n, s, _ = roll_out(
            starts[i, 0],
            starts[i, 1],
            workspace,
            goal[0],
            goal[1],
            kappa,
            forms,
            step,
            tolerance,
            path,
        )
        status[i] = s
        ends[i] = path[n - 1]
    return status, ends


@njit(cache=True)
def newton_points(
    starts: FloatArray,
    workspace: FloatArray,
    goal: FloatArray,
    kappa: float,
    forms: FloatArray,
    iterations: int,
) -> FloatArray:
    """Roots of grad psi from many starts: rows (x, y, Hessian xx, xy, yy).

    Newton's step, shortened to stay in free space and inside a trust radius;
    only starts that converge to a relative residual of 1e-9 give a row.
    """
    rows = np.empty((starts.shape[0], 5))
    count = 0
    size = max(workspace[2], workspace[3])
    gx = goal[0]
    gy = goal[1]
    for i in range(starts.shape[0]):
        x = starts[i, 0]
        y = starts[i, 1]
        if min_beta(x, y, workspace, forms) <= 0.0:
            continue
        for _ in range(iterations):
            if x == gx and y == gy:
                break
            fx, fy, hxx, hxy, hyy = grad_hessian_psi(
                x, y, workspace, gx, gy, kappa, forms
            )
            det = hxx * hyy - hxy * hxy
            if det == 0.0 or not math.isfinite(det):
                break
            dx = (hxy * fy - hyy * fx) / det
            dy = (hxy * fx - hxx * fy) / det
            length = math.hypot(dx, dy)
            if length < 1e-11 * size:
                # The residual's yardstick is its largest single term.
                d = math.hypot(x - gx, y - gy)
                if math.hypot(fx, fy) <= 1e-9 * 2.0 * kappa / d:
                    rows[count, 0] = x
                    rows[count, 1] = y
                    rows[count, 2] = hxx
                    rows[count, 3] = hxy
                    rows[count, 4] = hyy
                    count += 1
                break
            shrink = min(1.0, 0.1 * size / length)
            while (
                min_beta(x + shrink * dx, y + shrink * dy, workspace, forms) <= 0.0
                and shrink > 1e-9
            ):
                shrink *= 0.5
            if shrink <= 1e-9:
                break
            x += shrink * dx
            y += shrink * dy
    return rows[:count]
