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
    """

    points: FloatArray
    directions: FloatArray
    weights: FloatArray


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
        np.concatenate(points), np.concatenate(directions), shares / shares.sum()
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
        kappas = max(1.0, self._least * count) * np.geomspace(1.0, 6.0, 6)
        base = self._rim + self._shares(rows).sum(axis=0)
        kappa = float(kappas[0])
        for choice in candidates:
            added = self._shares(choice)
            costs = _matching.mismatches(
                base,
                self._pulls,
                added,
                kappas,
                self._wishes.directions,
                self._wishes.weights,
            )
            costs += 0.3 * self._overlaps(rows, choice)[:, None]
            best, k = np.unravel_index(int(np.argmin(costs)), costs.shape)
            rows = np.concatenate([rows, choice[best : best + 1]])
            base = base + added[best]
            kappa = float(kappas[k])
        return rows, kappa

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
