"""First populations: obstacles on the inner side of bends, and at random."""

import numpy as np

from bath_drake.learning import genome
from bath_drake.learning.cost import LearningProblem
from bath_drake.learning.strokes import headings
from bath_drake.notation import FloatArray

MAX_OBSTACLES = 12


def obstacle_counts(curve: FloatArray) -> tuple[int, ...]:
    """Numbers of ellipses worth trying for a curve (T, 2), the likeliest first.

    One a bend is the least that can steer a stroke, and few obstacles allow a low
    kappa, which sharp bends near the goal need; every further one can refine it.
    """
    least = len(bends(curve))
    counts = [least, least + 1, least + 2, least + 4] if least else [0, 1, 2, 4]
    return tuple(dict.fromkeys(min(c, MAX_OBSTACLES) for c in counts))


def bends(curve: FloatArray, piece: float = 3.2) -> list[tuple[int, float]]:
    """Bends of a curve (T, 2): indices of their middles and signed turning, rad.

    A long bend is cut into pieces of at most ``piece``; below 0.3 rad is none.
    """
    change = np.diff(headings(curve))
    found: list[tuple[int, float]] = []
    edges = np.flatnonzero(np.diff(np.sign(change)) != 0) + 1
    for part in np.split(np.arange(len(change)), edges):
        total = float(change[part].sum())
        if abs(total) < 0.3:
            continue
        count = int(np.ceil(abs(total) / piece))
        along = np.abs(np.cumsum(change[part])) / abs(total)
        for k in range(count):
            at = int(np.searchsorted(along, (k + 0.5) / count))
            found.append((int(part[min(at, len(part) - 1)]), total / count))
    return found


def seed_population(
    problem: LearningProblem, count: int, size: int, rng: np.random.Generator
) -> FloatArray:
    """``size`` members of ``count`` obstacles, shape (size, 5 count + 1).

    Three quarters have an obstacle on the inner side of each bend, with the rest of
    their obstacles beside random points of the stroke; one quarter is random.
    """
    curve = problem.strokes.mean
    turns = bends(curve)
    found = np.empty((size, genome.GENES * count + 1))
    for n in range(size):
        rows = np.empty((count, genome.GENES))
        seeded = len(turns) if rng.random() < 0.75 else 0
        order = rng.permutation(len(turns))[:seeded]
        for i in range(count):
            if i < len(order):
                at, turn = turns[order[i]]
                at += int(rng.normal(0.0, 0.02 * len(curve)))
                side = np.sign(turn)
            else:
                at = int(rng.integers(2, len(curve) - 2))
                side = rng.choice([-1.0, 1.0])
            rows[i] = _beside(curve, at, side, problem, rng)
        least = np.log(max(1.0, problem.margins.kappa * count))
        found[n, :-1] = rows.ravel()
        found[n, -1] = least + rng.uniform(0.0, 1.5)
    return genome.clip(found, problem.workspace)


def grow(
    x: FloatArray,
    count: int,
    size: int,
    problem: LearningProblem,
    rng: np.random.Generator,
) -> FloatArray:
    """``size`` copies of a member with obstacles added beside the stroke.

    What fewer obstacles have learned is a good first guess for ``count`` of them:
    the shape is (size, 5 count + 1), and no added obstacle is wider than 0.08, so
    that the flow is disturbed in one place only.
    """
    curve = problem.strokes.mean
    missing = count - genome.obstacle_count(x)
    grown = np.empty((size, genome.GENES * count + 1))
    for n in range(size):
        rows = np.empty((missing, genome.GENES))
        for i in range(missing):
            at = int(rng.integers(2, len(curve) - 2))
            rows[i] = _beside(curve, at, rng.choice([-1.0, 1.0]), problem, rng)
        rows[:, 2:4] = np.minimum(rows[:, 2:4], np.log(0.08))
        grown[n] = np.concatenate([x[:-1], rows.ravel(), x[-1:]])
    return genome.clip(grown, problem.workspace)


def _beside(
    curve: FloatArray,
    at: int,
    side: float,
    problem: LearningProblem,
    rng: np.random.Generator,
) -> FloatArray:
    """One ellipse beside a point of the curve, clear of the demonstrations."""
    at = int(np.clip(at, 2, len(curve) - 3))
    tangent = curve[at + 2] - curve[at - 2]
    normal = np.array([-tangent[1], tangent[0]]) / (np.linalg.norm(tangent) + 1e-12)
    centre = curve[at] + side * rng.uniform(0.06, 0.45) * normal
    points = problem.strokes.points.reshape(-1, 2)
    clear = float(np.linalg.norm(points - centre, axis=1).min())
    axes = max(clear, 0.05) * rng.uniform(0.3, 0.95) * rng.uniform(0.6, 1.0, 2)
    return np.array([*centre, *np.log(axes), rng.uniform(-0.5, 0.5) * np.pi])
