"""The two searches: the paper's, and genetic search with multiple shooting."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from bath_drake.certificate.certify import certify
from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.learning import genome, paper, paper_cost, shooting
from bath_drake.learning.checkpoint import Arrays, Checkpoint, Steps
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.cost import LearningProblem
from bath_drake.learning.failures import FAILURES, costs_of
from bath_drake.learning.genetic import GeneticSettings, evolve
from bath_drake.learning.seeding import grow, seed_population
from bath_drake.notation import FloatArray
from bath_drake.threads import parallel_map, split

_FINALISTS = 4
_REPAIRS = 2


@dataclass(eq=False)
class Journal:
    """Keeps the learning curve and the best member, and tells progress.

    Attributes:
        rounds: How many obstacle counts may be tried.
        scale: What costs are divided by.
        progress: Called with steps done, steps in all and the best cost.
        checkpoint: Keeps what steps gave.
        history: (members evaluated, best C over the scale), ever better.
        evaluations: How many members were evaluated.
        failures: How many of them had no finite cost.
        learned: Finished members of the last count, for the next to start from.
        best: The member of the lowest cost with its penalties, (P,), if there is any.
    """

    rounds: int
    scale: float
    progress: Callable[[int, int, float], None] | None
    checkpoint: Steps = field(default_factory=Checkpoint)
    history: list[tuple[int, float]] = field(default_factory=list)
    evaluations: int = 0
    failures: int = 0
    learned: list[FloatArray] = field(default_factory=list)
    best: FloatArray | None = None
    _least: float = np.inf
    _done: int = 0
    _total: int = 0

    def plan(self, steps: int) -> None:
        """Announces how many steps a round takes."""
        self._total = self._done + steps * self.rounds
        self.rounds -= 1

    def step(self, key: str, compute: Callable[[], Arrays]) -> Arrays:
        """As `Checkpoint.step`; what the step evaluates is counted either way."""
        before = np.array([self.evaluations, self.failures])

        def counted() -> Arrays:
            arrays = compute()
            now = np.array([self.evaluations, self.failures])
            return {**arrays, "counted": now - before}

        arrays = self.checkpoint.step(key, counted)
        self.evaluations, self.failures = map(int, before + arrays.pop("counted"))
        return arrays

    def count(self, costs: FloatArray) -> FloatArray:
        """Counts members evaluated, by their costs (n,), which it returns."""
        self.evaluations += len(costs)
        self.failures += int((~np.isfinite(costs)).sum())
        return costs

    def note(self, problem: LearningProblem, x: FloatArray) -> float:
        """Enters the best member of a step; returns its C over the scale."""
        costs = problem.evaluate(x[None])
        cost = float(costs.demonstration_cost[0]) / self.scale
        self.enter(cost, x, float(costs.total[0]))
        return cost

    def enter(
        self, cost: float, x: FloatArray | None = None, total: float = np.inf
    ) -> None:
        """Enters a step's C over the scale, its best member and that's cost in all."""
        if total < self._least:
            self.best, self._least = x, total
        best = min(cost, self.history[-1][1]) if self.history else cost
        self.history.append((self.evaluations, best))
        self._done += 1
        self._tell()

    def turn_to(self, checkpoint: Steps) -> None:
        """Begins something else to learn, with steps of its own."""
        self.checkpoint = checkpoint
        self.learned = []
        self.best, self._least = None, np.inf

    def finish(self) -> None:
        """Says that no further step comes."""
        self._done = self._total
        self._tell()

    def _tell(self) -> None:
        if self.progress is not None and self.history:
            self.progress(self._done, self._total, self.history[-1][1])


def candidates(
    problem: LearningProblem, count: int, config: LearnerConfig, journal: Journal
) -> list[NavigationField]:
    """Learned fields of ``count`` obstacles for a judge to rank, usually some."""
    search = _search_paper if config.method == "paper" else _search_auto
    xs = search(problem, count, config, journal)
    return [genome.decode(x, problem.workspace, problem.strokes.goal) for x in xs]


def _first(
    problem: LearningProblem, count: int, config: LearnerConfig, journal: Journal
) -> FloatArray:
    """Members (n, P) among which the first population is chosen."""

    def seeds() -> Arrays:
        rng = np.random.default_rng([config.seed, count])
        new = seed_population(problem, count, config.seeds, rng)
        each = config.seeds // 8
        known = [grow(x, count, each, problem, rng) for x in journal.learned]
        return {"xs": np.concatenate([*known, new])}

    return journal.step(f"{count}: seeds", seeds)["xs"]


def _settings(config: LearnerConfig, size: int, length: int) -> GeneticSettings:
    population = config.population if config.population is not None else size
    generations = config.generations if config.generations is not None else length
    elite = max(1, population // 4)
    return GeneticSettings(population, generations, elite, immigrants=0.25)


def _search_paper(
    problem: LearningProblem, count: int, config: LearnerConfig, journal: Journal
) -> list[FloatArray]:
    """The one result of the paper's learner."""
    settings = paper.settings_for(config.population, config.generations)
    journal.plan(settings.genetic.generations + 1)
    before = journal.evaluations

    def encode(best: FloatArray) -> FloatArray:
        return genome.encode(paper_cost.decode(best, problem, settings.kappa))

    def report(state: Arrays) -> None:
        journal.evaluations = before + int(state["evaluations"][0])
        cost = float(state["best_cost"][0])  # which has no penalties
        journal.enter(cost / journal.scale, encode(state["best"]), cost)

    found = paper.learn(
        problem,
        count,
        settings,
        config.seed,
        step=lambda key, compute: journal.checkpoint.step(f"{count}: {key}", compute),
        report=report,
    )
    return [genome.encode(found.field)]


def _search_auto(
    problem: LearningProblem,
    count: int,
    config: LearnerConfig,
    journal: Journal,
) -> list[FloatArray]:
    """Genetic search whose local descent is multiple shooting on growing windows."""
    settings = _settings(config, 24, 8)
    # While the basin is sought, every other point of the mean stroke will do.
    coarse = np.ascontiguousarray(problem.strokes.mean[None, ::2])
    windows = shooting.cut_windows(coarse, 20, 5, 0.6)
    windows += shooting.whole_strokes(coarse, 0.4)

    def cost(xs: FloatArray) -> FloatArray:
        def one(part: FloatArray) -> FloatArray:
            # Light hinges: a seed that overlaps a little is easily mended.
            return shooting.shooting_cost(part, problem, windows, 2.0, 2.0)

        parts = parallel_map(lambda part: costs_of(one, part), split(xs))
        return journal.count(np.concatenate(parts))

    def fit(x: FloatArray) -> tuple[FloatArray, float, int]:
        try:
            return shooting.fit(x, problem, windows, mu=20.0, iterations=10)
        except FAILURES:
            return x, np.inf, 1

    def improve(xs: FloatArray) -> tuple[FloatArray, FloatArray]:
        fits = parallel_map(fit, xs)
        costs = journal.count(np.array([c for _, c, _ in fits]))
        journal.evaluations += sum(n - 1 for _, _, n in fits)
        return np.array([x for x, _, _ in fits]), costs

    def step(key: str, compute: Callable[[], Arrays]) -> Arrays:
        return journal.step(f"{count}: {key}", compute)

    if count == 0:
        journal.plan(1)
        xs = step("fit", lambda: {"xs": improve(np.array([[0.7]]))[0]})["xs"]
        journal.learned = [xs[0]]
        journal.note(problem, xs[0])
        return list(xs)
    journal.plan(settings.generations + 2)
    # C cannot fall much below the demonstrations' own spread, and finishing lowers it.
    enough = config.target + 0.5 * problem.strokes.floor
    xs = _first(problem, count, config, journal)
    journal.note(problem, xs[0])
    xs, costs = evolve(
        cost,
        xs,
        settings,
        [config.seed, count],
        immigrants=lambda n, r: seed_population(problem, count, n, r),
        clip=lambda xs: genome.clip(xs, problem.workspace),
        improve=improve,
        report=lambda x: journal.note(problem, x) <= enough,
        step=step,
    )
    finalists = _distinct(xs, costs)
    if not finalists:
        return []  # no member could be evaluated
    finished = parallel_map(
        lambda k: journal.checkpoint.step(
            f"{count}: finish {k}", lambda: _finish(finalists[k], problem)
        ),
        range(len(finalists)),
    )
    journal.evaluations += sum(int(f["evaluations"]) for f in finished)
    journal.failures += sum(int(f["failures"]) for f in finished)
    done = np.array([f["x"] for f in finished])
    totals = problem.evaluate(done).total
    journal.note(problem, done[int(np.argmin(totals))])
    journal.learned = [done[i] for i in np.argsort(totals, kind="stable")[:2]]
    return list(done)


def _distinct(xs: FloatArray, costs: FloatArray) -> list[FloatArray]:
    """The best few members (sorted) that are not copies of a better one."""
    kept: list[int] = []
    for i in range(len(xs)):
        # Members of one basin have nearly one cost after their descent.
        if all(abs(costs[i] - costs[k]) > 0.01 * costs[k] for k in kept):
            kept.append(i)
    return [xs[i] for i in kept[:_FINALISTS]]


def _finish(x: FloatArray, problem: LearningProblem) -> Arrays:
    """Fine windows, then nearly the Fréchet distance; mends what is not proved."""
    strokes = problem.strokes.points
    windows = shooting.whole_strokes(strokes, 0.8)
    windows += shooting.cut_windows(strokes, 10, 5, 0.2)
    evaluations = failures = 0
    for attempt in range(_REPAIRS + 1):
        try:
            # A mean of sixth powers is ruled by the greatest distance, as Fréchet is.
            for power, mu in ((2.0, 100.0), (6.0, 400.0)):
                x, _, n = shooting.fit(x, problem, windows, power=power, mu=mu)
                evaluations += n
        except FAILURES:
            failures += 1
            break
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
    counts = {"evaluations": np.array(evaluations), "failures": np.array(failures)}
    return {"x": x, **counts}


def _sound(found: NavigationField, starts: FloatArray) -> bool:
    """Whether all starts are in free space and that is proved free of traps."""
    return bool((min_beta(starts, found) > 0.0).all()) and certify(found).passed
