"""Families of worlds in which a minimum is born, and the parameter where it is.

A fold (saddle-node) is where grad psi = 0 and det H = 0. With t the Hessian's stiff
and n its flat direction, (grad psi . t, det H) = 0 has a regular root near the fold for
every parameter, and grad psi . n at that root changes its sign exactly where two
critical points meet and vanish. Bisection on this sign ends at neighbouring doubles.
"""

from dataclasses import dataclass

import numpy as np
from basins import grad_hessian

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace

_DISC = Workspace(np.zeros(2), np.array([5.0, 5.0]))
_GOAL = np.array([3.0, 0.0])


def tilted(b: float) -> NavigationField:
    """One ellipse off the axis: a saddle and a minimum are born as b grows."""
    rows = np.array([[-0.5, 0.4, 0.5, b, 0.0]])
    return NavigationField(_DISC, _GOAL, 10.0, ObstacleSet(rows))


def tilted_by_kappa(kappa: float) -> NavigationField:
    """The same obstacle, the exponent of the attraction tuned instead."""
    rows = np.array([[-0.5, 0.4, 0.5, 1.8, 0.0]])
    return NavigationField(_DISC, _GOAL, kappa, ObstacleSet(rows))


def broadside(b: float) -> NavigationField:
    """Symmetric: the saddle behind the ellipse turns into a minimum (a pitchfork)."""
    rows = np.array([[-0.5, 0.0, 0.5, b, 0.0]])
    return NavigationField(_DISC, _GOAL, 10.0, ObstacleSet(rows))


@dataclass(frozen=True)
class Birth:
    """Neighbouring doubles between which the minimum is born, and where it is."""

    below: float
    above: float
    x: float
    y: float


def _frame(hessian):
    """Unit vectors of the stiff and the flat direction."""
    angle = 0.5 * np.arctan2(2 * hessian[0, 1], hessian[0, 0] - hessian[1, 1])
    stiff = np.array([np.cos(angle), np.sin(angle)])
    return stiff, np.array([-stiff[1], stiff[0]])


def _det(q, field):
    h = grad_hessian(q, field)[1]
    return h[0, 0] * h[1, 1] - h[0, 1] ** 2


def flat_point(field: NavigationField, guess):
    """Where grad psi . t and det H vanish, and grad psi . n there."""
    q = np.array(guess, dtype=np.longdouble)
    e = np.longdouble(1e-5) * np.eye(2)  # differences of det H: good to 1e-10
    stiff, flat = _frame(grad_hessian(q, field)[1])
    for _ in range(60):
        gradient, hessian = grad_hessian(q, field)
        slope = [(_det(q + s, field) - _det(q - s, field)) / 2e-5 for s in e]
        a, b = hessian @ stiff
        c, d = slope
        r0, r1 = gradient @ stiff, _det(q, field)
        det = a * d - b * c
        step = np.array([b * r1 - d * r0, c * r0 - a * r1]) / det
        q = q + step * min(1, 0.2 / np.hypot(*step))
        if np.hypot(*step) < 1e-18:
            break
    return q, grad_hessian(q, field)[0] @ flat


def fold(build, low: float, high: float, guess) -> Birth:
    """The two neighbouring doubles between which critical points meet."""
    q, first = flat_point(build(low), guess)
    if first * flat_point(build(high), q)[1] >= 0:
        raise ValueError("no fold between the two parameters")
    while low < (middle := 0.5 * (low + high)) < high:
        q, sign = flat_point(build(middle), q)
        low, high = (middle, high) if sign * first > 0 else (low, middle)
    return Birth(low, high, float(q[0]), float(q[1]))


def pitchfork(build, low: float, high: float, guess: float) -> Birth:
    """The same for a symmetric family, whose critical point stays on y = 0."""
    x = np.longdouble(guess)
    while low < (middle := 0.5 * (low + high)) < high:
        for _ in range(60):
            gradient, hessian = grad_hessian([x, 0], build(middle))
            step = -gradient[0] / hessian[0, 0]
            x += step
            if abs(step) < 1e-18:
                break
        low, high = (low, middle) if hessian[1, 1] > 0 else (middle, high)
    return Birth(low, high, float(x), 0.0)
