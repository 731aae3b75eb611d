"""Can a minimum of psi lie in a box? The tests of the proof, cheapest first.

With psi = kappa ln gamma - sum_j w_j ln beta_j (j = 0 the rim), F = grad psi,
p = q - q_d and B a closed box, each of these excludes a minimum besides q_d from the
free part of B, that is from {q in B: all beta_j(q) > 0}:

OUTSIDE     some beta_j <= 0 on B: there is no free part.
RADIAL      p . F = 2 kappa - sum_j w_j p . grad beta_j / beta_j > 0 on the free part:
            F vanishes nowhere but at q_d, where psi is -inf. This one covers q_d.
ONE_WAY     d . F < 0 on the free part for a fixed direction d: F does not vanish.
            Where beta_j reaches from <= 0 to h, d . grad beta_j >= g >= 0 on B gives
            d . grad beta_j / beta_j >= g / h on the free part; so d is chosen to
            point out of the obstacles that are near.
NO_ROOT     F(m) + H(B) (q - m) is nowhere 0, by a fixed direction or after
            preconditioning with an approximate inverse of H: nor is F (mean value).
SADDLE      u . H u < 0 all over B for a fixed u: a critical point there may be, but
            its Hessian has a negative eigenvalue. It is a strict saddle or a maximum.
ABOVE       psi > c all over the free part, if only {psi <= c} is asked for.

Any d, u or preconditioner makes a sound test, so these are chosen with plain floats.
"""

import math
from typing import Final

from numba import njit

from bath_drake.certificate.directions import escape_direction, force_direction
from bath_drake.certificate.evaluation import (
    BETA,
    GX,
    GY,
    HXX,
    HXY,
    HYY,
    MID_GX,
    MID_GY,
    TINY,
    WEIGHT,
    evaluate,
    get,
    gradient_at_middle,
    gradient_reach,
    middle,
    radius,
)
from bath_drake.certificate.intervals import (
    Interval,
    above,
    add,
    below,
    divide,
    double,
    magnitude,
    multiply,
    point,
    reach,
    scale,
    square,
    subtract,
)
from bath_drake.certificate.levels import is_above
from bath_drake.certificate.world import World
from bath_drake.notation import FloatArray

OUTSIDE: Final = 0
RADIAL: Final = 1
ONE_WAY: Final = 2
NO_ROOT: Final = 3
SADDLE: Final = 4
ABOVE: Final = 5
OPEN: Final = 6  # none of them
CONVEX: Final = 7  # none of them, and psi looks convex: there may be a minimum


@njit(cache=True, nogil=True)
def box_test(
    x: Interval, y: Interval, world: World, level: float, table: FloatArray
) -> int:
    """Which test settles a box, or OPEN or CONVEX.

    The table is scratch, from `new_table`; `level` is c of ABOVE, inf for all
    free space.
    """
    if not evaluate(x, y, world, table):
        return OUTSIDE
    px = subtract(x, point(world.goal[0]))
    py = subtract(y, point(world.goal[1]))
    if _radial(x, y, px, py, world, table):
        return RADIAL
    gamma = add(square(px), square(py))
    if not gamma[0] > TINY:
        return OPEN
    if level < math.inf and is_above(gamma, world, level, table):
        return ABOVE
    rx = radius(x)
    ry = radius(y)
    found, ux, uy = escape_direction(x, y, world, table)
    if found and _one_way(ux, uy, px, py, gamma, rx, ry, world, table):
        return ONE_WAY
    found, ux, uy = force_direction(x, y, world, table)
    if found and _one_way(ux, uy, px, py, gamma, rx, ry, world, table):
        return ONE_WAY
    for j in range(table.shape[0]):
        if not table[j, BETA, 0] > TINY:
            return OPEN
    hxx, hxy, hyy = hessian(px, py, gamma, world, table)
    mx = subtract(point(middle(x)), point(world.goal[0]))
    my = subtract(point(middle(y)), point(world.goal[1]))
    fx, fy = gradient_at_middle(mx, my, world, table)
    if _no_root(fx, fy, hxx, hxy, hyy, rx, ry):
        return NO_ROOT
    if _strict_saddle(px, py, gamma, hxx, hxy, hyy, world, table):
        return SADDLE
    a = middle(hxx)
    b = middle(hxy)
    c = middle(hyy)
    return CONVEX if a + c > 0.0 and a * c > b * b else OPEN


@njit(cache=True, nogil=True)
def _radial(
    x: Interval, y: Interval, px: Interval, py: Interval, world: World, t: FloatArray
) -> bool:
    if not _radial_at_middle(x, y, world, t):
        return False
    rx = radius(x)
    ry = radius(y)
    mx = subtract(point(middle(x)), point(world.goal[0]))
    my = subtract(point(middle(y)), point(world.goal[1]))
    least = 2.0 * world.kappa
    for j in range(t.shape[0]):
        # N = p . grad beta_j, directly and about the middle (grad N = grad beta + H p).
        gx = get(t, j, GX)
        gy = get(t, j, GY)
        hxy = get(t, j, HXY)
        nx = add(gx, add(multiply(get(t, j, HXX), px), multiply(hxy, py)))
        ny = add(gy, add(multiply(hxy, px), multiply(get(t, j, HYY), py)))
        at = add(multiply(mx, get(t, j, MID_GX)), multiply(my, get(t, j, MID_GY)))
        n = above(at[1] + reach(nx, rx, ny, ry))
        n = min(n, add(multiply(px, gx), multiply(py, gy))[1])
        if n <= 0.0:
            n = above(n / t[j, BETA, 1])
        elif t[j, BETA, 0] > 0.0:
            n = above(n / t[j, BETA, 0])
        else:
            return False
        least = below(least - above(world.exponents[j] * n))
    return least > 0.0


@njit(cache=True, nogil=True)
def _radial_at_middle(x: Interval, y: Interval, world: World, t: FloatArray) -> bool:
    """Whether `_radial` may succeed: a test with floats that spares most boxes it."""
    px = middle(x) - world.goal[0]
    py = middle(y) - world.goal[1]
    least = 2.0 * world.kappa
    for j in range(t.shape[0]):
        n = px * t[j, MID_GX, 0] + py * t[j, MID_GY, 0]
        if n > 0.0 and not t[j, BETA, 0] > 0.0:
            return False
        least -= t[j, WEIGHT, 0] * n
    return least > 0.0


@njit(cache=True, nogil=True)
def _one_way(
    ux: float,
    uy: float,
    px: Interval,
    py: Interval,
    gamma: Interval,
    rx: float,
    ry: float,
    world: World,
    t: FloatArray,
) -> bool:
    along = add(scale(ux, px), scale(uy, py))
    most = divide(scale(2.0 * world.kappa, along), gamma)[1]
    if not _one_way_at_middle(ux, uy, most, t):
        return False
    for j in range(t.shape[0]):
        g = add(scale(ux, get(t, j, MID_GX)), scale(uy, get(t, j, MID_GY)))[0]
        g = below(g - gradient_reach(t, j, ux, uy, rx, ry))
        if g >= 0.0:
            g = below(g / t[j, BETA, 1])
        elif t[j, BETA, 0] > 0.0:
            g = below(g / t[j, BETA, 0])
        else:
            return False
        most = above(most - below(world.exponents[j] * g))
    return most < 0.0


@njit(cache=True, nogil=True)
def _one_way_at_middle(ux: float, uy: float, most: float, t: FloatArray) -> bool:
    """Whether `_one_way` may succeed, from the gradients at the middle."""
    for j in range(t.shape[0]):
        g = ux * t[j, MID_GX, 0] + uy * t[j, MID_GY, 0]
        if g < 0.0 and not t[j, BETA, 0] > 0.0:
            return False
        most -= t[j, WEIGHT, 0] * g
    return most < 0.0


@njit(cache=True, nogil=True)
def hessian(
    px: Interval, py: Interval, gamma: Interval, world: World, t: FloatArray
) -> tuple[Interval, Interval, Interval]:
    """Hessian of psi over a box on which every beta_j > 0, off the goal."""
    gg = square(gamma)
    k = 2.0 * world.kappa
    hxx = divide(scale(k, subtract(square(py), square(px))), gg)
    hxy = divide(scale(-2.0 * k, multiply(px, py)), gg)
    hyy = (-hxx[1], -hxx[0])  # ln gamma is harmonic
    for j in range(t.shape[0]):
        w = world.exponents[j]
        b = get(t, j, BETA)
        sx = divide(get(t, j, GX), b)
        sy = divide(get(t, j, GY), b)
        hxx = add(hxx, scale(w, subtract(square(sx), divide(get(t, j, HXX), b))))
        hxy = add(hxy, scale(w, subtract(multiply(sx, sy), divide(get(t, j, HXY), b))))
        hyy = add(hyy, scale(w, subtract(square(sy), divide(get(t, j, HYY), b))))
    return hxx, hxy, hyy


@njit(cache=True, nogil=True)
def _no_root(
    fx: Interval,
    fy: Interval,
    hxx: Interval,
    hxy: Interval,
    hyy: Interval,
    rx: float,
    ry: float,
) -> bool:
    ux = middle(fx)
    uy = middle(fy)
    along = add(scale(ux, fx), scale(uy, fy))
    cx = add(scale(ux, hxx), scale(uy, hxy))
    cy = add(scale(ux, hxy), scale(uy, hyy))
    if below(along[0] - reach(cx, rx, cy, ry)) > 0.0:
        return True
    ok, nx, ny, sx, sy = newton_image(fx, fy, hxx, hxy, hyy, rx, ry)
    return ok and (
        nx[0] - sx > rx or nx[1] + sx < -rx or ny[0] - sy > ry or ny[1] + sy < -ry
    )


@njit(cache=True, nogil=True)
def newton_image(
    fx: Interval,
    fy: Interval,
    hxx: Interval,
    hxy: Interval,
    hyy: Interval,
    rx: float,
    ry: float,
) -> tuple[bool, Interval, Interval, float, float]:
    """Krawczyk's operator on a box, about its middle m.

    With C about the inverse of the Hessian, every root of F in the box is one of
    K = m - C F(m) + (I - C H(box)) (box - m), and if K lies in the box's interior
    there is exactly one (Krawczyk 1969). Returned are whether C could be made, the
    interval -C F(m), and the half widths of the rest, rounded up with a reserve for
    the one addition that is left to do.
    """
    a = middle(hxx)
    b = middle(hxy)
    c = middle(hyy)
    determinant = a * c - b * b
    # Nearly singular beyond use, and its inverse must not overflow.
    if not abs(determinant) > 1e-30 * max(abs(a), abs(c)) ** 2:
        return False, fx, fy, 0.0, 0.0
    cxx = c / determinant
    cxy = -b / determinant
    cyy = a / determinant
    nx = add(scale(-cxx, fx), scale(-cxy, fy))
    ny = add(scale(-cxy, fx), scale(-cyy, fy))
    one = point(1.0)
    axx = subtract(one, add(scale(cxx, hxx), scale(cxy, hxy)))
    axy = add(scale(cxx, hxy), scale(cxy, hyy))
    ayx = add(scale(cxy, hxx), scale(cyy, hxy))
    ayy = subtract(one, add(scale(cxy, hxy), scale(cyy, hyy)))
    sx = reach(axx, rx, axy, ry)
    sy = reach(ayx, rx, ayy, ry)
    sx = above(sx + 1e-15 * (sx + magnitude(nx)))
    sy = above(sy + 1e-15 * (sy + magnitude(ny)))
    return True, nx, ny, sx, sy


@njit(cache=True, nogil=True)
def _strict_saddle(
    px: Interval,
    py: Interval,
    gamma: Interval,
    hxx: Interval,
    hxy: Interval,
    hyy: Interval,
    world: World,
    t: FloatArray,
) -> bool:
    a = middle(hxx)
    b = middle(hxy)
    c = middle(hyy)
    turn = 0.5 * math.atan2(2.0 * b, a - c) + 0.5 * math.pi
    ux = math.cos(turn)  # about the eigenvector of the lower eigenvalue
    uy = math.sin(turn)
    if not a * ux * ux + 2.0 * b * ux * uy + c * uy * uy < 0.0:
        return False
    # u . H u term by term is sharper than from the entries of H.
    along = add(scale(ux, px), scale(uy, py))
    across = subtract(scale(ux, py), scale(uy, px))
    most = divide(
        scale(2.0 * world.kappa, subtract(square(across), square(along))),
        square(gamma),
    )[1]
    xx = square(point(ux))
    xy = double(multiply(point(ux), point(uy)))
    yy = square(point(uy))
    for j in range(t.shape[0]):
        beta = get(t, j, BETA)
        slope = add(scale(ux, get(t, j, GX)), scale(uy, get(t, j, GY)))
        bend = add(
            add(multiply(xx, get(t, j, HXX)), multiply(yy, get(t, j, HYY))),
            multiply(xy, get(t, j, HXY)),
        )
        part = subtract(square(divide(slope, beta)), divide(bend, beta))
        most = above(most + above(world.exponents[j] * part[1]))
    return most < 0.0
