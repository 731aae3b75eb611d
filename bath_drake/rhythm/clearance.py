"""How far a point may be moved in any direction and stay out of trouble.

Every bound is one from below: a disc of this radius round the point meets neither an
obstacle nor the rim, whatever rounding and stopped iterations have done.
"""

import math

from numba import njit

from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import FloatArray

# Newton steps towards the nearest point of an ellipse. The bound holds after any
# number of them and is tight to 1e-6 after these.
_STEPS = 12
# Sums of a few products of numbers up to about ten are right to this.
_ROUNDING = 1e-12


def clearance(
    q: FloatArray, obstacles: ObstacleSet, workspace: Workspace, half_box: float
) -> float:
    """A bound from below of the distance from `q` to what must not be entered.

    Args:
        q: Shape (2,), in N.
        obstacles: Restricted areas, shape (Q, 5).
        workspace: Its rim must not be crossed.
        half_box: Half the side of the square round N's origin that must not be left:
            1 for the body's box, infinite for none.

    Returns:
        The radius of a free disc round `q`, in N; 0 in an obstacle or outside, and
        for a `q` that is not finite.
    """
    return float(
        _clearance(
            float(q[0]), float(q[1]), obstacles.theta, workspace.as_array(), half_box
        )
    )


@njit(cache=True)
def _clearance(
    x: float, y: float, theta: FloatArray, workspace: FloatArray, half_box: float
) -> float:
    if not math.isfinite(x + y):
        return 0.0
    least = min(half_box - max(abs(x), abs(y)), _to_rim(x, y, workspace))
    for i in range(theta.shape[0]):
        dx, dy = x - theta[i, 0], y - theta[i, 1]
        c, s = math.cos(theta[i, 4]), math.sin(theta[i, 4])
        u, v = abs(c * dx + s * dy), abs(c * dy - s * dx)
        least = min(least, _to_ellipse(u, v, theta[i, 2], theta[i, 3]))
    return max(least - _ROUNDING, 0.0)


@njit(cache=True)
def _to_rim(x: float, y: float, workspace: FloatArray) -> float:
    """For p >= 2 the superellipse's gauge grows by 1 / min(a, b) a unit at most."""
    a, b, power = workspace[2], workspace[3], workspace[4]
    u, v = abs(x - workspace[0]) / a, abs(y - workspace[1]) / b
    large = max(u, v)
    if large == 0.0:
        return float(min(a, b))
    # Scaled, so that the powers stay finite.
    gauge = large * ((u / large) ** power + (v / large) ** power) ** (1.0 / power)
    return float((1.0 - gauge) * min(a, b))


@njit(cache=True)
def _to_ellipse(u: float, v: float, a: float, b: float) -> float:
    """From (u, v) in the ellipse's own axes, both not negative.

    The ellipse lies on one side of each of its tangents: for every unit vector n the
    distance is at least n . p less the ellipse's support h(n), and equal for the best.
    With n at the angle t, g(t) = n . p - h has g'' = -(g + rho), rho = a^2 b^2 / h^3.
    """
    if not math.hypot(u / a, v / b) > 1.0:
        return 0.0
    angle = math.atan2(v * a * a, u * b * b)
    best = 0.0
    for _ in range(_STEPS):
        c, s = math.cos(angle), math.sin(angle)
        h = math.hypot(a * c, b * s)
        bound = u * c + v * s - h
        best = max(best, bound)
        slope = v * c - u * s - (b * b - a * a) * s * c / h
        bend = bound + a * a * b * b / (h * h * h)
        if not bend > 0.0 or abs(slope) < 1e-12:
            break
        angle = min(max(angle + slope / bend, 0.0), 0.5 * math.pi)
    return best
