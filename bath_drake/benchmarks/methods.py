"""The learner under the benchmark's protocol, and the simplest things beside it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bath_drake.benchmarks.reproduction import Learned, Method, Shape
from bath_drake.composition.branch import nearest_branch
from bath_drake.composition.certify import certify_chain
from bath_drake.composition.chain import Chain
from bath_drake.composition.rollout import chain_rollout
from bath_drake.demonstrations.processing import CANONICAL_SPAN
from bath_drake.learning.config import LearnerConfig
from bath_drake.learning.cost import GOAL_TOLERANCE
from bath_drake.learning.learner import learn_skill
from bath_drake.notation import FloatArray


@dataclass(frozen=True, eq=False)
class _Stroke:
    name: str
    points: FloatArray
    sha256: str = ""


def learner(config: LearnerConfig) -> Method:
    """The project's own learner, in canonical space as for any planar stroke."""

    def fit(shape: Shape) -> Learned:
        joint = np.concatenate([d.points for d in shape.demonstrations])
        low, high = joint.min(axis=0), joint.max(axis=0)
        middle = (low + high) / 2.0
        scale = CANONICAL_SPAN / float((high - low).max())
        result = learn_skill(
            [
                _Stroke(f"{shape.name} {i}", (d.points - middle) * scale)
                for i, d in enumerate(shape.demonstrations, start=1)
            ],
            config,
        )

        def chain_from(start: FloatArray) -> tuple[FloatArray, Chain]:
            own = (start - middle) * scale
            return own, nearest_branch(result.branches, own).chain_for(own)

        def roll_out(start: FloatArray) -> FloatArray:
            own, chain = chain_from(start)
            found = chain_rollout(own, chain, goal_tolerance=GOAL_TOLERANCE)
            path: FloatArray = found.path / scale + middle
            return path

        return Learned(
            roll_out,
            all(certificate.passed for certificate in result.certificates),
            float(result.obstacle_count),
            lambda start: certify_chain(chain_from(start)[1]).passed,
        )

    return fit


def straight_line(shape: Shape) -> Learned:
    """From the start to the goal."""
    return Learned(lambda start: np.stack([start, np.zeros(2)]))


def mean_demonstration(shape: Shape) -> Learned:
    """The demonstrations' mean, wherever the start is."""
    return Learned(_always(shape.mean))


def blended_mean(shape: Shape) -> Learned:
    """The mean, moved to the start; the offset fades evenly along the way."""
    mean = shape.mean
    left = np.linspace(1.0, 0.0, len(mean))[:, None]
    return Learned(lambda start: mean + left * (start - mean[0]))


def _always(path: FloatArray) -> Callable[[FloatArray], FloatArray]:
    return lambda start: path
