"""The two searches: the paper's, and genetic search with multiple shooting."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from bath_drake.certificate.certify import certify
from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.learning import genome, shooting
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.cost import LearningProblem
from bath_drake.learning.descent import descend
from bath_drake.learning.genetic import GeneticSettings, evolve
from bath_drake.learning.seeding import grow, seed_population
from bath_drake.notation import FloatArray
from bath_drake.threads import parallel_map, split

_FINALISTS = 4
_REPAIRS = 2


@dataclass(eq=False)
class Journal:
    """Keeps the learning curve and tells progress.

    Attributes:
        rounds: How many obstacle counts may be tried.
        scale: What costs are divided by.
        progress: Called with steps done, steps in all and the best cost.
        history: (members evaluated, best C over the scale), ever better.
        learned: Finished members of the last count, for the next to start from.
    """

    rounds: int
    scale: float
    progress: Callable[[int, int, float], None] | None
    history: list[tuple[int, float]] = field(default_factory=list)
    evaluations: int = 0
    learned: list[FloatArray] = field(default_factory=list)
    _done: int = 0
    _total: int = 0

    def resume(self, problem: LearningProblem, x: FloatArray) -> None:
        """Enters what is learned already; the first round then starts from it."""
        self.learned = [x]
        self.evaluations += 1
        self.note(problem, x)

    def plan(self, steps: int) -> None:
        """Announces how many steps a round takes."""
        self._total = self._done + steps * self.rounds
        self.rounds -= 1

    def note(self, problem: LearningProblem, x: FloatArray) -> float:
        """Enters the best member of a step; returns its C over the scale."""
        cost = float(problem.evaluate(x[None]).demonstration_cost[0]) / self.scale
        best = min(cost, self.history[-1][1]) if self.history else cost
        self.history.append((self.evaluations, best))
        self._done += 1
        self._tell()
        return cost

    def finish(self) -> None:
        """Says that no further step comes."""
        self._done = self._total
        self._tell()

    def _tell(self) -> None:
        if self.progress is not None and self.history:
            self.progress(self._done, self._total, self.history[-1][1])


def candidates(
    problem: LearningProblem,
    count: int,
    config: LearnerConfig,
    rng: np.random.Generator,
    journal: Journal,
) -> list[NavigationField]:
    """Learned fields of ``count`` obstacles, at least one, for a judge to rank."""
    if config.method == "paper":
        xs = _search_paper(problem, count, config, rng, journal)
    else:
        xs = _search_auto(problem, count, config, rng, journal)
    return [genome.decode(x, problem.workspace, problem.strokes.goal) for x in xs]


def _settings(config: LearnerConfig, size: int, length: int) -> GeneticSettings:
    population = config.population if config.population is not None else size
    generations = config.generations if config.generations is not None else length
    elite = max(1, population // 4)
    return GeneticSettings(population, generations, elite, immigrants=0.25)


def _search_paper(
    problem: LearningProblem,
    count: int,
    config: LearnerConfig,
    rng: np.random.Generator,
    journal: Journal,
) -> list[FloatArray]:
    """Genetic search with descent on C of whole roll-outs, and its penalties."""
    settings = replace(_settings(config, 40, 40), immigrants=0.1)
    journal.plan(settings.generations + 2)
    scale = genome.scales(count)

    def cost(xs: FloatArray) -> FloatArray:
        journal.evaluations += len(xs)
        return problem.evaluate(xs).total

    def clip(xs: FloatArray) -> FloatArray:
        return genome.clip(xs, problem.workspace)

    def improve(xs: FloatArray) -> tuple[FloatArray, FloatArray]:
        return descend(cost, xs, scale, iterations=1, omega=0.05, clip=clip)

    xs = seed_population(problem, count, config.seeds, rng)
    known = [grow(x, count, config.seeds // 8, problem, rng) for x in journal.learned]
    xs = np.concatenate([*known, xs])
    journal.note(problem, xs[0])
    xs, _ = evolve(
        cost,
        xs,
        settings,
        rng,
        immigrants=lambda n, r: seed_population(problem, count, n, r),
        clip=clip,
        improve=improve,
        report=lambda x: journal.note(problem, x) <= 0.0,
    )
    xs, costs = descend(cost, xs[:_FINALISTS], scale, iterations=25, clip=clip)
    journal.note(problem, xs[int(np.argmin(costs))])
    return list(xs)


def _search_auto(
    problem: LearningProblem,
    count: int,
    config: LearnerConfig,
    rng: np.random.Generator,
    journal: Journal,
) -> list[FloatArray]:
    """Genetic search whose local descent is multiple shooting on growing windows."""
    settings = _settings(config, 24, 8)
    # While the basin is sought, every other point of the mean stroke will do.
    coarse = np.ascontiguousarray(problem.strokes.mean[None, ::2])
    windows = shooting.cut_windows(coarse, 20, 5, 0.6)
    windows += shooting.whole_strokes(coarse, 0.4)

    def cost(xs: FloatArray) -> FloatArray:
        journal.evaluations += len(xs)
        # Light hinges: a seed that overlaps a little is easily mended.
        parts = parallel_map(
            lambda part: shooting.shooting_cost(part, problem, windows, 2.0, 2.0),
            split(xs),
        )
        return np.concatenate(parts)

    def improve(xs: FloatArray) -> tuple[FloatArray, FloatArray]:
        fits = parallel_map(
            lambda x: shooting.fit(x, problem, windows, mu=20.0, iterations=10), xs
        )
        journal.evaluations += sum(n for _, _, n in fits)
        return np.array([x for x, _, _ in fits]), np.array([c for _, c, _ in fits])

    if count == 0:
        journal.plan(1)
        xs, costs = improve(np.array([[0.7], *journal.learned]))
        journal.learned = [xs[int(np.argmin(costs))]]
        journal.note(problem, journal.learned[0])
        return list(xs)
    journal.plan(settings.generations + 2)
    # C cannot fall much below the demonstrations' own spread, and finishing lowers it.
    enough = config.target + 0.5 * problem.strokes.floor
    xs = seed_population(problem, count, config.seeds, rng)
    known = [grow(x, count, config.seeds // 8, problem, rng) for x in journal.learned]
    xs = np.concatenate([*known, xs])
    journal.note(problem, xs[0])
    xs, costs = evolve(
        cost,
        xs,
        settings,
        rng,
        immigrants=lambda n, r: seed_population(problem, count, n, r),
        clip=lambda xs: genome.clip(xs, problem.workspace),
        improve=improve,
        report=lambda x: journal.note(problem, x) <= enough,
    )
    finalists = _distinct(xs, costs)
    # A member of this size that is learned already is finished once more.
    finalists += [x for x in journal.learned if genome.obstacle_count(x) == count]
    finished = parallel_map(lambda x: _finish(x, problem), finalists)
    journal.evaluations += sum(n for _, n in finished)
    done = [x for x, _ in finished]
    totals = problem.evaluate(np.array(done)).total
    journal.note(problem, done[int(np.argmin(totals))])
    journal.learned = [done[i] for i in np.argsort(totals, kind="stable")[:2]]
    return done


def _distinct(xs: FloatArray, costs: FloatArray) -> list[FloatArray]:
    """The best few members (sorted) that are not copies of a better one."""
    kept: list[int] = []
    for i in range(len(xs)):
        # Members of one basin have nearly one cost after their descent.
        if all(abs(costs[i] - costs[k]) > 0.01 * costs[k] for k in kept):
            kept.append(i)
    return [xs[i] for i in kept[:_FINALISTS]]


def _finish(x: FloatArray, problem: LearningProblem) -> tuple[FloatArray, int]:
    """Fine windows, then nearly the Fréchet distance; mends what is not proved."""
    strokes = problem.strokes.points
    windows = shooting.whole_strokes(strokes, 0.8)
    windows += shooting.cut_windows(strokes, 10, 5, 0.2)
    evaluations = 0
    for attempt in range(_REPAIRS + 1):
        # A mean of sixth powers is ruled by the greatest distance, as Fréchet is.
        for power, mu in ((2.0, 100.0), (6.0, 400.0)):
            x, _, n = shooting.fit(x, problem, windows, power=power, mu=mu)
            evaluations += n
        found = genome.decode(x, problem.workspace, problem.strokes.goal)
        if attempt == _REPAIRS or _sound(found, strokes[:, 0]):
            break
        m = problem.margins
        # Spurious minima go as kappa grows and slits widen.
        wider = replace(
            m,
            pair=m.pair + 0.02,
            kappa=1.3 * float(np.exp(x[-1])) / max(1, genome.obstacle_count(x)),
            curvature=m.curvature + 0.1,
        )
        problem = replace(problem, margins=wider)
    return x, evaluations


def _sound(found: NavigationField, starts: FloatArray) -> bool:
    """Whether all starts are in free space and that is proved free of traps."""
    return bool((min_beta(starts, found) > 0.0).all()) and certify(found).passed
