"""Learning a skill: from strokes to a field whose flow reproduces them."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bath_drake.certificate.certify import certify
from bath_drake.certificate.result import Certificate
from bath_drake.errors import DemonstrationError
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import Workspace
from bath_drake.field.rollout import Rollout, RolloutStatus, rollout
from bath_drake.learning import genome, search
from bath_drake.learning.checkpoint import Checkpoint, Stopped
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.cost import GOAL_TOLERANCE, LearningProblem
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.seeding import obstacle_counts
from bath_drake.learning.strokes import Stroke, StrokeSet, gather_strokes
from bath_drake.notation import FloatArray

CONVERGED_FRECHET = 0.10
"""Greatest Fréchet distance to the mean, over the scale, that counts as learned."""

Progress = Callable[[int, int, float], None]
"""Called with steps done, steps in all, and the best cost so far."""


@dataclass(frozen=True, eq=False)
class LearningResult:
    """What learning gave.

    Attributes:
        field: The learned field.
        start: Mean start of the demonstrations, shape (2,), in N.
        scale: Longest side of the demonstrations' joint box, in N.
        frechet: Discrete Fréchet distances. 'to_mean': roll-out from the mean
            start to the demonstrations' arc-length mean; 'cost': the paper's C, each
            demonstration against the roll-out from its own start, mean;
            'floor': the demonstrations against their mean, mean; these over the
            scale. 'to_mean_raw': in units of N.
        per_demonstration: The terms of C over the scale.
        offsets: How far each demonstration was moved onto the common goal, (D, 2).
        cost_history: (members evaluated so far, best C over the scale so far).
        rollout: From the mean start.
        mean_demonstration: Shape (T, 2).
        certificate: Whether all free space is proved free of traps.
        converged: Whether every roll-out arrives, which puts every start in free
            space, the field is proved and 'to_mean' is at most 0.10.
        finished: Whether learning came to its end, not stopped before.
        failures: Members that were dropped because they had no finite cost.
        seconds: Time taken.
        config: What was asked for.
    """

    field: NavigationField
    start: FloatArray
    scale: float
    frechet: dict[str, float]
    per_demonstration: tuple[float, ...]
    offsets: FloatArray
    cost_history: tuple[tuple[int, float], ...]
    rollout: Rollout
    mean_demonstration: FloatArray
    certificate: Certificate
    converged: bool
    finished: bool
    failures: int
    seconds: float
    config: LearnerConfig


@dataclass(frozen=True, eq=False)
class _Judged:
    """A field and its figures."""

    field: NavigationField
    main: Rollout
    to_mean: float
    distances: tuple[float, ...]
    arrives: bool
    certificate: Certificate

    @property
    def valid(self) -> bool:
        """Whether the field is proved and every roll-out arrives."""
        return self.arrives and self.certificate.passed

    @property
    def rank(self) -> tuple[bool, float]:
        """Valid fields first, then the closer; an obstacle costs 0.0005."""
        badness = self.to_mean + float(np.mean(self.distances))
        return not self.valid, badness + 0.001 * len(self.field.obstacles)


def learn_skill(
    demonstrations: Sequence[Stroke],
    config: LearnerConfig | None = None,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
) -> LearningResult:
    """Finds virtual obstacles whose flow reproduces the demonstrations.

    The same demonstrations, configuration and seed give the same field, bit by bit,
    on one machine: on any number of its cores, and whether learning was interrupted
    and continued from its checkpoint or not.

    Args:
        demonstrations: Canonical strokes (see `strokes.Stroke`), one or more.
        config: Effort and method.
        progress: Told of every step.
        checkpoint: Keeps what has been computed; its `stop` ends learning with the
            best field so far.

    Returns:
        The best field found. A stroke that one field cannot hold, such as one that
        crosses itself, ends with ``converged`` False and the best there is.

    Raises:
        DemonstrationError: A stroke cannot be used, or leaves the workspace.
        CheckpointError: The checkpoint cannot be written.
    """
    begin = time.perf_counter()
    config = config or LearnerConfig()
    strokes = gather_strokes(demonstrations, config.points)
    radius = config.workspace_radius
    workspace = Workspace(np.zeros(2), np.array([radius, radius]))
    _check_reach(demonstrations, strokes, workspace)
    problem = LearningProblem(strokes, workspace, config.margins)
    counts = _counts(strokes, config)
    journal = search.Journal(
        len(counts), strokes.scale, progress, checkpoint or Checkpoint()
    )
    best: _Judged | None = None
    finished = True
    try:
        for count in counts:
            for field in search.candidates(problem, count, config, journal):
                judged = _judge(field, strokes)
                if best is None or judged.rank < best.rank:
                    best = judged
            if best is not None and best.valid and best.to_mean <= config.target:
                break
        journal.finish()
    except Stopped:
        finished = False
    if best is None or not finished:
        # The straight way to the goal, where there is nothing better yet.
        x = np.array([0.7]) if journal.best is None else journal.best
        judged = _judge(genome.decode(x, workspace, strokes.goal), strokes)
        if best is None or judged.rank < best.rank:
            best = judged
    return LearningResult(
        field=best.field,
        start=strokes.points[:, 0].mean(axis=0),
        scale=strokes.scale,
        frechet={
            "to_mean": best.to_mean,
            "to_mean_raw": best.to_mean * strokes.scale,
            "cost": float(np.mean(best.distances)),
            "floor": strokes.floor,
        },
        per_demonstration=best.distances,
        offsets=strokes.offsets,
        cost_history=tuple(journal.history),
        rollout=best.main,
        mean_demonstration=strokes.mean,
        certificate=best.certificate,
        converged=best.valid and best.to_mean <= CONVERGED_FRECHET,
        finished=finished,
        failures=journal.failures,
        seconds=time.perf_counter() - begin,
        config=config,
    )


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


def _counts(strokes: StrokeSet, config: LearnerConfig) -> tuple[int, ...]:
    """Numbers of obstacles to try, in turn."""
    if config.obstacles is not None:
        return (config.obstacles,)
    counts = obstacle_counts(strokes.mean)
    if config.method == "paper":
        # The paper fixes the number beforehand: two more than the bends.
        counts = (counts[min(2, len(counts) - 1)],)
    return counts


def _judge(field: NavigationField, strokes: StrokeSet) -> _Judged:
    """Figures of a field by the very roll-outs that reproduce it."""
    starts = strokes.points[:, 0]
    main = rollout(starts.mean(axis=0), field, goal_tolerance=GOAL_TOLERANCE)
    own = [rollout(s, field, goal_tolerance=GOAL_TOLERANCE) for s in starts]
    pairs = zip(own, strokes.points, strict=True)
    distances = tuple(discrete_frechet(r.path, d) / strokes.scale for r, d in pairs)
    return _Judged(
        field=field,
        main=main,
        to_mean=discrete_frechet(main.path, strokes.mean) / strokes.scale,
        distances=distances,
        arrives=all(r.status is RolloutStatus.ARRIVED for r in [main, *own]),
        certificate=certify(field),
    )
