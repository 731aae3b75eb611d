"""What a learned branch is worth, by the very roll-outs that reproduce it."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from bath_drake.composition.branch import Branch
from bath_drake.composition.certify import certify_chain
from bath_drake.composition.result import ChainCertificate
from bath_drake.composition.rollout import ChainRollout, chain_rollout
from bath_drake.field.rollout import RolloutStatus
from bath_drake.learning.cost import GOAL_TOLERANCE
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.notation import FloatArray

OBSTACLE_PRICE: Final = 0.0005
"""By what an obstacle must lower the two Fréchet distances to pay for itself."""
STAGE_PRICE: Final = 0.001
"""By what a field more must, its obstacles not counted."""
STRAY_PRICE: Final = 0.1
"""What it costs if from all starts about the demonstrated ones the motion strays."""
# How many such starts, how much farther out than the demonstrations' own, and at what
# Fréchet distance over the scale from the mean, drawn to the start, a motion strays.
_STARTS, _FARTHER, _ASTRAY = 8, 1.2, 0.2
# The least such distance of starts, over the scale.
_LEAST = 0.02


@dataclass(frozen=True, eq=False)
class Judged:
    """A branch and its figures; distances are divided by the strokes' scale.

    Attributes:
        branch: What was judged.
        certificate: Of its chain for the mean start.
        main: The roll-out from the mean start.
        to_mean: Its Fréchet distance to the demonstrations' mean.
        distances: Of each demonstration to the roll-out from its start.
        valid: Whether the chains of the mean start and of every demonstration's are
            proved, and every roll-out arrives.
        strays: Share of starts on a ring about the demonstrated ones from which the
            motion does not arrive, or goes another way than the mean.
    """

    branch: Branch
    certificate: ChainCertificate
    main: ChainRollout
    to_mean: float
    distances: tuple[float, ...]
    valid: bool
    strays: float

    @property
    def cost(self) -> float:
        """C, the mean Fréchet distance over the demonstrations."""
        return float(np.mean(self.distances))

    @property
    def price(self) -> float:
        """The criterion: what is left of the error, and what the fields are charged."""
        chain = self.branch.chain
        charged = OBSTACLE_PRICE * chain.obstacle_count
        charged += STAGE_PRICE * (len(chain) - 1) + STRAY_PRICE * self.strays
        return self.to_mean + self.cost + charged

    @property
    def rank(self) -> tuple[bool, float]:
        """Valid branches first, then the cheaper."""
        return not self.valid, self.price


def judge(branch: Branch, strokes: FloatArray, scale: float) -> Judged:
    """Judges a branch by demonstrations (D, T, 2) that end at its goal."""
    main = chain_rollout(branch.start, branch.chain, goal_tolerance=GOAL_TOLERANCE)
    certificate = certify_chain(branch.chain)
    valid = certificate.passed and main.status is RolloutStatus.ARRIVED
    distances = []
    for stroke in strokes:
        chain = branch.chain_for(stroke[0])
        found = chain_rollout(stroke[0], chain, goal_tolerance=GOAL_TOLERANCE)
        distances.append(discrete_frechet(found.path, stroke) / scale)
        valid = valid and found.status is RolloutStatus.ARRIVED
        # A chain that is not moved is proved already.
        if valid and branch.conditioning is not None:
            valid = certify_chain(chain).passed
    return Judged(
        branch=branch,
        certificate=certificate,
        main=main,
        to_mean=discrete_frechet(main.path, branch.mean) / scale,
        distances=tuple(distances),
        valid=valid,
        strays=_strays(branch, scale),
    )


def _strays(branch: Branch, scale: float) -> float:
    offsets = np.hypot(*(branch.starts - branch.start).T)
    radius = max(_FARTHER * float(offsets.max()), _LEAST * scale)
    turns = np.linspace(0.0, 2.0 * np.pi, _STARTS, endpoint=False)
    ring = radius * np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    fading = np.linspace(1.0, 0.0, len(branch.mean))[:, None]
    astray = 0
    for offset in ring:
        start = branch.start + offset
        chain = branch.chain_for(start)
        found = chain_rollout(start, chain, goal_tolerance=GOAL_TOLERANCE)
        apart = discrete_frechet(found.path, branch.mean + fading * offset) / scale
        arrives = found.status is RolloutStatus.ARRIVED
        astray += not arrives or apart > _ASTRAY
    return astray / _STARTS
