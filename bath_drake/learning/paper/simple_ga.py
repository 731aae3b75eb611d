"""The genetic algorithm and the descent of the paper's Sec. III-C.

The paper took its GA from J. Burkardt's `simple_ga` (its reference [30]), after
Michalewicz (its [29]). These are that program's operators, in its order: selection in
proportion to fitness, single-point crossover of pairs, uniform mutation of genes within
their bounds, and an elitist that keeps the best member ever. Every member is then taken
downhill, x <- x - omega grad C.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.learning.checkpoint import Arrays
from bath_drake.learning.single.genetic import Cost
from bath_drake.notation import FloatArray

State = Arrays
"""members (n, P), costs (n,), best (P,), best_cost (1,) and evaluations (1,)."""

# Differences of C; a Fréchet distance has kinks, so that finer is not truer.
_DIFFERENCE = 1e-4
# Of C: a perfect member would otherwise be all there is.
_LEAST = 1e-6


@dataclass(frozen=True)
class SimpleGA:
    """Rates of the GA, and the descent's step.

    Population and crossover are `simple_ga`'s own. Its mutation is 0.15 for each gene,
    of which its example has three, and it breeds 1000 generations.
    """

    population: int = 50
    """Members of a generation."""
    generations: int = 80
    """How often a population is bred."""
    crossover: float = 0.8
    """Chance that a member is among those that are crossed in pairs."""
    mutation: float = 1.0
    """Genes of a member that are drawn anew, on average."""
    descent: int = 1
    """Steps of descent that every member of each generation takes."""
    omega: float = 0.2
    """Their step omega: genes and C are both in units of N."""


def first_generation(
    cost: Cost,
    members: FloatArray,
    low: FloatArray,
    high: FloatArray,
    settings: SimpleGA,
) -> State:
    """The state that ``members`` (n, P) give after their descent."""
    members = np.clip(members, low, high)
    members, costs, evaluations = descend(cost, members, low, high, settings)
    best = int(np.argmin(costs))
    return {
        "members": members,
        "costs": costs,
        "best": members[best].copy(),
        "best_cost": costs[best : best + 1].copy(),
        "evaluations": np.array([float(evaluations)]),
    }


def next_generation(
    cost: Cost,
    state: State,
    low: FloatArray,
    high: FloatArray,
    settings: SimpleGA,
    rng: np.random.Generator,
) -> State:
    """What a state's members breed; nothing but the arguments has a say in it."""
    members = select(state["members"], state["costs"], rng)
    members = cross(members, settings.crossover, rng)
    members = mutate(members, low, high, settings.mutation, rng)
    members, costs, evaluations = descend(cost, members, low, high, settings)
    best, best_cost = state["best"], state["best_cost"]
    champion = int(np.argmin(costs))
    if costs[champion] <= best_cost[0]:
        best, best_cost = members[champion].copy(), costs[champion : champion + 1]
    else:
        worst = int(np.argmax(costs))
        members[worst], costs[worst] = best, best_cost[0]
    return {
        "members": members,
        "costs": costs,
        "best": best.copy(),
        "best_cost": best_cost.copy(),
        "evaluations": state["evaluations"] + evaluations,
    }


def select(
    members: FloatArray, costs: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """As many members, drawn in proportion to their fitness 1 / C^2."""
    fitness = np.maximum(costs, _LEAST) ** -2.0
    wheel = np.cumsum(fitness)
    drawn = rng.random(len(members)) * wheel[-1]
    return np.asarray(members[np.searchsorted(wheel, drawn, side="right")])


def cross(members: FloatArray, chance: float, rng: np.random.Generator) -> FloatArray:
    """Members of which some, in pairs, have swapped their genes before a point."""
    members = members.copy()
    chosen = np.flatnonzero(rng.random(len(members)) < chance)
    for one, other in zip(chosen[::2], chosen[1::2], strict=False):
        point = int(rng.integers(members.shape[1])) if members.shape[1] else 0
        swapped = members[one, :point].copy()
        members[one, :point] = members[other, :point]
        members[other, :point] = swapped
    return members


def mutate(
    members: FloatArray,
    low: FloatArray,
    high: FloatArray,
    genes: float,
    rng: np.random.Generator,
) -> FloatArray:
    """Members of which that many genes each, on average, are drawn anew.

    They are drawn evenly from between the bounds, (P,) each.
    """
    hit = rng.random(members.shape) * members.shape[1] < genes
    return np.asarray(np.where(hit, rng.uniform(low, high, members.shape), members))


def descend(
    cost: Cost,
    members: FloatArray,
    low: FloatArray,
    high: FloatArray,
    settings: SimpleGA,
) -> tuple[FloatArray, FloatArray, int]:
    """Steps x <- x - omega grad C of all members (n, P) at once, by differences.

    A step that raises C is not taken, and ends its member's descent: the next one would
    be the same. Returns members, their costs (n,) and how many were evaluated.
    """
    xs = members.copy()
    n, size = xs.shape
    costs = cost(xs)
    evaluations = n
    shifts = _DIFFERENCE * np.eye(size)
    going = np.arange(n)
    for _ in range(settings.descent):
        if not len(going) or not size:
            break
        ahead = cost((xs[going, None] + shifts).reshape(-1, size))
        ahead = ahead.reshape(len(going), size)
        gradient = (ahead - costs[going, None]) / _DIFFERENCE
        tried = np.clip(xs[going] - settings.omega * gradient, low, high)
        after = cost(tried)
        evaluations += (size + 1) * len(going)
        better = after < costs[going]
        going = going[better]
        xs[going], costs[going] = tried[better], after[better]
    return xs, costs, evaluations
