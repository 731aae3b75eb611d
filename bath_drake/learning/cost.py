"""The cost of a candidate: C(theta) and what keeps it valid (paper, Sec. III-C)."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from bath_drake.field.obstacles import Workspace
from bath_drake.learning import _hinges, _kernels
from bath_drake.learning.strokes import StrokeSet
from bath_drake.notation import FloatArray
from bath_drake.threads import parallel_map, split

GOAL_TOLERANCE = 2e-3


@dataclass(frozen=True)
class ValidityMargins:
    """Distances, in N, that keep a field a navigation function in practice.

    A field whose obstacles overlap, touch the rim or the goal, or look too flat
    from the goal has spurious minima. Each margin is a hinge: nothing is paid
    beyond it.
    """

    pair: float = 0.04
    """Gap between two obstacles."""
    rim: float = 0.04
    """Gap between an obstacle and the workspace's boundary."""
    demonstration: float = 0.02
    """Gap between an obstacle and the demonstrations."""
    goal: float = 0.05
    """Gap between an obstacle and the goal."""
    kappa: float = 0.8
    """Least kappa, per obstacle."""
    curvature: float = 0.1
    """Least `curvature_margin` (how round an obstacle looks from the goal)."""

    def as_array(self) -> FloatArray:
        """In the kernels' order, shape (6,)."""
        values = (self.pair, self.rim, self.demonstration, self.goal)
        return np.array([*values, self.kappa, self.curvature])


@dataclass(frozen=True, eq=False)
class PopulationCosts:
    """Costs of n members.

    Attributes:
        distances: Fréchet distance of the roll-out to each demonstration, (n, D).
        arrived: Share of those roll-outs that reach the goal, (n,).
        reached: Share of the grid's free starts that reach the goal, (n,).
        lacks: Validity hinges, (n, H), zero where nothing is lacking.
    """

    distances: FloatArray
    arrived: FloatArray
    reached: FloatArray
    lacks: FloatArray

    @property
    def demonstration_cost(self) -> FloatArray:
        """C, the mean Fréchet distance over the demonstrations, shape (n,)."""
        return np.asarray(self.distances.mean(axis=1))

    @property
    def total(self) -> FloatArray:
        """C with the penalties, shape (n,)."""
        # One trapped start of a grid of 36 weighs like 0.008 of Fréchet distance;
        # a hinge by its size, so that a gap is never closed to gain as much.
        lost = 0.3 * (1.0 - self.reached) + 0.3 * (1.0 - self.arrived)
        return np.asarray(self.demonstration_cost + lost + self.lacks.sum(axis=1))


@dataclass(frozen=True, eq=False)
class LearningProblem:
    """Strokes and the world they are learned in."""

    strokes: StrokeSet
    workspace: Workspace
    margins: ValidityMargins
    step: float = 0.02
    """Arc length of the roll-outs' steps."""
    grid: int = 6
    """Starts per side of the grid that must arrive."""
    clear: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    """Further points that obstacles must leave free, shape (n, 2)."""

    @cached_property
    def _grid_points(self) -> FloatArray:
        # The canonical box and a little more, as far as it is inside the rim.
        t = np.linspace(-1.1, 1.1, self.grid)
        x, y = np.meshgrid(t, t)
        points = np.stack([x.ravel(), y.ravel()], axis=-1)
        inside = self.workspace.beta(points) > 0.05
        return np.asarray(points[inside])

    @cached_property
    def clear_points(self) -> FloatArray:
        """Points that obstacles must leave free, shape (n, 2)."""
        strokes = self.strokes.points[:, ::3].reshape(-1, 2)
        return np.concatenate([strokes, self.clear])

    @property
    def max_steps(self) -> int:
        """Steps a roll-out may take: twice the stroke and a way across the box."""
        return int((2.0 * self.strokes.length + 3.0) / self.step)

    def lacks(self, xs: FloatArray) -> FloatArray:
        """Validity hinges of members (n, P), shape (n, H)."""
        return np.asarray(
            _hinges.hinges(
                xs,
                self.clear_points,
                self.workspace.as_array(),
                self.strokes.goal.copy(),
                self.margins.as_array(),
            )
        )

    def evaluate(self, xs: FloatArray, *, grid: bool = True) -> PopulationCosts:
        """Rolls members (n, P) out from every demonstration's start to the goal.

        Without ``grid`` no other start is tried, and ``reached`` is one.
        """
        xs = np.ascontiguousarray(xs, dtype=np.float64)
        starts = self._grid_points if grid else np.empty((0, 2))
        workspace = self.workspace.as_array()

        def evaluate_part(part: FloatArray) -> tuple[FloatArray, ...]:
            return _kernels.whole_costs(
                part,
                self.strokes.points,
                starts,
                workspace,
                self.strokes.goal.copy(),
                self.step,
                GOAL_TOLERANCE,
                self.max_steps,
            )

        parts = parallel_map(evaluate_part, split(xs))
        distances, arrived, reached = map(np.concatenate, zip(*parts, strict=True))
        return PopulationCosts(distances, arrived, reached, self.lacks(xs))
