"""A real-coded genetic algorithm over obstacles (paper, Sec. III-C)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from bath_drake.learning import genome
from bath_drake.learning.checkpoint import Arrays, Checkpoint
from bath_drake.notation import FloatArray

Cost = Callable[[FloatArray], FloatArray]
"""Costs (n,) of members (n, P)."""
Improve = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Members (n, P), improved, and their costs (n,)."""
Immigrants = Callable[[int, np.random.Generator], FloatArray]
"""That many new members (n, P)."""
Step = Callable[[str, Callable[[], Arrays]], Arrays]
"""What a step of that name gives: stored already, or computed (`Checkpoint.step`)."""


# Immigrants are the best of this many times their number.
_CHOICE = 10


@dataclass(frozen=True)
class GeneticSettings:
    """How a population is bred."""

    population: int = 60
    """Members kept from one generation to the next."""
    generations: int = 30
    """How often children are bred."""
    elite: int = 4
    """Best members that live on unchanged."""
    tournament: int = 3
    """Members drawn for each parent; the best of them becomes one."""
    mutation: float = 0.5
    """Chance that an obstacle of a child is moved."""
    first_scale: float = 0.4
    """Size of a mutation at first, in units of `genome.scales`."""
    last_scale: float = 0.03
    """Its size at the end; it decays geometrically in between."""
    immigrants: float = 0.1
    """Share of each generation that is new blood."""


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


def evolve(
    cost: Cost,
    first: FloatArray,
    settings: GeneticSettings,
    seed: Sequence[int],
    *,
    immigrants: Immigrants,
    clip: Callable[[FloatArray], FloatArray],
    improve: Improve | None = None,
    report: Callable[[FloatArray], bool] | None = None,
    step: Step | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Breeds a population; returns its members (n, P) and costs (n,), best first.

    A member whose cost is not finite is dropped; if all of the first are, none is
    left. Each generation has a generator of its
    own, seeded by ``seed`` and its number: it is a function of the one before alone.

    Args:
        cost: What is minimised.
        first: The first population (n, P); its best members are kept.
        settings: Sizes and rates.
        seed: The only source of chance.
        immigrants: Makes new members.
        clip: Moves members into their bounds.
        improve: Local descent on each newborn member, if any.
        report: Shown the best member after each generation; True ends it.
        step: Keeps the first population and each generation by name, if given.
    """
    step = step or Checkpoint().step

    def settle(xs: FloatArray) -> tuple[FloatArray, FloatArray]:
        xs = clip(xs)
        return improve(xs) if improve is not None else (xs, cost(xs))

    def begin() -> Arrays:
        keep = np.argsort(cost(first), kind="stable")[: settings.population]
        return _ranked(*settle(first[keep]))

    found = step("generation 0", begin)
    for g in range(1, settings.generations + 1):
        xs, costs = found["xs"], found["costs"]
        if len(xs) == 0:
            break  # none of the first could be evaluated

        def breed(g: int = g, xs: FloatArray = xs, costs: FloatArray = costs) -> Arrays:
            rng = np.random.default_rng([*seed, g])
            newborn, settled = settle(_newborn(xs, g, settings, cost, immigrants, rng))
            # Where its descent fails, an elite member stays what it was.
            kept = np.flatnonzero(~np.isfinite(settled[: len(xs[: settings.elite])]))
            return _ranked(
                np.concatenate([newborn, xs[kept]]),
                np.concatenate([settled, costs[kept]]),
            )

        found = step(f"generation {g}", breed)
        if report is not None and report(found["xs"][0]):
            break
    return found["xs"], found["costs"]


def _newborn(
    xs: FloatArray,
    g: int,
    settings: GeneticSettings,
    cost: Cost,
    immigrants: Immigrants,
    rng: np.random.Generator,
) -> FloatArray:
    """Generation g before its descent: the elite, children, and new blood."""
    decay = settings.last_scale / settings.first_scale
    share = (g - 1) / max(1, settings.generations - 1)
    scale = settings.first_scale * decay**share
    size = settings.population
    new = round(settings.immigrants * size)
    children = []
    for _ in range(size - settings.elite - new):
        # The population is sorted: the smallest index drawn wins.
        parents = rng.integers(len(xs), size=(2, settings.tournament)).min(axis=1)
        child = crossover(xs[parents[0]], xs[parents[1]], rng)
        children.append(mutate(child, settings.mutation, scale, rng))
    fresh = immigrants(_CHOICE * new, rng)
    fresh = fresh[np.argsort(cost(fresh), kind="stable")[:new]]
    # The elite goes through the descent again: each generation takes it further.
    return np.concatenate([xs[: settings.elite], children, fresh])


def _ranked(xs: FloatArray, costs: FloatArray) -> Arrays:
    """Members with a finite cost, the best first."""
    order = np.argsort(costs, kind="stable")
    order = order[np.isfinite(costs[order])]
    return {"xs": xs[order], "costs": costs[order]}
