"""How members change from one generation to the next: crossover and mutation."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import linear_sum_assignment

from bath_drake.learning import genome
from bath_drake.learning.checkpoint import Arrays
from bath_drake.notation import FloatArray

Cost = Callable[[FloatArray], FloatArray]
"""Costs (n,) of members (n, P)."""
Step = Callable[[str, Callable[[], Arrays]], Arrays]
"""What a step of that name gives: stored already, or computed (`Checkpoint.step`)."""


def crossover(
    mother: FloatArray, father: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """A child (P,): whole obstacles of one parent, or blends of both.

    The father's obstacles are first matched to the mother's by their centres, since
    their order means nothing.
    """
    m = mother[:-1].reshape(-1, genome.GENES)
    f = father[:-1].reshape(-1, genome.GENES)
    apart = np.linalg.norm(m[:, None, :2] - f[None, :, :2], axis=-1)
    f = f[linear_sum_assignment(apart)[1]]
    child = m.copy()
    for i in range(len(m)):
        how = rng.random()
        if how < 1.0 / 3.0:
            child[i] = f[i]
        elif how < 2.0 / 3.0:
            turn = f[i, 4] - m[i, 4]
            turn -= np.pi * np.round(turn / np.pi)  # an ellipse is itself at pi
            share = rng.uniform(-0.25, 1.25)
            child[i] += share * (f[i] - m[i])
            child[i, 4] = m[i, 4] + share * turn
    kappa = mother[-1] + rng.uniform(-0.25, 1.25) * (father[-1] - mother[-1])
    return np.append(child.ravel(), kappa)


def mutate(
    x: FloatArray, chance: float, scale: float, rng: np.random.Generator
) -> FloatArray:
    """A copy of x (P,) with some obstacles, and kappa, moved at random."""
    spread = scale * genome.scales(genome.obstacle_count(x))
    noise = spread * rng.normal(size=x.shape)
    hit = rng.random(genome.obstacle_count(x) + 1) < chance
    mask = np.append(np.repeat(hit[:-1], genome.GENES), hit[-1])
    return np.asarray(x + np.where(mask, noise, 0.0))
