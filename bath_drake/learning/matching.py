"""First guesses by the flow's direction: the obstacle that helps most, one by one.

Along a stroke the flow must point along it, and beside it lead gently back. Both
are wishes about directions at fixed points, to which every obstacle adds its share:
greedy choice among random candidates needs no roll-out, and settles at once on which
side of the stroke each obstacle must stand.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.learning import _matching, genome
from bath_drake.learning.cost import LearningProblem
from bath_drake.learning.strokes import resample
from bath_drake.notation import FloatArray

_POINTS = 48
_OFFSET = 0.04  # beside the stroke, in N
_RETURN = 0.3  # length, in N, over which the flow there is wished to lead back
CANDIDATES = 48
"""How many to choose from."""


@dataclass(frozen=True, eq=False)
class Wishes:
    """Where the flow should point.

    Attributes:
        points: Shape (T, 2), on the mean stroke and on both sides of it.
        directions: Unit vectors, shape (T, 2).
        weights: Shape (T,), of sum one.
        along: Where each point is along the stroke, 0 to 1, shape (T,).
    """

    points: FloatArray
    directions: FloatArray
    weights: FloatArray
    along: FloatArray


def wishes(curve: FloatArray) -> Wishes:
    """Directions along a curve (n, 2) and beside it, all but at its end."""
    along = resample(curve, _POINTS + 1)
    tangents = np.gradient(along, axis=0)[:-1]
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True) + 1e-12
    normals = np.stack([-tangents[:, 1], tangents[:, 0]], axis=-1)
    points, directions, weights = [], [], []
    for side, weight in ((0.0, 1.0), (1.0, 0.3), (-1.0, 0.3)):
        wished = tangents - side * _OFFSET / _RETURN * normals
        points.append(along[:-1] + side * _OFFSET * normals)
        directions.append(wished / np.linalg.norm(wished, axis=1, keepdims=True))
        weights.append(np.full(_POINTS, weight))
    shares = np.concatenate(weights)
    return Wishes(
        np.concatenate(points),
        np.concatenate(directions),
        shares / shares.sum(),
        np.tile(np.arange(_POINTS) / _POINTS, 3),
    )


class Matcher:
    """Adds obstacles to members so that the flow's direction fits best."""

    def __init__(self, problem: LearningProblem) -> None:
        self._wishes = wishes(problem.strokes.mean)
        points, workspace = self._wishes.points, problem.workspace
        away = points - problem.strokes.goal
        self._gamma = (away**2).sum(axis=1)
        self._pulls = np.ascontiguousarray(-2.0 * away)
        u = (points - workspace.centre) / workspace.semi_axes
        beta = np.maximum(workspace.beta(points), 1e-2)[:, None]
        power = workspace.power
        slope = -power * np.sign(u) * np.abs(u) ** (power - 1) / workspace.semi_axes
        self._rim = self._gamma[:, None] * slope / beta
        self._gap = problem.margins.pair
        self._least = problem.margins.kappa

    def complete(
        self, rows: FloatArray, count: int, candidates: FloatArray
    ) -> tuple[FloatArray, float]:
        """Obstacles (count, 5) and kappa: ``rows`` (n, 5) and the best to add.

        Args:
            rows: Obstacles that stay: centre, ln a, ln b, angle.
            count: How many there shall be.
            candidates: Those to choose from, shape (count - n, M, 5): M at a time.
        """
        kappa = max(1.0, self._least * count)
        for choice in candidates:
            costs, kappas = self.rate(rows, choice, count)
            best = int(np.argmin(costs))
            rows = np.concatenate([rows, choice[best : best + 1]])
            kappa = float(kappas[best])
        return rows, kappa

    def rate(
        self,
        rows: FloatArray,
        choice: FloatArray,
        count: int | None = None,
        begin: float = 0.0,
    ) -> tuple[FloatArray, FloatArray]:
        """Mismatch (M,) of the flow with each of ``choice`` (M, 5) beside ``rows``.

        Returns the best kappas, shape (M,), too; they suit ``count`` obstacles, if
        it is given, or else one more than ``rows``. Only what lies behind the share
        ``begin`` of the stroke counts.
        """
        count = len(rows) + 1 if count is None else count
        kappas = max(1.0, self._least * count) * np.geomspace(1.0, 6.0, 6)
        costs = _matching.mismatches(
            self._rim + self._shares(rows).sum(axis=0),
            self._pulls,
            self._shares(choice),
            kappas,
            self._wishes.directions,
            np.where(self._wishes.along >= begin, self._wishes.weights, 0.0),
        )
        best = costs.argmin(axis=1)
        least = costs[np.arange(len(choice)), best]
        return least + 0.3 * self._overlaps(rows, choice), kappas[best]

    def _shares(self, rows: FloatArray) -> FloatArray:
        theta = np.array(rows, dtype=np.float64).reshape(-1, genome.GENES)
        theta[:, 2:4] = np.exp(theta[:, 2:4])
        pushed = _matching.pushes(theta, self._wishes.points)
        return np.asarray(self._gamma[:, None] * pushed)

    def _overlaps(self, rows: FloatArray, choice: FloatArray) -> FloatArray:
        """How deep each candidate's circle is in those of the others, shape (M,)."""
        if len(rows) == 0:
            return np.zeros(len(choice))
        apart = np.linalg.norm(choice[:, None, :2] - rows[None, :, :2], axis=-1)
        radii = [np.exp(0.5 * (r[:, 2] + r[:, 3])) for r in (choice, rows)]
        room = apart - radii[0][:, None] - radii[1] - self._gap
        lack: FloatArray = np.maximum(0.0, -room).sum(axis=1)
        return lack
