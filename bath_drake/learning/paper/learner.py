"""The paper's learner (Sec. III-C), as it is written: what the rest is compared with.

From the paper:

- The unknowns are the centres and the lengths of the principal axes of Q ellipses
  (Sec. III-A); Q is set beforehand (Sec. VI).
- The cost is C = (1/D) sum_n F(R_n, E_n), F the discrete Fréchet distance and R_n the
  Euler roll-out q <- q + dt u of Eq. 2 from the start of demonstration E_n.
- A genetic algorithm, the operators of `simple_ga`, in which every
  member of each generation is improved by x <- x - omega grad C.

Left open there, and chosen here (`PaperSettings`):

- kappa is fixed, the workspace a disc, and genes are drawn evenly from bounds: centres
  from the canonical square, semi-axes from 0.05 to 0.5.
- u is the unit vector along -grad phi. The size of grad phi spans orders of magnitude
  along one stroke, and no single dt serves it; the curves are the same. A roll-out ends
  2e-3 from the goal or after one and a half times the demonstrations' length and 1.
- Fitness, which the operators need, is 1 / C^2.
- Of `simple_ga`'s three genes 0.15 are drawn anew; at that rate, a member of twenty
  would hardly be bred from its parents. Here it is one gene a member, on average.
- grad C is taken by differences of 1e-4; a step that raises C is not taken.
- All demonstrations share the mean goal, as everywhere in this package.

The paper asks nothing else of the obstacles, and neither does this: they may overlap,
cover a demonstration or the goal, reach over the rim, or trap. Euler steps may enter
them; `PaperResult.entries` counts how often those of the result do. Whether the field
is worth anything is judged elsewhere, by guarded roll-outs and a proof.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from bath_drake.field.navigation import NavigationField
from bath_drake.learning.checkpoint import Arrays
from bath_drake.learning.cost import LearningProblem
from bath_drake.learning.paper import cost as paper_cost
from bath_drake.learning.paper import simple_ga
from bath_drake.learning.paper.simple_ga import SimpleGA
from bath_drake.learning.single.genetic import Cost, Step
from bath_drake.notation import FloatArray


@dataclass(frozen=True)
class PaperSettings:
    """What the paper leaves open."""

    genetic: SimpleGA = field(default_factory=SimpleGA)
    """The genetic algorithm and the descent."""
    kappa: float = 16.0
    """Exponent of the navigation function."""
    dt: float = 0.02
    """Euler's step, in units of N."""
    reach: float = 1.0
    """Greatest coordinate of a centre."""
    axes: tuple[float, float] = (0.05, 0.5)
    """Least and greatest length of a semi-axis."""

    def bounds(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Least and greatest genes of ``count`` obstacles, (4 count,) each."""
        low = [-self.reach, -self.reach, self.axes[0], self.axes[0]]
        high = [self.reach, self.reach, self.axes[1], self.axes[1]]
        return np.tile(low, count), np.tile(high, count)


def settings_for(population: int | None, generations: int | None) -> PaperSettings:
    """The settings of a population and so many generations; None: the usual number."""
    usual = SimpleGA()
    return PaperSettings(
        replace(
            usual,
            population=usual.population if population is None else population,
            generations=usual.generations if generations is None else generations,
        )
    )


@dataclass(frozen=True, eq=False)
class PaperResult:
    """The best member there ever was.

    Attributes:
        field: Its field.
        cost: Its C, in units of N.
        arrived: Share of its Euler roll-outs that reach the goal.
        entries: How often they leave free space or leap over an obstacle.
        evaluations: Of C, in all.
    """

    field: NavigationField
    cost: float
    arrived: float
    entries: int
    evaluations: int


def learn(
    problem: LearningProblem,
    count: int,
    settings: PaperSettings,
    seed: int,
    *,
    step: Step | None = None,
    report: Callable[[Arrays], None] | None = None,
) -> PaperResult:
    """Finds ``count`` obstacles; the same arguments give the same result, bit by bit.

    ``step`` and ``report`` are as for `search`.
    """

    def cost(xs: FloatArray) -> FloatArray:
        return paper_cost.evaluate(xs, problem, settings.kappa, settings.dt).total

    found = search(
        cost,
        *settings.bounds(count),
        settings.genetic,
        (seed, count),
        step=step,
        report=report,
    )
    best = found["best"]
    costs = paper_cost.evaluate(best[None], problem, settings.kappa, settings.dt)
    return PaperResult(
        field=paper_cost.decode(best, problem, settings.kappa),
        cost=float(costs.total[0]),
        arrived=float(costs.arrived[0]),
        entries=int(costs.entries[0]),
        evaluations=int(found["evaluations"][0]),
    )


def search(
    cost: Cost,
    low: FloatArray,
    high: FloatArray,
    settings: SimpleGA,
    seed: tuple[int, ...],
    *,
    first: FloatArray | None = None,
    step: Step | None = None,
    report: Callable[[Arrays], None] | None = None,
) -> Arrays:
    """Breeds all generations; returns the last state (see `simple_ga.State`).

    Args:
        cost: What is minimised.
        low: Least genes (P,).
        high: Greatest genes (P,); a gene whose bounds are equal is fixed.
        settings: Rates.
        seed: Each generation draws from a generator of its own, seeded by this and its
            number, and is a function of the one before alone.
        first: The first population (n, P); None draws it from between the bounds.
        step: Keeps each generation by name, if given.
        report: Shown every generation's state.
    """
    step = step or (lambda key, compute: compute())

    def begin() -> Arrays:
        members = first
        if members is None:
            rng = np.random.default_rng([*seed, 0])
            members = rng.uniform(low, high, (settings.population, len(low)))
        return simple_ga.first_generation(cost, members, low, high, settings)

    state = step("generation 0", begin)
    for g in range(settings.generations + 1):
        if g > 0:

            def breed(state: Arrays = state, g: int = g) -> Arrays:
                rng = np.random.default_rng([*seed, g])
                return simple_ga.next_generation(cost, state, low, high, settings, rng)

            state = step(f"generation {g}", breed)
        if report is not None:
            report(state)
    return state
