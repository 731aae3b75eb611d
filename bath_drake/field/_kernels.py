"""Compiled phi, its flow and derivatives at a point; plain numbers in and out.

A field is handed over as its world (see `bath_drake.field._boundaries`), the goal
(gx, gy) and kappa. Everything works on logarithms: the powers of the paper's Eq. 1
overflow for the kappa a field of many obstacles needs. With

    d = q - q_d,  gamma = |d|^2,  s = grad(beta) / beta,

all of it follows from s, ln beta and, for second derivatives, Hess(beta) / beta.
"""

import math

import numpy as np

from bath_drake.field._boundaries import (
    LANES,
    TINY,
    compiled,
    curvature,
    inlined,
    log_beta,
    min_beta,
    near,
    normal,
    slopes,
    unit,
)
from bath_drake.notation import FloatArray

# The greatest power of e handed out: exp(690) times a coordinate stays finite.
_MAX_LOG = 690.0


@compiled
def log_gamma(dx: float, dy: float, gamma: float) -> float:
    if gamma > 1e-280:
        return math.log(gamma)
    # The square has underflowed, or nearly so; the distance has not.
    return 2.0 * math.log(math.hypot(dx, dy))


@inlined
def flow_psi(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
    floor: float,
    valued: bool,
) -> tuple[float, float, float, float]:
    """Unit direction of -grad phi, the smallest beta and, if ``valued``, psi.

    ``floor`` = 0 is the field itself: the direction is zero at the goal and
    outside free space, and the inward normal on a boundary. A positive floor
    replaces every smaller beta_i by itself: a learner's roll-out that starts
    inside an obstacle is then pushed out instead of ending there.
    """
    x = near(x)
    y = near(y)
    sx, sy, least, value = log_beta(x, y, workspace, forms, floor, valued)
    if least <= 0.0 and floor <= 0.0:
        if least < 0.0:
            return 0.0, 0.0, least, math.inf
        fx, fy = normal(x, y, workspace, forms)
        return fx, fy, least, math.inf
    dx = x - gx
    dy = y - gy
    gamma = dx * dx + dy * dy
    fx, fy = unit(gamma * sx - 2.0 * kappa * dx, gamma * sy - 2.0 * kappa * dy)
    if valued:
        value = kappa * log_gamma(dx, dy, gamma) - value
    return fx, fy, least, value


@inlined
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
    """Unit direction of -grad phi, and the smallest beta; see `flow_psi`."""
    fx, fy, least, _ = flow_psi(x, y, workspace, gx, gy, kappa, forms, floor, False)
    return fx, fy, least


@compiled
def flows(
    q: FloatArray,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
) -> FloatArray:
    """`flow`, bit by bit, at points (n, 2): (n, 2)."""
    n = q.shape[0]
    out = np.empty((n, 2))
    lanes = np.empty(5 * LANES)
    for begin in range(0, n, LANES):
        for j in range(LANES):
            i = min(begin + j, n - 1)
            lanes[j] = near(q[i, 0])
            lanes[LANES + j] = near(q[i, 1])
        slopes(lanes, workspace, forms)
        for j in range(min(LANES, n - begin)):
            i = begin + j
            if lanes[4 * LANES + j] > 0.0:
                dx = lanes[j] - gx
                dy = lanes[LANES + j] - gy
                gamma = dx * dx + dy * dy
                fx, fy = unit(
                    gamma * lanes[2 * LANES + j] - 2.0 * kappa * dx,
                    gamma * lanes[3 * LANES + j] - 2.0 * kappa * dy,
                )
            else:
                fx, fy, _ = flow(q[i, 0], q[i, 1], workspace, gx, gy, kappa, forms, 0.0)
            out[i, 0] = fx
            out[i, 1] = fy
    return out


@compiled
def psi(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
) -> float:
    """The potential kappa ln gamma - ln beta; inf off free space, -inf at the goal."""
    x = near(x)
    y = near(y)
    _, _, least, value = log_beta(x, y, workspace, forms, 0.0, True)
    if least <= 0.0:
        return math.inf
    dx = x - gx
    dy = y - gy
    return kappa * log_gamma(dx, dy, dx * dx + dy * dy) - value


@compiled
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
    if t > 0.0:
        return -(t + math.log1p(math.exp(-t))) / kappa
    return -math.log1p(math.exp(t)) / kappa


@compiled
def _weights(
    log_gamma: float, value: float, kappa: float
) -> tuple[float, float, float]:
    """Logarithms of f, sigma and 1 - sigma.

    f = beta (gamma^kappa + beta)^(-1 - 1/kappa) / kappa, and
    sigma = beta / (gamma^kappa + beta).
    """
    a = kappa * log_gamma
    high = max(a, value)
    total = high + math.log1p(math.exp(min(a, value) - high))
    scale = value - (1.0 + 1.0 / kappa) * total - math.log(kappa)
    return scale, value - total, a - total


@compiled
def grad_phi(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
) -> tuple[float, float]:
    """Gradient of phi: f (2 kappa d - gamma s), f of `_weights`."""
    x = near(x)
    y = near(y)
    sx, sy, least, value = log_beta(x, y, workspace, forms, TINY, True)
    if least < 0.0:
        return 0.0, 0.0
    dx = x - gx
    dy = y - gy
    gamma = dx * dx + dy * dy
    vx = -gamma * sx
    vy = -gamma * sy
    if least > 0.0:  # on a boundary nothing but its normal is left
        vx += 2.0 * kappa * dx
        vy += 2.0 * kappa * dy
    big = max(abs(vx), abs(vy))
    if big == 0.0:
        return 0.0, 0.0
    scale, _, _ = _weights(log_gamma(dx, dy, gamma), value, kappa)
    f = math.exp(min(scale + math.log(big), _MAX_LOG))
    return f * (vx / big), f * (vy / big)


@compiled
def hessian_phi(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
) -> tuple[float, float, float]:
    """Hessian of phi, (xx, xy, yy).

    With e = d / |d|, and f and sigma of `_weights`, it is

    f (2 kappa I - 4 kappa (kappa + 1) (1 - sigma) e e' - 2 kappa c (d s' + s d')
       + gamma ((1 + 1/kappa) sigma s s' - Hess(beta) / beta)),

    c = (1 + 1/kappa) sigma - 1. At the goal sigma is one and the first term is left.
    """
    x = near(x)
    y = near(y)
    _, _, least, value = log_beta(x, y, workspace, forms, TINY, True)
    if least < 0.0:
        return 0.0, 0.0, 0.0
    sx, sy, hxx, hxy, hyy = curvature(x, y, workspace, forms, TINY)
    dx = x - gx
    dy = y - gy
    gamma = dx * dx + dy * dy
    scale, ln_sigma, ln_rest = _weights(log_gamma(dx, dy, gamma), value, kappa)
    ex, ey = unit(dx, dy)
    sigma = (1.0 + 1.0 / kappa) * math.exp(ln_sigma)
    k = -4.0 * kappa * (kappa + 1.0) * math.exp(ln_rest)
    c = -2.0 * kappa * (sigma - 1.0)
    mxx = 2.0 * kappa + k * ex * ex + 2.0 * c * dx * sx
    mxx += gamma * (sigma * sx * sx - hxx)
    mxy = k * ex * ey + c * (dx * sy + dy * sx) + gamma * (sigma * sx * sy - hxy)
    myy = 2.0 * kappa + k * ey * ey + 2.0 * c * dy * sy
    myy += gamma * (sigma * sy * sy - hyy)
    big = max(max(abs(mxx), abs(mxy)), abs(myy))
    if big == 0.0:
        return 0.0, 0.0, 0.0
    f = math.exp(min(scale + math.log(big), _MAX_LOG))
    return f * (mxx / big), f * (mxy / big), f * (myy / big)


@compiled
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
    x = near(x)
    y = near(y)
    sx, sy, hxx, hxy, hyy = curvature(x, y, workspace, forms, 0.0)
    r = math.hypot(x - gx, y - gy)
    ex = (x - gx) / r
    ey = (y - gy) / r
    k = min(2.0 * kappa / r, 1e300)
    k2 = min(k / r, 1e300)
    return (
        k * ex - sx,
        k * ey - sy,
        k2 * (1.0 - 2.0 * ex * ex) + sx * sx - hxx,
        -2.0 * k2 * ex * ey + sx * sy - hxy,
        k2 * (1.0 - 2.0 * ey * ey) + sy * sy - hyy,
    )


@compiled
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
