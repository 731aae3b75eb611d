"""Learning a skill: from strokes to a field whose flow reproduces them."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bath_drake.field.critical_points import FieldCheck, check_field
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import Workspace
from bath_drake.field.rollout import Rollout, RolloutStatus, rollout
from bath_drake.learning import search
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
        check: The numeric search for spurious critical points.
        converged: Whether every roll-out arrives, the check passes and 'to_mean'
            is at most 0.10.
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
    check: FieldCheck
    converged: bool
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
    check: FieldCheck

    @property
    def rank(self) -> tuple[bool, float]:
        """Valid fields first, then the closer; an obstacle costs 0.0005."""
        valid = self.arrives and self.check.passed
        badness = self.to_mean + float(np.mean(self.distances))
        return not valid, badness + 0.001 * len(self.field.obstacles)


def learn_skill(
    demonstrations: Sequence[Stroke],
    config: LearnerConfig | None = None,
    progress: Progress | None = None,
) -> LearningResult:
    """Finds virtual obstacles whose flow reproduces the demonstrations.

    The same demonstrations, configuration and seed give the same field, bit by bit,
    on one machine.

    Args:
        demonstrations: Canonical strokes (see `strokes.Stroke`), one or more.
        config: Effort and method.
        progress: Told of every step.

    Returns:
        The best field found. A stroke that one field cannot hold, such as one that
        crosses itself, ends with ``converged`` False and the best there is.

    Raises:
        DemonstrationError: A stroke cannot be used.
        ValueError: A stroke leaves the configured workspace.
    """
    begin = time.perf_counter()
    config = config or LearnerConfig()
    strokes = gather_strokes(demonstrations, config.points)
    radius = config.workspace_radius
    workspace = Workspace(np.zeros(2), np.array([radius, radius]))
    if (workspace.beta(strokes.points) <= 0.05).any():
        far = float(np.linalg.norm(strokes.points, axis=-1).max())
        raise ValueError(
            f"a stroke reaches {far:.3g} from the origin of N, "
            f"too far for a workspace of radius {radius:.3g}"
        )
    problem = LearningProblem(strokes, workspace, config.margins)
    asked = config.obstacles
    counts = obstacle_counts(strokes.mean) if asked is None else (asked,)
    if config.method == "paper" and asked is None:
        # The paper fixes the number beforehand: two more than the bends.
        counts = (counts[min(2, len(counts) - 1)],)
    journal = search.Journal(len(counts), strokes.scale, progress)
    rng = np.random.default_rng(config.seed)
    best: _Judged | None = None
    for count in counts:
        for field in search.candidates(problem, count, config, rng, journal):
            judged = _judge(field, strokes)
            if best is None or judged.rank < best.rank:
                best = judged
        if best is not None and not best.rank[0] and best.to_mean <= config.target:
            break
    assert best is not None  # counts and candidates are never empty
    journal.finish()
    good = best.arrives and best.check.passed
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
        check=best.check,
        converged=good and best.to_mean <= CONVERGED_FRECHET,
        seconds=time.perf_counter() - begin,
        config=config,
    )


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
        check=check_field(field, starts),
    )
