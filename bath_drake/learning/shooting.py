"""Multiple shooting: many short roll-outs instead of one long one.

The Fréchet distance of a whole roll-out says little about which obstacle to move:
one wrong turn decides everything behind it. Here roll-outs start all along the
demonstrations and run for a window only; their distances under the best monotone
coupling are minimised by Levenberg-Marquardt, and the windows grow until they are
whole strokes. The roll-outs' derivatives are exact forward sensitivities.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.learning import _coupling, _kernels, _sensitivities, genome
from bath_drake.learning.cost import LearningProblem
from bath_drake.notation import FloatArray, IntArray

_DIFFERENCE = 1e-6
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
    cost, _, _ = _couple(_shoot(xs, problem, windows), windows, power)
    return np.asarray(cost + 0.5 * mu * (problem.lacks(xs) ** 2).sum(axis=1))


def _shoot(xs: FloatArray, problem: LearningProblem, windows: Windows) -> FloatArray:
    return np.asarray(
        _kernels.shoot(
            xs,
            np.ascontiguousarray(windows.targets[:, 0]),
            windows.steps,
            windows.counts,
            int(windows.counts.max()),
            problem.workspace.as_array(),
            problem.strokes.goal.copy(),
            _FLOOR,
        )
    )


def _couple(
    paths: FloatArray, windows: Windows, power: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    cost, weight, pull = _coupling.coupling(
        paths,
        windows.counts,
        windows.targets,
        windows.lengths,
        windows.weights,
        power,
    )
    return cost, weight, pull


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
    scale = genome.scales(genome.obstacle_count(x))
    x = genome.clip(x, problem.workspace)
    damping = 1e-2
    slow = 0
    evaluations = 1
    cost = float(shooting_cost(x[None], problem, windows, power, mu)[0])
    for _ in range(iterations):
        matrix, gradient = _normal_equations(x, problem, windows, power, mu)
        diagonal = np.diag(matrix) + 1e-9 / scale**2
        trials = damping * np.array([0.1, 3.0, 100.0])
        steps = []
        for lam in trials:
            damped = matrix + np.diag(lam * diagonal + 1e-12 / scale**2)
            d = -np.linalg.solve(damped, gradient)
            steps.append(d / max(1.0, float(np.abs(d / scale).max())))
        candidates = genome.clip(x + np.array(steps), problem.workspace)
        costs = shooting_cost(candidates, problem, windows, power, mu)
        evaluations += 1 + len(candidates)
        best = int(np.argmin(costs))
        if not costs[best] < cost:
            if damping > 1e6:
                break
            damping *= 1e3
            continue
        slow = slow + 1 if cost - costs[best] < 1e-3 * cost else 0
        x, cost = candidates[best], float(costs[best])
        damping = float(np.clip(trials[best], 1e-7, 1e6))
        if slow >= 3:
            break
    return x, cost, evaluations


def _normal_equations(
    x: FloatArray, problem: LearningProblem, windows: Windows, power: float, mu: float
) -> tuple[FloatArray, FloatArray]:
    """J^T J and J^T r of the held coupling and the hinges."""
    _, weight, pull = _couple(_shoot(x[None], problem, windows), windows, power)
    matrix, gradient = _sensitivities.normal_equations(
        x,
        np.ascontiguousarray(windows.targets[:, 0]),
        windows.steps,
        windows.counts,
        problem.workspace.as_array(),
        problem.strokes.goal.copy(),
        _FLOOR,
        weight[0],
        pull[0],
    )
    # The hinges are cheap: differences will do.
    lacks = problem.lacks(np.concatenate([x[None], x + _DIFFERENCE * np.eye(len(x))]))
    rows = (lacks[1:] - lacks[0]) / _DIFFERENCE
    return matrix + mu * rows @ rows.T, gradient + mu * rows @ lacks[0]
