"""How well a stroke is foreseen that was not among those learned from."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bath_drake.composition.branch import nearest_branch
from bath_drake.composition.certify import certify_chain
from bath_drake.composition.rollout import chain_rollout
from bath_drake.errors import DemonstrationError
from bath_drake.field.rollout import RolloutStatus
from bath_drake.learning.checkpoint import Checkpoint, Under
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.cost import GOAL_TOLERANCE
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.learner import LearningResult, learn_skill
from bath_drake.learning.strokes import Stroke, resample
from bath_drake.notation import FloatArray


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Each demonstration against the skill learned from all the others.

    Of a search that was stopped it holds the demonstrations that were done by then.

    Attributes:
        names: Of the demonstrations, D of them.
        in_sample: Their Fréchet distances to the skill learned from all, over its
            scale; NaN for those that were left out as outliers.
        distances: To the skills learned without them, over the same scale.
        arrived: Whether that motion arrived.
        proved: Whether the chain it followed is proved.
        strokes: The demonstrations (T, 2) as they are compared, ending at the goal.
        paths: The motions, (n, 2) each.
        finished: Whether all demonstrations were held out once.
    """

    names: tuple[str, ...]
    in_sample: tuple[float, ...]
    distances: tuple[float, ...]
    arrived: tuple[bool, ...]
    proved: tuple[bool, ...]
    strokes: tuple[FloatArray, ...]
    paths: tuple[FloatArray, ...]
    finished: bool


def leave_one_out(
    demonstrations: Sequence[Stroke],
    result: LearningResult,
    progress: Callable[[float], None] | None = None,
    checkpoint: Checkpoint | None = None,
) -> HeldOut:
    """Learns as often as there are demonstrations, each time without one.

    Each is moved so that it ends at the goal of the skill it is held against, as in
    `bath_drake.benchmarks.reproduction`, and followed from its start.

    Args:
        demonstrations: Two or more, what ``result`` was learned from.
        result: The skill learned from all of them; its configuration is used again.
        progress: Called with the share done, 0 to 1.
        checkpoint: Where finished steps are kept; may be the one of ``result``.

    Raises:
        DemonstrationError: There is but one demonstration.
    """
    count = len(demonstrations)
    if count < 2:
        raise DemonstrationError(
            f"{demonstrations[0].name}: the only demonstration, to hold one out needs "
            "two or more"
        )
    checkpoint = checkpoint or Checkpoint()
    trials: list[_Trial] = []
    for i in range(count):

        def inner(done: int, total: int, _: float, i: int = i) -> None:
            if progress is not None:
                progress((i + done / max(total, 1)) / count)

        others = [d for j, d in enumerate(demonstrations) if j != i]
        steps = Under(checkpoint, f"without {i}")
        learned = learn_skill(others, result.config, inner, steps)
        if not learned.finished:
            break
        trials.append(_held_against(demonstrations[i], learned, result))
        if progress is not None:
            progress((i + 1) / count)
    done = len(trials)
    return HeldOut(
        names=tuple(d.name for d in demonstrations[:done]),
        in_sample=result.per_demonstration[:done],
        distances=tuple(t.distance for t in trials),
        arrived=tuple(t.arrived for t in trials),
        proved=tuple(t.proved for t in trials),
        strokes=tuple(t.stroke for t in trials),
        paths=tuple(t.path for t in trials),
        finished=done == count,
    )


@dataclass(frozen=True, eq=False)
class _Trial:
    distance: float
    arrived: bool
    proved: bool
    stroke: FloatArray
    path: FloatArray


def _held_against(
    demonstration: Stroke, learned: LearningResult, result: LearningResult
) -> _Trial:
    config: LearnerConfig = result.config
    stroke = resample(np.asarray(demonstration.points, dtype=np.float64), config.points)
    stroke = stroke + (learned.chain.goal - stroke[-1])
    start = stroke[0]
    chain = nearest_branch(learned.branches, start).chain_for(start)
    found = chain_rollout(start, chain, goal_tolerance=GOAL_TOLERANCE)
    return _Trial(
        distance=discrete_frechet(found.path, stroke) / result.scale,
        arrived=found.status is RolloutStatus.ARRIVED,
        proved=certify_chain(chain).passed,
        stroke=stroke,
        path=found.path,
    )
