"""The world that is driven in, with its proof, and how long that proof holds."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from bath_drake.certificate.certify import certify_from
from bath_drake.certificate.result import Certificate
from bath_drake.field.navigation import NavigationField, min_beta, psi
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.rollout import RolloutStatus, rollout
from bath_drake.notation import FloatArray
from bath_drake.shared import Shared

# Boxes a proof may look at while the robot runs: hundredths of a second. Worlds of
# twenty obstacles take a third of it.
RUN_TIME_BUDGET = 20_000


class WorldVerdict(IntEnum):
    """A certificate's verdict as a number; UNKNOWN before the first."""

    UNKNOWN = 0
    PROVED = 1
    UNDECIDED = 2
    REFUTED = 3


@dataclass(frozen=True, eq=False)
class CertifiedWorld(Shared):
    """A certificate with the world and the start it is about.

    Attributes:
        field: Virtual and sensed obstacles together.
        start: (2,) in N, where the motion was when the proof was made.
        certificate: Of the whole field or of all that `start` can reach.
        made: False for what stands in before the first proof.
    """

    field: NavigationField
    start: FloatArray
    certificate: Certificate
    made: bool = True

    @property
    def verdict(self) -> WorldVerdict:
        """The verdict as a number."""
        if not self.made:
            return WorldVerdict.UNKNOWN
        return WorldVerdict[self.certificate.verdict.upper()]

    def proves(self, field: NavigationField, point: FloatArray) -> bool:
        """Whether the certificate covers the motion from `point` (2,) in `field`.

        It does so in no other field than its own. A proof of a region {psi <= c}
        holds as long as the point is in it: psi falls along the flow, but a nozzle
        that was pushed aside may take the reference out. Where the set has other
        components, one from which a roll-out arrives is the goal's, which is proved.
        """
        if not self.certificate.passed or field != self.field:
            return False
        region = self.certificate.region
        if region is None:
            return bool(min_beta(point, field) > 0.0)
        if float(psi(point, field)) > region:
            return False
        if not self.certificate.apart:
            return True
        return rollout(point, field).status is RolloutStatus.ARRIVED

    def is_stale(self, field: NavigationField, point: FloatArray) -> bool:
        """Whether a new certificate is due for the motion from `point` in `field`.

        For another field, and for a point that moved out of what is proved.
        """
        if not self.made or field != self.field:
            return True
        moved = not np.array_equal(point, self.start)
        return moved and not self.proves(field, point)


def certify_world(field: NavigationField, start: FloatArray) -> CertifiedWorld:
    """Proves a world: all of it, or else what `start`, shape (2,), can reach."""
    start = np.array(start, dtype=np.float64)
    start.setflags(write=False)
    found = certify_from(field, start, budget=RUN_TIME_BUDGET)
    return CertifiedWorld(field, start, found)


def keep_certified(
    worlds: tuple[CertifiedWorld, ...],
    field: NavigationField,
    point: FloatArray,
    ahead: Sequence[tuple[NavigationField, FloatArray]] = (),
) -> tuple[CertifiedWorld, ...]:
    """Makes the proof that is needed most, one at most.

    Args:
        worlds: What is certified.
        field: The world that is driven in.
        point: (2,) where the motion is, in N.
        ahead: Worlds that may be driven in next, and where each is to be entered.

    Returns:
        `worlds` itself if nothing is due, else the driven world, then those ahead.
    """
    current = certified_of(worlds, field)
    others = tuple(
        world for world in worlds if any(world.field == other for other, _ in ahead)
    )
    if current is None or current.is_stale(field, point):
        others = tuple(world for world in others if world is not current)
        return (certify_world(field, point), *others)
    for other, entry in ahead:
        if certified_of(worlds, other) is None:
            kept = tuple(world for world in others if world is not current)
            return (current, *kept, certify_world(other, entry))
    return worlds


def certified_of(
    worlds: tuple[CertifiedWorld, ...], field: NavigationField
) -> CertifiedWorld | None:
    """The world that is certified of a field, if there is one."""
    return next((w for w in worlds if w.made and w.field == field), None)


def nothing_certified() -> CertifiedWorld:
    """What stands in before the first proof: it proves nothing."""
    disc = Workspace(np.zeros(2), np.ones(2))
    field = NavigationField(disc, np.zeros(2), 1.0, ObstacleSet())
    unknown = Certificate("undecided", "no proof was made yet")
    return CertifiedWorld(field, np.zeros(2), unknown, made=False)
