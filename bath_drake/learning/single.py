"""The best single field for a stroke: a population over branches and counts.

Members of several numbers of obstacles live in one population and are compared by
one criterion, the windows' cost and a penalty for each obstacle: so their number is
found. The first members come from the tree of sides; children gain an obstacle, lose
one, have one put elsewhere, or are bred of two parents; every child descends by
multiple shooting. The best few are finished on all demonstrations, and mended until
they are proved.
"""

from dataclasses import dataclass, replace

import numpy as np

from bath_drake.certificate.certify import certify
from bath_drake.field.navigation import NavigationField, min_beta
from bath_drake.learning import genome, shooting
from bath_drake.learning.branches import Tree
from bath_drake.learning.checkpoint import Arrays, Checkpoint
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.cost import LearningProblem
from bath_drake.learning.genetic import crossover, mutate
from bath_drake.learning.search import Journal
from bath_drake.learning.seeding import MAX_OBSTACLES, bends
from bath_drake.learning.shooting import Windows
from bath_drake.notation import FloatArray
from bath_drake.threads import parallel_map

_PENALTY = 0.001  # for each obstacle, in N
_UNPROVED = 0.03  # for a member that is not proved, in N
_WIDTH = 8  # branches that go on from each depth of the tree
_STAGES = 12  # in which the stroke's end grows to the whole
_FINALISTS = 3
_REPAIRS = 2


@dataclass(frozen=True, eq=False)
class Population:
    """Members of different sizes and what they cost, the best first.

    Attributes:
        members: Vectors (5 Q + 1,), each with its own Q.
        costs: The windows' cost and the penalty, shape (n,).
    """

    members: tuple[FloatArray, ...]
    costs: FloatArray

    @classmethod
    def of(cls, members: list[FloatArray], costs: FloatArray) -> "Population":
        """Sorts members by their cost."""
        order = np.argsort(costs, kind="stable")
        return cls(tuple(members[i] for i in order), costs[order])

    def distinct(self, size: int) -> "Population":
        """The best ``size`` that are not copies of a better one."""
        kept: list[int] = []
        for i, cost in enumerate(self.costs):
            # Members of one basin have nearly one cost after their descent.
            if all(
                abs(cost - self.costs[k]) > 0.005 * cost
                or len(self.members[i]) != len(self.members[k])
                for k in kept
            ):
                kept.append(i)
        kept = kept[:size]
        return Population(tuple(self.members[i] for i in kept), self.costs[kept])

    def pack(self) -> Arrays:
        """As arrays of one size, for a checkpoint."""
        padded = np.full((len(self.members), genome.GENES * MAX_OBSTACLES + 1), np.nan)
        for row, member in zip(padded, self.members, strict=True):
            row[: len(member)] = member
        return {"members": padded, "costs": self.costs}

    @classmethod
    def unpack(cls, arrays: Arrays) -> "Population":
        """What `pack` gave."""
        members = tuple(row[~np.isnan(row)].copy() for row in arrays["members"])
        return cls(members, arrays["costs"].copy())


def single_fields(
    problem: LearningProblem,
    config: LearnerConfig,
    journal: Journal,
    checkpoint: Checkpoint | None = None,
) -> list[NavigationField]:
    """Learned fields, at least one, for a judge to rank; most are proved.

    Args:
        problem: What is to be learned.
        config: ``population`` members (None: 20), ``generations`` (None: 12), the
            number of obstacles (None: it is found), the seed.
        journal: What it has ``learned`` joins the first population.
        checkpoint: Where finished generations are kept.
    """
    checkpoint = checkpoint or Checkpoint()
    search = _Search(problem, config, journal)
    generations = 12 if config.generations is None else config.generations
    journal.plan(generations + 2)
    arrays = checkpoint.step("single/first", lambda: search.first().pack())
    found = Population.unpack(arrays)
    journal.note(problem, found.members[0])
    for g in range(generations):
        last = found
        arrays = checkpoint.step(
            f"single/{g}", lambda g=g, last=last: search.next(last, g).pack()
        )
        found = Population.unpack(arrays)
        journal.note(problem, found.members[0])
    arrays = checkpoint.step("single/finish", lambda: search.finish(found).pack())
    found = Population.unpack(arrays)
    journal.note(problem, found.members[0])
    journal.learned = list(found.members[:2])
    return [
        genome.decode(x, problem.workspace, problem.strokes.goal) for x in found.members
    ]


class _Search:
    def __init__(
        self, problem: LearningProblem, config: LearnerConfig, journal: Journal
    ) -> None:
        self._problem = problem
        self._config = config
        self._journal = journal
        self._known = list(journal.learned)
        self._size = 20 if config.population is None else config.population
        self._tree = Tree(problem, max(16, config.seeds // 4))
        mean = _thinned(problem.strokes.mean[None], 48)
        every = _thinned(problem.strokes.points, 48)
        self._near = shooting.cut_windows(mean, 4, 2)
        self._far = shooting.cut_windows(mean, 12, 3, 0.4)
        self._far += shooting.whole_strokes(every, 0.6)
        count = config.obstacles
        self._most = MAX_OBSTACLES if count is None else count
        self._depth = min(self._most, len(bends(problem.strokes.mean)) + 3)

    def first(self) -> Population:
        """Branches by the flow's direction, and others grown from the goal backwards."""
        rng = np.random.default_rng([self._config.seed, 0])
        seeds = [*self._known, *self._by_direction(rng), *self._from_goal(rng)]
        seeds = [self._sized(x, rng) for x in seeds]
        return self._descend(seeds, self._far, 10, prove=True).distinct(self._size)

    def _by_direction(self, rng: np.random.Generator) -> list[FloatArray]:
        """The tree's best branches, at every depth, after a descent of short steps."""
        branches = [self._tree.root()]
        seeds = [branches[0].member]
        for _ in range(self._depth):
            branches = self._tree.grow(branches, _WIDTH, rng)
            seeds += [b.member for b in branches]
        near = self._descend(seeds, self._near, 6).members
        rated = Population.of(list(near), self._costs(near))
        return list(rated.distinct(self._size).members)

    def _from_goal(self, rng: np.random.Generator) -> list[FloatArray]:
        """Members that learned ever longer ends of the stroke.

        Where the flow comes from the end is settled first; what is added leads into
        what works already. Every stage offers an obstacle more, on either side.
        """
        found = Population((self._tree.root().member,), np.zeros(1))
        for stage in range(1, _STAGES + 1):
            begin = 1.0 - stage / _STAGES
            members = list(found.members)
            for x in found.members:
                members += self._insert(x, rng, 3, begin)
            fitted = self._descend(members, self._ends(begin), 10)
            found = fitted.distinct(_WIDTH)
        return list(found.members)

    def _sized(self, x: FloatArray, rng: np.random.Generator) -> FloatArray:
        """x with the number of obstacles that is asked for, if one is."""
        wanted = self._config.obstacles
        if wanted is None:
            return x
        while genome.obstacle_count(x) < wanted:
            x = self._tree.grow([self._tree.root(x)], 1, rng)[0].member
        while genome.obstacle_count(x) > wanted:
            x = self._lighter(x)
        return x

    def _ends(self, begin: float) -> Windows:
        strokes = self._problem.strokes
        first = min(int(begin * strokes.mean.shape[0]), strokes.mean.shape[0] - 8)
        count = max(8, round(48 * (1.0 - begin)))
        mean = _thinned(strokes.mean[None, first:], count)
        every = _thinned(strokes.points[:, first:], count)
        windows = shooting.cut_windows(mean, min(12, count - 2), 3, 0.4)
        return windows + shooting.whole_strokes(every, 0.6)

    def next(self, population: Population, number: int) -> Population:
        """One generation more; the best member never gets worse."""
        rng = np.random.default_rng([self._config.seed, number + 1])
        children: list[FloatArray] = []
        n = len(population.members)
        scale = 0.3 * 0.85**number
        while len(children) < self._size:
            # Sorted: the smaller of two indices drawn wins.
            x = population.members[int(rng.integers(n, size=2).min())]
            draw = rng.random()
            count = genome.obstacle_count(x)
            fixed = self._config.obstacles is not None
            if count > 0 and draw < 0.15:
                x = _without(x, int(rng.integers(count)))
                children += self._insert(x, rng, 2)
            elif draw < 0.5 and count < self._most:
                children += self._insert(x, rng, 2)
            elif draw < 0.65 and count > 0 and not fixed:
                children.append(self._lighter(x))
            else:
                y = population.members[int(rng.integers(n, size=2).min())]
                if len(x) == len(y):
                    x = crossover(x, y, rng)
                children.append(mutate(x, 0.5, scale, rng))
        elite = list(population.members[: max(1, self._size // 4)])
        members = [*children[: self._size], *elite]
        grown = self._descend(members, self._far, 10, prove=True)
        both = [*grown.members, *population.members]
        costs = np.concatenate([grown.costs, population.costs])
        return Population.of(both, costs).distinct(self._size)

    def finish(self, population: Population) -> Population:
        """The best few, on all demonstrations, mended until they are proved."""
        best = population.distinct(_FINALISTS).members
        finished = parallel_map(lambda x: _finish(x, self._problem), best)
        self._journal.evaluations += sum(n for _, n in finished)
        done = [x for x, _ in finished]
        costs = np.array(
            [
                float(self._problem.evaluate(x[None], grid=False).total[0])
                + _PENALTY * genome.obstacle_count(x)
                for x in done
            ]
        )
        return Population.of(done, costs)

    def _insert(
        self, x: FloatArray, rng: np.random.Generator, width: int, begin: float = 0.0
    ) -> list[FloatArray]:
        """Children with an obstacle more, in the places where it helps most."""
        if genome.obstacle_count(x) >= self._most:
            return []
        grown = self._tree.grow([self._tree.root(x)], width, rng, begin)
        return [b.member for b in grown]

    def _lighter(self, x: FloatArray) -> FloatArray:
        """x without the obstacle that is missed least."""
        fewer = [_without(x, i) for i in range(genome.obstacle_count(x))]
        return fewer[int(np.argmin(self._costs(fewer)))]

    def _costs(self, members: list[FloatArray] | tuple[FloatArray, ...]) -> FloatArray:
        self._journal.evaluations += len(members)
        return np.array(
            [
                # Light hinges: a seed that overlaps a little is easily mended.
                float(
                    shooting.shooting_cost(x[None], self._problem, self._far, 2.0, 2.0)[
                        0
                    ]
                )
                + _PENALTY * genome.obstacle_count(x)
                for x in members
            ]
        )

    def _descend(
        self,
        members: list[FloatArray],
        windows: Windows,
        iterations: int,
        *,
        prove: bool = False,
    ) -> Population:
        def descend(x: FloatArray) -> tuple[FloatArray, float, int]:
            x, cost, n = shooting.fit(
                x, self._problem, windows, mu=20.0, iterations=iterations
            )
            cost += _PENALTY * genome.obstacle_count(x)
            if prove and not _proved(x, self._problem):
                cost += _UNPROVED
            return x, cost, n

        fits = parallel_map(descend, members)
        self._journal.evaluations += sum(n for _, _, n in fits)
        return Population.of([x for x, _, _ in fits], np.array([c for _, c, _ in fits]))


def _thinned(curves: FloatArray, count: int) -> FloatArray:
    """Strokes (D, T, 2) at ``count`` of their points."""
    at = np.linspace(0, curves.shape[1] - 1, count).round().astype(int)
    return np.ascontiguousarray(curves[:, at])


def _without(x: FloatArray, index: int) -> FloatArray:
    """A member (5 Q + 1,) less one obstacle."""
    rows = x[:-1].reshape(-1, genome.GENES)
    return np.append(np.delete(rows, index, axis=0).ravel(), x[-1])


def _finish(x: FloatArray, problem: LearningProblem) -> tuple[FloatArray, int]:
    """Fine windows, then nearly the Fréchet distance, as far as it stays proved.

    What is not proved gets wider slits and a larger kappa: both take spurious minima.
    """
    strokes = _thinned(problem.strokes.points, 80)
    windows = shooting.whole_strokes(strokes, 0.8)
    windows += shooting.cut_windows(strokes, 10, 5, 0.2)
    evaluations = 0
    stages = [x]
    for _ in range(_REPAIRS + 1):
        # A mean of sixth powers is ruled by the greatest distance, as Fréchet is.
        for power, mu in ((2.0, 100.0), (6.0, 400.0)):
            x, _, n = shooting.fit(x, problem, windows, power=power, mu=mu)
            evaluations += n
            stages.append(x)
        proved = [y for y in stages if _proved(y, problem)]
        if proved:
            costs = problem.evaluate(np.stack(proved), grid=False).demonstration_cost
            return proved[int(np.argmin(costs))], evaluations
        m = problem.margins
        wider = replace(
            m,
            pair=m.pair + 0.02,
            rim=m.rim + 0.1,
            kappa=1.2 * float(np.exp(x[-1])) / max(1, genome.obstacle_count(x)),
            curvature=m.curvature + 0.2,
        )
        problem = replace(problem, margins=wider)
    return x, evaluations


def _proved(x: FloatArray, problem: LearningProblem) -> bool:
    """Whether all starts are in free space and that is proved free of traps."""
    found = genome.decode(x, problem.workspace, problem.strokes.goal)
    starts = problem.strokes.points[:, 0]
    return bool((min_beta(starts, found) > 0.0).all()) and certify(found).passed
