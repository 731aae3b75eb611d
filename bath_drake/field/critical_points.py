"""Where the field's gradient vanishes, found by numerical search.

For pictures, seeds and diagnosis. It may overlook a point, so that it proves nothing:
verdicts are the business of `bath_drake.certificate`.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from bath_drake.field import _kernels
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.field.rollout import RolloutStatus, rollout_ends
from bath_drake.notation import FloatArray

Kind = Literal["minimum", "saddle", "maximum", "degenerate"]


@dataclass(frozen=True)
class CriticalPoint:
    """A point other than the goal where grad psi = 0.

    Attributes:
        x: In N.
        y: In N.
        kind: What the Hessian of psi says; 'degenerate' if it is singular to
            working precision.
        eigenvalues: Of that Hessian, the lower one first.
    """

    x: float
    y: float
    kind: Kind
    eigenvalues: tuple[float, float]


def find_critical_points(
    field: NavigationField, *, resolution: int = 48
) -> tuple[CriticalPoint, ...]:
    """Searches free space for the roots of grad psi.

    Newton's method from a grid of ``resolution``^2 points over the workspace, from
    rings around every obstacle, and from where roll-outs get trapped.

    Returns:
        The points found, sorted by x, then y; the goal is not among them.
    """
    starts = np.concatenate([_grid(field, resolution), _rings(field)])
    coarse = _grid(field, max(resolution // 4, 8))
    workspace, _, _, kappa, forms = field.kernel_arguments
    goal = field.goal.copy()
    # Roll-outs are drawn to minima that Newton's narrow basins may miss.
    statuses, ends = rollout_ends(coarse, field, step=float(workspace[2:4].min()) / 50)
    trapped = np.array([s is RolloutStatus.TRAPPED for s in statuses], dtype=bool)
    starts = np.concatenate([starts, ends[trapped]])
    rows = _kernels.newton_points(starts, workspace, goal, kappa, forms, 60)
    return _distinct(rows, 1e-6 * float(workspace[2:4].max()))


def _grid(field: NavigationField, resolution: int) -> FloatArray:
    """Points over the workspace's box, shape ((resolution + 1)^2, 2)."""
    # An odd count puts a row on each axis: Newton's method keeps to an axis of
    # symmetry, and symmetric worlds have critical points on theirs.
    t = (np.arange(resolution + 1) + 0.5) / (resolution + 1) * 2.0 - 1.0
    x, y = np.meshgrid(t, t)
    box = np.stack([x.ravel(), y.ravel()], axis=-1)
    return np.asarray(field.workspace.centre + box * field.workspace.semi_axes)


def _rings(field: NavigationField) -> FloatArray:
    """Points at several distances around every obstacle, shape (n, 2)."""
    obstacles = field.obstacles
    rings = [np.empty((0, 2))]
    for growth in (1.02, 1.1, 1.3, 1.7):
        theta = obstacles.theta * np.array([1.0, 1.0, growth, growth, 1.0])
        rings.append(ObstacleSet(theta).boundary(32).reshape(-1, 2))
    return np.concatenate(rings)


def _distinct(rows: FloatArray, tolerance: float) -> tuple[CriticalPoint, ...]:
    kept: list[FloatArray] = []
    for row in rows[np.lexsort((rows[:, 1], rows[:, 0]))]:
        if all(np.hypot(*(row[:2] - k[:2])) > tolerance for k in kept):
            kept.append(row)
    return tuple(_critical_point(*row.tolist()) for row in kept)


def _critical_point(
    x: float, y: float, hxx: float, hxy: float, hyy: float
) -> CriticalPoint:
    low, high = np.linalg.eigvalsh(np.array([[hxx, hxy], [hxy, hyy]])).tolist()
    return CriticalPoint(x, y, kind_of(low, high), (low, high))


def kind_of(low: float, high: float) -> Kind:
    """What a critical point with these eigenvalues of its Hessian is."""
    # Newton's root is good to 1e-11, so an eigenvalue is to about 1e-9 relative.
    if min(abs(low), abs(high)) < 1e-9 * max(abs(low), abs(high)):
        return "degenerate"
    if low > 0.0:
        return "minimum"
    return "saddle" if high > 0.0 else "maximum"
