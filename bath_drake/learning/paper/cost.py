"""The paper's cost C of obstacles, by the paper's own roll-outs (Sec. III-C).

A member of the paper's population is a vector of four genes an obstacle, the centre and
the lengths of the principal axes: (centre x, centre y, semi-axis along x, along y), in
units of N. The paper has no angle among its unknowns, and none is here.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.learning.cost import GOAL_TOLERANCE, LearningProblem
from bath_drake.learning.paper import _euler
from bath_drake.notation import FloatArray, IntArray
from bath_drake.threads import parallel_map, split

GENES = 4


@dataclass(frozen=True, eq=False)
class EulerRollout:
    """One Euler roll-out.

    Attributes:
        path: Shape (n, 2), in N.
        arrived: Whether it ends at the goal.
        entries: How often a step led out of free space, or over an obstacle.
    """

    path: FloatArray
    arrived: bool
    entries: int


@dataclass(frozen=True, eq=False)
class EulerCosts:
    """Costs of n members.

    Attributes:
        distances: Fréchet distance of the roll-out to each demonstration, (n, D).
        arrived: Share of those roll-outs that reach the goal, (n,).
        entries: How often they leave free space, all together, (n,).
    """

    distances: FloatArray
    arrived: FloatArray
    entries: IntArray

    @property
    def total(self) -> FloatArray:
        """C, the mean Fréchet distance over the demonstrations, shape (n,)."""
        return np.asarray(self.distances.mean(axis=1))


def euler_rollout(
    start: ArrayLike, field: NavigationField, *, dt: float = 0.02, max_steps: int = 1000
) -> EulerRollout:
    """Steps q <- q + dt u, u the unit vector along -grad phi, wherever they lead.

    The last steps are as short as the way that is left to the goal. `field.rollout` is
    what keeps out of obstacles; this is what the paper writes.
    """
    x, y = np.asarray(start, dtype=np.float64).tolist()
    path = np.empty((max_steps + 1, 2))
    length, arrived, entries = _euler.euler_path(
        x, y, *field.kernel_arguments, dt, GOAL_TOLERANCE, path
    )
    return EulerRollout(path[:length].copy(), arrived, entries)


def evaluate(
    xs: FloatArray, problem: LearningProblem, kappa: float, dt: float
) -> EulerCosts:
    """Rolls members (n, 4 Q) out from every demonstration's start."""
    xs = np.ascontiguousarray(xs, dtype=np.float64)
    max_steps = int((1.5 * problem.strokes.length + 1.0) / dt)

    def evaluate_part(part: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
        found: tuple[FloatArray, FloatArray, IntArray] = _euler.euler_costs(
            part,
            problem.strokes.points,
            problem.workspace.as_array(),
            problem.strokes.goal.copy(),
            kappa,
            dt,
            GOAL_TOLERANCE,
            max_steps,
        )
        return found

    parts = parallel_map(evaluate_part, split(xs))
    return EulerCosts(*map(np.concatenate, zip(*parts, strict=True)))


def decode(x: FloatArray, problem: LearningProblem, kappa: float) -> NavigationField:
    """The field of a member (4 Q,)."""
    rows = x.reshape(-1, GENES)
    theta = np.column_stack([rows, np.zeros(len(rows))])
    # The longer axis comes first, everywhere else.
    swap = theta[:, 2] < theta[:, 3]
    theta[swap, 2:4] = theta[swap, 3:1:-1]
    theta[swap, 4] = 0.5 * np.pi
    goal = problem.strokes.goal
    return NavigationField(problem.workspace, goal, kappa, ObstacleSet(theta))


def encode(obstacles: ObstacleSet) -> FloatArray:
    """The member (4 Q,) that spans what each obstacle spans along x and along y.

    An ellipse along the axes is kept as it is; another has no place in a member.
    """
    a, b, angle = obstacles.theta[:, 2:].T
    c, s = np.cos(angle), np.sin(angle)
    spans = np.stack([np.hypot(a * c, b * s), np.hypot(a * s, b * c)], axis=-1)
    return np.column_stack([obstacles.theta[:, :2], spans]).ravel()
