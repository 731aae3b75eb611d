"""Learning a skill: from strokes to fields whose flow reproduces them."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bath_drake.composition.branch import Branch
from bath_drake.composition.chain import Chain
from bath_drake.composition.result import ChainCertificate
from bath_drake.composition.rollout import ChainRollout
from bath_drake.errors import DemonstrationError
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import Workspace
from bath_drake.learning import genome
from bath_drake.learning.alignment import align
from bath_drake.learning.chain import composer
from bath_drake.learning.chain.responses import fit_conditioning
from bath_drake.learning.checkpoint import Checkpoint, Steps, Stopped, Under
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.cost import LearningProblem
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.grouping import Outlier, group_strokes
from bath_drake.learning.journal import Journal
from bath_drake.learning.judge import Judged, judge
from bath_drake.learning.paper.candidates import paper_fields
from bath_drake.learning.single.search import single_fields
from bath_drake.learning.strokes import Stroke, StrokeSet, gather_strokes, subset
from bath_drake.learning.trace import Trace
from bath_drake.notation import FloatArray

CONVERGED_FRECHET = 0.10
"""Greatest Fréchet distance to the mean, over the scale, that counts as learned."""

# A single field may come nearer to demonstrations than their mean: its flow begins at
# their starts.
_WITHIN = 0.8

Progress = Callable[[int, int, float], None]
"""Called with steps done, steps in all, and the best cost so far (inf: none yet)."""


@dataclass(frozen=True, eq=False)
class LearningResult:
    """What learning gave.

    Attributes:
        branches: What was learned: one way of doing the stroke, or one for each way
            that the demonstrations go, the one with most of them first.
        certificates: Of each branch's chain for its mean start.
        scale: Longest side of the demonstrations' joint box, in N.
        frechet: Discrete Fréchet distances over the scale, means over the
            demonstrations. 'to_mean': roll-out from the mean start to the
            demonstrations' mean; 'cost': the paper's C, each demonstration against the
            roll-out from its own start; 'floor': the demonstrations against their mean.
            'to_mean_raw': in units of N.
        per_demonstration: The terms of C; NaN for outliers.
        offsets: How far each demonstration was moved onto the common goal, (D, 2).
        outliers: Demonstrations that were left out, each with the reason.
        cost_history: (members evaluated so far, best C over the scale so far).
        rollouts: From each branch's mean start.
        converged: Whether every roll-out arrives, every chain is proved (that of the
            mean start and those of the demonstrations' starts), 'to_mean' is at most
            0.10 for every branch, and learning was not stopped.
        finished: Whether learning came to its end; if not, this is the best so far.
        failures: Members that were dropped because they had no finite cost.
        seconds: Time taken.
        config: What was asked for.
        groups: Indices of the demonstrations of each branch.
        trace: What was tried.
    """

    branches: tuple[Branch, ...]
    certificates: tuple[ChainCertificate, ...]
    scale: float
    frechet: dict[str, float]
    per_demonstration: tuple[float, ...]
    offsets: FloatArray
    outliers: tuple[Outlier, ...]
    cost_history: tuple[tuple[int, float], ...]
    rollouts: tuple[ChainRollout, ...]
    converged: bool
    finished: bool
    failures: int
    seconds: float
    config: LearnerConfig
    groups: tuple[tuple[int, ...], ...]
    trace: Trace

    @property
    def start(self) -> FloatArray:
        """Mean start of the first branch, shape (2,), in N."""
        return self.branches[0].start

    @property
    def chain(self) -> Chain:
        """The first branch's, for its mean start."""
        return self.branches[0].chain

    @property
    def rollout(self) -> ChainRollout:
        """From the first branch's mean start."""
        return self.rollouts[0]

    @property
    def mean_demonstration(self) -> FloatArray:
        """The first branch's, shape (T, 2)."""
        return self.branches[0].mean

    @property
    def obstacle_count(self) -> int:
        """Of all fields of all branches."""
        return sum(branch.chain.obstacle_count for branch in self.branches)


def learn_skill(
    demonstrations: Sequence[Stroke],
    config: LearnerConfig | None = None,
    progress: Progress | None = None,
    checkpoint: Steps | None = None,
) -> LearningResult:
    """Finds virtual obstacles whose flow reproduces the demonstrations.

    The same demonstrations, configuration and seed give the same fields, bit by bit,
    on one machine, on any number of its cores and however often it was interrupted.

    Args:
        demonstrations: Canonical strokes (see `strokes.Stroke`), one or more.
        config: Effort and method.
        progress: Told of every step.
        checkpoint: Where finished steps are kept. If it is told to stop, learning
            returns the best so far.

    Returns:
        The best found. A stroke that could not be learned ends with ``converged``
        False and the best there is.

    Raises:
        DemonstrationError: A stroke cannot be used, or leaves the workspace.
        CheckpointError: The checkpoint's file cannot be written.
    """
    begin = time.perf_counter()
    config = config or LearnerConfig()
    checkpoint = checkpoint or Checkpoint()
    strokes = gather_strokes(demonstrations, config.points)
    radius = config.workspace_radius
    workspace = Workspace(np.zeros(2), np.array([radius, radius]))
    _check_reach(demonstrations, strokes, workspace)
    names = [stroke.name for stroke in demonstrations]
    groups, outliers = group_strokes(strokes.points, strokes.scale, names)
    journal = Journal(2 * len(groups), strokes.scale, progress)
    learned, finished = [], True
    for g, group in enumerate(groups):
        journal.turn_to(Under(checkpoint, f"group {g}"), g)
        task = _Task(subset(strokes, group), workspace, config, journal, g)
        best, stopped = task.learn()
        finished = finished and not stopped
        learned.append(best)
    if finished:
        journal.finish()
    distances = np.full(len(demonstrations), np.nan)
    floors = np.full(len(demonstrations), np.nan)
    for group, best in zip(groups, learned, strict=True):
        distances[group] = best.distances
        mean, points = best.branch.mean, strokes.points[group]
        floors[group] = [discrete_frechet(mean, p) / strokes.scale for p in points]
    shares = [len(group) for group in groups]
    to_mean = float(np.average([best.to_mean for best in learned], weights=shares))
    return LearningResult(
        branches=tuple(best.branch for best in learned),
        certificates=tuple(best.certificate for best in learned),
        scale=strokes.scale,
        frechet={
            "to_mean": to_mean,
            "to_mean_raw": to_mean * strokes.scale,
            "cost": float(np.nanmean(distances)),
            "floor": float(np.nanmean(floors)),
        },
        per_demonstration=tuple(distances.tolist()),
        offsets=strokes.offsets,
        outliers=outliers,
        cost_history=tuple(journal.history),
        rollouts=tuple(best.main for best in learned),
        converged=finished
        and all(best.valid and best.to_mean <= CONVERGED_FRECHET for best in learned),
        finished=finished,
        failures=journal.failures,
        seconds=time.perf_counter() - begin,
        config=config,
        groups=tuple(tuple(group.tolist()) for group in groups),
        trace=journal.trace,
    )


@dataclass(frozen=True, eq=False)
class _Task:
    """One way of doing the stroke, to be learned.

    Attributes:
        strokes: The demonstrations that go this way.
        workspace: Of every field.
        config: What was asked for.
        journal: Keeps steps and tells progress.
        number: Of the way, for the seeds.
    """

    strokes: StrokeSet
    workspace: Workspace
    config: LearnerConfig
    journal: Journal
    number: int

    def learn(self) -> tuple[Judged, bool]:
        """The best branch, and whether learning was stopped before its end."""
        best: Judged | None = None
        stopped = False
        try:
            for candidate in self._candidates():
                if best is None or candidate.rank < best.rank:
                    best = candidate
        except Stopped:
            stopped = True
        if best is None or (stopped and self.journal.best is not None):
            # The straight way to the goal, where there is nothing better yet.
            x = np.array([0.7]) if self.journal.best is None else self.journal.best
            field = genome.decode(x, self.workspace, self.strokes.goal)
            candidate = self._judged(field)
            if best is None or candidate.rank < best.rank:
                best = candidate
        return best, stopped

    def _candidates(self) -> Iterator[Judged]:
        best: Judged | None = None
        if self.config.composes:
            for judged in self._chains():
                if best is None or judged.rank < best.rank:
                    best = judged
                yield judged
        if self.config.fields != "many" and self._may_be_beaten(best):
            yield from self._singles()

    def _may_be_beaten(self, best: Judged | None) -> bool:
        """Whether a single field may be cheaper than the best chain.

        Not if the chain's price is far below what the demonstrations differ from
        their mean, be it moved as a whole to fit each start or not: a field that had
        just the mean for its motion would be dearer.
        """
        if best is None or not best.valid:
            return True
        aligned = align(self.strokes.points)
        whole = fit_conditioning(aligned, (0, len(aligned.mean) - 1))
        still, moved = [], []
        for stroke in self.strokes.points:
            (move,) = whole.similarities(stroke[0])
            still.append(discrete_frechet(aligned.mean, stroke))
            moved.append(discrete_frechet(move.points(aligned.mean), stroke))
        least = min(float(np.mean(still)), float(np.mean(moved))) / self.strokes.scale
        return best.price > _WITHIN * least

    def _chains(self) -> Iterator[Judged]:
        aligned = align(self.strokes.points)
        ways = composer.plans(aligned)
        self.journal.plan(sum(len(way.stages) + 1 for way in ways))
        for way in ways:
            branch, tried = composer.compose(
                aligned,
                way,
                self.workspace,
                self.config.margins,
                (self.config.seed, self.number),
                self.config.tries,
                self.journal.checkpoint,
                self.journal.tick,
                self.number,
            )
            judged = judge(branch, self.strokes.points, self.strokes.scale)
            self.journal.trace.plans.append((tried, judged.rank))
            self.journal.evaluations += tried.evaluations
            self.journal.enter(judged.cost)
            yield judged

    def _singles(self) -> Iterator[Judged]:
        problem = LearningProblem(self.strokes, self.workspace, self.config.margins)
        learn = paper_fields if self.config.method == "paper" else single_fields
        for field in learn(problem, self.config, self.journal):
            judged = self._judged(field)
            yield judged
            if len(self.strokes.points) > 1 and self.config.composes:
                yield self._following(judged.branch)

    def _following(self, branch: Branch) -> Judged:
        """The same field, turned and stretched as a whole to fit the start."""
        aligned = align(self.strokes.points, branch.mean)
        conditioning = fit_conditioning(aligned, (0, len(branch.mean) - 1))
        branch = replace(branch, conditioning=conditioning)
        return judge(branch, self.strokes.points, self.strokes.scale)

    def _judged(self, field: NavigationField) -> Judged:
        starts = self.strokes.points[:, 0]
        branch = Branch(Chain((field,)), starts.mean(axis=0), starts, self.strokes.mean)
        return judge(branch, self.strokes.points, self.strokes.scale)


def _check_reach(
    demonstrations: Sequence[Stroke], strokes: StrokeSet, workspace: Workspace
) -> None:
    """Refuses strokes that come too near to the workspace's rim, or beyond it."""
    for stroke, points in zip(demonstrations, strokes.points, strict=True):
        if (workspace.beta(points) <= 0.05).any():
            far = float(np.linalg.norm(points, axis=-1).max())
            raise DemonstrationError(
                f"{stroke.name}: with its end on the common goal the stroke reaches "
                f"{far:.3g} from the origin of N, allowed: "
                f"{0.95**0.5 * workspace.semi_axes[0]:.3g}"
            )
