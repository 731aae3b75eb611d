"""Multiple shooting: many short roll-outs instead of one long one.

The Fréchet distance of a whole roll-out says little about which obstacle to move:
one wrong turn decides everything behind it. Here roll-outs start all along the
demonstrations and run for a window only; their distances under the best monotone
coupling are minimised by Levenberg-Marquardt, and the windows grow until they are
whole strokes. The roll-outs' derivatives are exact forward sensitivities.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from bath_drake.learning import _fitting, _hinges, genome
from bath_drake.learning.cost import LearningProblem
from bath_drake.notation import FloatArray, IntArray

# Smaller beta_i are held at this while shooting: windows may then start within an
# obstacle that the hinges are about to push away.
_FLOOR = 0.004


@dataclass(frozen=True, eq=False)
class Windows:
    """Stretches of the demonstrations to be reproduced.

    Attributes:
        targets: Shape (W, T, 2), padded behind ``lengths``.
        lengths: Points in each target, shape (W,).
        steps: Arc length of a step in each, shape (W,).
        counts: Steps of each roll-out, shape (W,).
        weights: Their share in the cost, shape (W,).
    """

    targets: FloatArray
    lengths: IntArray
    steps: FloatArray
    counts: IntArray
    weights: FloatArray

    @cached_property
    def cut(self) -> tuple[Any, ...]:
        """As the compiled descent takes them."""
        return (
            np.ascontiguousarray(self.targets[:, 0]),
            np.ascontiguousarray(self.targets),
            self.lengths,
            self.steps,
            self.counts,
            self.weights,
        )

    def __add__(self, other: "Windows") -> "Windows":
        long = max(self.targets.shape[1], other.targets.shape[1])

        def padded(w: Windows) -> FloatArray:
            room = ((0, 0), (0, long - w.targets.shape[1]), (0, 0))
            return np.pad(w.targets, room)

        return Windows(
            np.concatenate([padded(self), padded(other)]),
            np.concatenate([self.lengths, other.lengths]),
            np.concatenate([self.steps, other.steps]),
            np.concatenate([self.counts, other.counts]),
            np.concatenate([self.weights, other.weights]),
        )


def cut_windows(
    demonstrations: FloatArray, horizon: int, stride: int, weight: float = 1.0
) -> Windows:
    """Windows of ``horizon`` steps every ``stride`` points of strokes (D, T, 2)."""
    count = demonstrations.shape[1]
    targets, lengths, steps = [], [], []
    for curve in demonstrations:
        spacing = float(np.linalg.norm(np.diff(curve, axis=0), axis=1).mean())
        for i in range(0, count - 2, stride):
            piece = curve[i : i + horizon + 1]
            room = horizon + 1 - len(piece)
            targets.append(np.pad(piece, ((0, room), (0, 0))))
            lengths.append(len(piece))
            steps.append(spacing)
    n = len(targets)
    sizes = np.array(lengths, dtype=np.int64)
    shares = np.full(n, weight / n)
    return Windows(np.stack(targets), sizes, np.array(steps), sizes - 1, shares)


def whole_strokes(demonstrations: FloatArray, weight: float = 1.0) -> Windows:
    """Each stroke (D, T, 2) as one window, with a fifth more steps to arrive in."""
    w = cut_windows(
        demonstrations, demonstrations.shape[1], demonstrations.shape[1], weight
    )
    return Windows(w.targets, w.lengths, w.steps, (w.lengths * 6) // 5, w.weights)


def shooting_cost(
    xs: FloatArray, problem: LearningProblem, windows: Windows, power: float, mu: float
) -> FloatArray:
    """Window cost plus mu / 2 times the squared hinges, for members (n, P): (n,)."""
    xs = np.ascontiguousarray(xs, dtype=np.float64)
    found = _fitting.costs(xs, windows.cut, _world(problem), power, mu)
    return np.asarray(found)


def _world(problem: LearningProblem) -> tuple[Any, ...]:
    return (
        problem.workspace.as_array(),
        problem.strokes.goal.copy(),
        _FLOOR,
        problem.clear_points,
        problem.margins.as_array(),
    )


def fit(
    x: FloatArray,
    problem: LearningProblem,
    windows: Windows,
    *,
    power: float = 2.0,
    mu: float = 100.0,
    iterations: int = 30,
) -> tuple[FloatArray, float, int]:
    """Levenberg-Marquardt on the windows' cost from x (P,).

    Returns x, its cost, and how many members' roll-outs that took.

    Each iteration holds the coupling, linearises the roll-outs, and
    tries several dampings in one batch.
    """
    found, cost, evaluations = _fitting.fit(
        np.ascontiguousarray(x, dtype=np.float64),
        windows.cut,
        _world(problem),
        power,
        mu,
        genome.scales(genome.obstacle_count(x)),
        genome.limits(problem.workspace),
        iterations,
    )
    return found, float(cost), int(evaluations)


def linearise(
    x: FloatArray, problem: LearningProblem, windows: Windows, power: float, mu: float
) -> tuple[float, FloatArray, FloatArray]:
    """The cost at x (P,), and J^T J (P, P) and J^T r (P,), its gradient."""
    x = np.ascontiguousarray(x, dtype=np.float64)
    cost, matrix, gradient = _fitting.linearise(
        x, windows.cut, _world(problem), power, mu
    )
    return float(cost), matrix, gradient


def hinge_slopes(x: FloatArray, problem: LearningProblem) -> FloatArray:
    """Derivatives (H, P) of `LearningProblem.lacks` at x (P,), where they lack."""
    workspace, goal, _, points, margins = _world(problem)
    rows = np.zeros((len(problem.lacks(x[None])[0]), _hinges.HINGE))
    forms = _hinges.member_forms(x)
    _hinges.member_hinges(x, forms, points, workspace, goal, margins, rows)
    return np.array([_hinges.dense(row, len(x)) for row in rows])
