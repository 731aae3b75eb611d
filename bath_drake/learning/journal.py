"""The journal of learning: its curve, its steps, its best, and who is told."""

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from bath_drake.learning.checkpoint import Arrays, Checkpoint, Steps
from bath_drake.learning.cost import LearningProblem
from bath_drake.learning.trace import Generation, Trace, places
from bath_drake.notation import FloatArray


@dataclass(eq=False)
class Journal:
    """Keeps the learning curve and the best member, and tells progress.

    Attributes:
        rounds: How many obstacle counts may be tried.
        scale: What costs are divided by.
        progress: Called with steps done, steps in all, the best cost (inf: none yet).
        checkpoint: Keeps what steps gave.
        history: (members evaluated, best C over the scale), ever better.
        evaluations: How many members were evaluated.
        failures: How many of them had no finite cost.
        best: The member of the lowest cost with its penalties, (P,), if there is any.
        trace: What was tried.
        way: Which way of doing the stroke is being learned.
    """

    rounds: int
    scale: float
    progress: Callable[[int, int, float], None] | None
    checkpoint: Steps = field(default_factory=Checkpoint)
    history: list[tuple[int, float]] = field(default_factory=list)
    evaluations: int = 0
    failures: int = 0
    best: FloatArray | None = None
    trace: Trace = field(default_factory=Trace)
    way: int = 0
    _least: float = np.inf
    _guard: threading.Lock = field(default_factory=threading.Lock)
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
        self.tick()

    def tick(self) -> None:
        """Says that a step is done; any thread may."""
        with self._guard:
            self._done += 1
            self._tell()

    def turn_to(self, checkpoint: Steps, way: int = 0) -> None:
        """Begins another way of doing the stroke, with steps of its own."""
        self.checkpoint = checkpoint
        self.best, self._least = None, np.inf
        self.way = way

    def watch(
        self,
        name: str,
        problem: LearningProblem,
        costs: FloatArray,
        centres: Sequence[FloatArray],
    ) -> None:
        """Traces a step's members by their costs (n,), sorted, and obstacles (Q, 2)."""
        ends = np.cumsum([len(each) for each in centres])
        beside = places(
            problem.strokes.mean, np.concatenate([np.empty((0, 2)), *centres])
        )
        known = [tuple(sorted(part.tolist())) for part in np.split(beside, ends)]
        self.trace.generations.append(
            Generation(self.way, name, costs, tuple(known[: len(centres)]))
        )

    def finish(self) -> None:
        """Says that no further step comes."""
        self._done = self._total
        self._tell()

    def _tell(self) -> None:
        if self.progress is not None:
            best = self.history[-1][1] if self.history else np.inf
            self.progress(self._done, self._total, best)
