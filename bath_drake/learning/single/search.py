"""The best single field for a stroke: a population over branches and counts.

Members of several numbers of obstacles live in one population and are compared by
one criterion, the windows' cost and C with a penalty for each obstacle: so their
number is found. The first members come from the tree of sides; children gain an
obstacle, lose one, have one put elsewhere, or are bred of two parents; every child
descends by multiple shooting, and one that is not proved free of traps pays for it.
The best few are finished on all demonstrations, as far as they stay proved.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from bath_drake.certificate.certify import certify
from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.learning import genome, shooting
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.cost import LearningProblem
from bath_drake.learning.failures import FAILURES, costs_of
from bath_drake.learning.journal import Journal
from bath_drake.learning.seeding import MAX_OBSTACLES, bends
from bath_drake.learning.shooting import Windows
from bath_drake.learning.single.genetic import crossover, mutate
from bath_drake.learning.single.population import Population
from bath_drake.learning.single.sides import Tree
from bath_drake.notation import FloatArray
from bath_drake.threads import parallel_map

_PENALTY = 0.001  # for each obstacle, in N
_UNPROVED = 0.1  # for a member that is not proved, in N
_WIDTH = 8  # branches that go on from each depth of the tree
_STAGES = 12  # in which the stroke's end grows to the whole
_COARSE = 48  # points of a stroke will do while the basin is sought
_FINALISTS = 3
_REPAIRS = 2


def single_fields(
    problem: LearningProblem, config: LearnerConfig, journal: Journal
) -> list[NavigationField]:
    """Learned fields for a judge to rank, usually some, most of them proved.

    ``config.obstacles`` says how many obstacles they have; None lets the search find
    it.
    """
    search = _Search(problem, config, journal)
    generations = 12 if config.generations is None else config.generations
    journal.plan(generations + 3)
    # C cannot fall far below the demonstrations' own spread, and finishing lowers it.
    enough = config.target + min(0.25 * problem.strokes.floor, config.target)
    found = search.step("by direction", search.by_direction)
    if search.reached > enough:
        found = search.step("from the goal", partial(search.from_goal, found))
    for g in range(generations):
        if search.reached <= enough or not found.members:
            break
        found = search.step(f"generation {g}", partial(search.next, found, g))
    found = search.step("finish", partial(search.finish, found))
    goal = problem.strokes.goal
    return [genome.decode(x, problem.workspace, goal) for x in found.members]


class _Search:
    """The steps of the search; each depends on its arguments and the seed alone."""

    def __init__(
        self, problem: LearningProblem, config: LearnerConfig, journal: Journal
    ) -> None:
        self.reached = np.inf
        """The least C over the scale that a step's best member had."""
        self._problem = problem
        self._config = config
        self._journal = journal
        self._size = 24 if config.population is None else config.population
        self._most = MAX_OBSTACLES if config.obstacles is None else config.obstacles
        self._tree = Tree(problem, config.seeds)
        mean = _thinned(problem.strokes.mean[None], _COARSE)
        every = _thinned(problem.strokes.points, _COARSE)
        self._near = shooting.cut_windows(mean, 4, 2)
        self._far = shooting.cut_windows(mean, 12, 3, 0.4)
        self._far += shooting.whole_strokes(every, 0.6)

    def step(self, key: str, compute: Callable[[], Population]) -> Population:
        """Computes a population, or takes it from the checkpoint; notes its best."""
        arrays = self._journal.step(f"single: {key}", lambda: compute().pack())
        found = Population.unpack(arrays)
        centres = [x[:-1].reshape(-1, genome.GENES)[:, :2] for x in found.members]
        self._journal.watch(key, self._problem, found.costs, centres)
        if found.members:
            cost = self._journal.note(self._problem, found.members[0])
            self.reached = min(self.reached, cost)
        return found

    def next(self, population: Population, number: int) -> Population:
        """One generation more; the best member never gets worse."""
        rng = np.random.default_rng([self._config.seed, number + 2])
        scale = 0.3 * 0.85**number
        children: list[FloatArray] = []
        while population.members and len(children) < self._size:
            children += self._children(population, scale, rng)
        # The elite goes through the descent again: each generation takes it further.
        elite = population.members[: max(1, self._size // 4)]
        members = (*children[: self._size], *elite)
        full = len(population.members) == self._size
        worst = float(population.costs[-1]) if full else np.inf
        grown = self._judge(self._descend(members, self._far), worst)
        return (population + grown).distinct(self._size)

    def finish(self, population: Population) -> Population:
        """The best few, on all demonstrations, mended until they are proved."""

        def finish(x: FloatArray) -> tuple[FloatArray, float, int]:
            try:
                return finished(x, self._problem)
            except FAILURES:
                return x, np.inf, 1

        left = population.members
        done = Population((), np.empty(0))
        while left and not any(proved(x, self._problem) for x in done.members):
            done += self._gathered(parallel_map(finish, left[:_FINALISTS]))
            left = left[_FINALISTS:]
        return done

    def by_direction(self) -> Population:
        """The tree's best branches of every depth, after their descent."""
        rng = np.random.default_rng([self._config.seed, 0])
        branches = [self._tree.root()]
        seeds = [branches[0].member]
        deepest = len(bends(self._problem.strokes.mean)) + 3
        for _ in range(min(self._most, deepest)):
            branches = self._tree.grow(branches, _WIDTH, rng)
            seeds += [b.member for b in branches]
        near = self._descend(seeds, self._near, 6).members
        best = Population.of(near, self._costs(near)).distinct(self._size).members
        return self._first(best, rng)

    def from_goal(self, population: Population) -> Population:
        """Members that learned ever longer ends of the stroke, beside those there are.

        Where the flow comes from the end is settled first; what is added leads into
        what works already. Every stage offers an obstacle more, on either side.
        """
        rng = np.random.default_rng([self._config.seed, 1])
        found = Population((self._tree.root().member,), np.zeros(1))
        for stage in range(1, _STAGES + 1):
            begin = 1.0 - stage / _STAGES
            members = list(found.members)
            for x in found.members:
                members += self._insert(x, rng, 3, begin)
            found = self._descend(members, self._end(begin)).distinct(_WIDTH)
        return (population + self._first(found.members, rng)).distinct(self._size)

    def _first(
        self, members: Sequence[FloatArray], rng: np.random.Generator
    ) -> Population:
        """Members as their first generation, after a descent on whole strokes."""
        seeds = [self._sized(x, rng) for x in members]
        return self._judge(self._descend(seeds, self._far)).distinct(self._size)

    def _end(self, begin: float) -> Windows:
        """Windows on what lies behind the share ``begin`` of the stroke."""
        strokes = self._problem.strokes
        first = min(int(begin * len(strokes.mean)), len(strokes.mean) - 8)
        count = max(8, round(_COARSE * (1.0 - begin)))
        mean = _thinned(strokes.mean[None, first:], count)
        every = _thinned(strokes.points[:, first:], count)
        windows = shooting.cut_windows(mean, min(12, count - 2), 3, 0.4)
        return windows + shooting.whole_strokes(every, 0.6)

    def _sized(self, x: FloatArray, rng: np.random.Generator) -> FloatArray:
        """A member with as many obstacles as are asked for, if a number is."""
        wanted = self._config.obstacles
        while wanted is not None and genome.obstacle_count(x) < wanted:
            x = self._insert(x, rng, 1)[0]
        while wanted is not None and genome.obstacle_count(x) > wanted:
            x = self._lighter(x)
        return genome.clip(x, self._problem.workspace)

    def _children(
        self, population: Population, scale: float, rng: np.random.Generator
    ) -> list[FloatArray]:
        """One way or another to change a member that is drawn, the better likelier."""

        def parent() -> FloatArray:
            # The population is sorted: the smaller index drawn wins.
            return population.members[
                int(rng.integers(len(population.members), size=2).min())
            ]

        x = parent()
        count = genome.obstacle_count(x)
        draw = rng.random()
        if draw < 0.15 and count > 0:
            return self._insert(_without(x, int(rng.integers(count))), rng, 2)
        if draw < 0.5 and count < self._most:
            return self._insert(x, rng, 2)
        if draw < 0.65 and count > 0 and self._config.obstacles is None:
            return [self._lighter(x)]
        y = parent()
        if len(x) == len(y):
            x = crossover(x, y, rng)
        return [mutate(x, 0.5, scale, rng)]

    def _insert(
        self, x: FloatArray, rng: np.random.Generator, width: int, begin: float = 0.0
    ) -> list[FloatArray]:
        """Members with an obstacle more, in the places where it helps most."""
        if genome.obstacle_count(x) >= self._most:
            return []
        grown = self._tree.grow([self._tree.root(x)], width, rng, begin)
        return [branch.member for branch in grown]

    def _lighter(self, x: FloatArray) -> FloatArray:
        """A member without the obstacle that is missed least."""
        fewer = [_without(x, i) for i in range(genome.obstacle_count(x))]
        return fewer[int(np.argmin(self._costs(fewer)))]

    def _costs(self, members: Sequence[FloatArray]) -> FloatArray:
        """The criterion of members that have not descended, shape (n,)."""

        def cost(xs: FloatArray) -> FloatArray:
            # Light hinges: a seed that overlaps a little is easily mended.
            found = shooting.shooting_cost(xs, self._problem, self._far, 2.0, 2.0)
            return found + _PENALTY * genome.obstacle_count(xs)

        parts = parallel_map(lambda x: costs_of(cost, x[None]), members)
        return self._journal.count(np.array(parts).reshape(-1))

    def _descend(
        self, members: Sequence[FloatArray], windows: Windows, iterations: int = 10
    ) -> Population:
        """Members after multiple shooting; the windows' cost and the obstacles'."""

        def descend(x: FloatArray) -> tuple[FloatArray, float, int]:
            try:
                x, cost, count = shooting.fit(
                    x, self._problem, windows, mu=20.0, iterations=iterations
                )
            except FAILURES:
                return x, np.inf, 1
            return x, cost + _PENALTY * genome.obstacle_count(x), count

        return self._gathered(parallel_map(descend, members))

    def _judge(self, population: Population, worst: float = np.inf) -> Population:
        """With C in the costs, and what being unproved costs.

        Above ``worst`` no member is kept: what costs more is not worth a proof.
        """

        def judged(k: int) -> float:
            x, cost = population.members[k], float(population.costs[k])
            cost += float(self._problem.evaluate(x[None], grid=False).total[0])
            if cost < worst and proved(x, self._problem):
                return cost
            return cost + _UNPROVED

        costs = parallel_map(judged, range(len(population.members)))
        return Population.of(population.members, np.array(costs))

    def _gathered(self, found: list[tuple[FloatArray, float, int]]) -> Population:
        """Members, their costs and the evaluations each took, as a population."""
        costs = self._journal.count(np.array([cost for _, cost, _ in found]))
        self._journal.evaluations += sum(count - 1 for _, _, count in found)
        return Population.of([x for x, _, _ in found], costs)


def finished(x: FloatArray, problem: LearningProblem) -> tuple[FloatArray, float, int]:
    """Fine windows, then nearly the Fréchet distance, as far as it stays proved.

    Returns the member, its C with the penalties, and the evaluations that took. What
    is not proved gets wider slits and a larger kappa: both take spurious minima away.
    """
    strokes = _thinned(problem.strokes.points, problem.strokes.points.shape[1] // 2)
    windows = shooting.whole_strokes(strokes, 0.8)
    windows += shooting.cut_windows(strokes, 10, 5, 0.2)
    tried = problem
    stages = [x]
    evaluations = 0
    for _ in range(_REPAIRS + 1):
        # A mean of sixth powers is ruled by the greatest distance, as Fréchet is.
        for power, mu in ((2.0, 100.0), (6.0, 400.0)):
            x, _, count = shooting.fit(x, tried, windows, power=power, mu=mu)
            evaluations += count
            stages.append(x)
        sound = [y for y in stages if proved(y, problem)]
        if sound:
            break
        m = tried.margins
        wider = replace(
            m,
            pair=m.pair + 0.02,
            rim=m.rim + 0.1,
            kappa=1.2 * float(np.exp(x[-1])) / max(1, genome.obstacle_count(x)),
            curvature=m.curvature + 0.2,
        )
        tried = replace(tried, margins=wider)
    costs = problem.evaluate(np.stack(sound or stages), grid=False).total
    best = int(np.argmin(costs))
    return (sound or stages)[best], float(costs[best]), evaluations


def proved(x: FloatArray, problem: LearningProblem) -> bool:
    """Whether all starts are in free space and that is proved free of traps."""
    found = genome.decode(x, problem.workspace, problem.strokes.goal)
    starts = problem.strokes.points[:, 0]
    return bool((min_beta(starts, found) > 0.0).all()) and certify(found).passed


def _thinned(curves: FloatArray, count: int) -> FloatArray:
    """Strokes (D, T, 2) at ``count`` of their points."""
    at = np.linspace(0, curves.shape[1] - 1, count).round().astype(int)
    return np.ascontiguousarray(curves[:, at])


def _without(x: FloatArray, index: int) -> FloatArray:
    """A member (5 Q + 1,) less one obstacle."""
    rows = x[:-1].reshape(-1, genome.GENES)
    return np.append(np.delete(rows, index, axis=0).ravel(), x[-1])
