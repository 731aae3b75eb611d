"""First populations: matched to the flow's direction, by bends, and at random."""

import numpy as np

from bath_drake.learning import _matching, genome
from bath_drake.learning.cost import LearningProblem
from bath_drake.learning.matching import CANDIDATES, Matcher
from bath_drake.learning.strokes import headings
from bath_drake.notation import FloatArray, IntArray

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

    The first half has obstacles chosen one by one for the flow's direction. Three
    quarters of the others have one on the inner side of each bend and the rest beside
    random points of the stroke; the last eighth has all of them there.
    """
    matched = size // 2
    found = np.empty((size, genome.GENES * count + 1))
    found[:matched] = grow(None, count, matched, problem, rng)
    curve = problem.strokes.mean
    turns = bends(curve)
    least = np.log(max(1.0, problem.margins.kappa * count))
    for n in range(matched, size):
        seeded = len(turns) if rng.random() < 0.75 else 0
        order = rng.permutation(len(turns))[:seeded][:count]
        at = rng.integers(2, len(curve) - 2, count)
        sides = rng.choice(np.array([-1.0, 1.0]), count)
        for i, turn in enumerate(order):
            at[i] = turns[turn][0] + int(rng.normal(0.0, 0.02 * len(curve)))
            sides[i] = np.sign(turns[turn][1])
        found[n, :-1] = beside(at, sides, problem, rng).ravel()
        found[n, -1] = least + rng.uniform(0.0, 1.5)
    return genome.clip(found, problem.workspace)


def grow(
    x: FloatArray | None,
    count: int,
    size: int,
    problem: LearningProblem,
    rng: np.random.Generator,
) -> FloatArray:
    """``size`` members, (size, 5 count + 1), that have all obstacles of ``x``.

    What fewer obstacles have learned is a good first guess for ``count`` of them:
    each obstacle added is the one among a few random ones that mends the flow's
    direction best.
    """
    curve = problem.strokes.mean
    kept = np.empty((0, genome.GENES)) if x is None else x[:-1].reshape(-1, 5)
    missing = count - len(kept)
    if missing == 0:
        return np.array([x])
    matcher = Matcher(problem)
    shape = (missing, CANDIDATES)
    grown = np.empty((size, genome.GENES * count + 1))
    for n in range(size):
        at = rng.integers(2, len(curve) - 2, shape).ravel()
        sides = rng.choice(np.array([-1.0, 1.0]), len(at))
        choice = beside(at, sides, problem, rng).reshape(*shape, genome.GENES)
        rows, kappa = matcher.complete(kept, count, choice)
        grown[n] = np.append(rows.ravel(), np.log(kappa))
    return genome.clip(grown, problem.workspace)


def beside(
    at: IntArray, sides: FloatArray, problem: LearningProblem, rng: np.random.Generator
) -> FloatArray:
    """Ellipses (n, 5) beside points of the stroke, clear of the demonstrations."""
    curve, n = problem.strokes.mean, len(at)
    at = np.clip(at, 2, len(curve) - 3)
    tangent = curve[at + 2] - curve[at - 2]
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1)
    normal /= np.linalg.norm(tangent, axis=1, keepdims=True) + 1e-12
    away = sides * rng.uniform(0.06, 0.45, n)
    centres = curve[at] + away[:, None] * normal
    clear = _matching.clearances(centres, problem.clear_points)
    size = np.maximum(clear, 0.05) * rng.uniform(0.3, 0.95, n)
    axes = size[:, None] * rng.uniform(0.6, 1.0, (n, 2))
    angles = rng.uniform(-0.5, 0.5, n) * np.pi
    return np.column_stack([centres, np.log(axes), angles])
