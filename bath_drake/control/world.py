"""Joins what the camera saw with what was learned into one sound world.

A restricted area that overlaps a virtual obstacle makes one notched hole of both,
and a notch can trap. The area is real and stays; the virtual obstacles are ours, so
they give way. Among the worlds tried, the sound one whose motion leaves least of the
learned one aside is taken (paper, Sec. IV: sensed obstacles join the field).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from bath_drake.certificate.certify import certify, certify_from
from bath_drake.certificate.result import Certificate
from bath_drake.control.areas import inflated, make_room
from bath_drake.control.certified_world import RUN_TIME_BUDGET
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace, beta
from bath_drake.field.rollout import RolloutStatus, rollout
from bath_drake.notation import FloatArray

# Once the learned path is on average this near to the motion, in N, none is sought.
NEAR_ENOUGH = 0.05
# The least beta_0 of a start or goal that is well within a rim.
WELL_WITHIN = 0.1
# A path nearer than this to an obstacle or the rim, in N, is taken only where there is
# no other: the guard keeps a margin of its own, a third of it, and may hold there.
CLEARANCE = 0.015
# The smaller an area's exponent, the nearer to it the flow first feels it.
_EXPONENTS = (1.0, 0.3)
_KAPPA_FACTORS = (1.0, 2.0, 4.0)


@dataclass(frozen=True, eq=False)
class World:
    """Virtual and sensed obstacles that stand together.

    Attributes:
        learned: The field that was asked for.
        start: (2,) in N, from where on the motion was to be sound.
        virtual: The learned field with its obstacles as they could be kept, within the
            body's rim if that could be had.
        sensed: The restricted areas, with the exponents they were given.
        certificate: What was proved of the field of both.
        changed: What was done to the virtual obstacles, in words.
    """

    learned: NavigationField
    start: FloatArray
    virtual: NavigationField
    sensed: ObstacleSet
    certificate: Certificate
    changed: str

    @property
    def field(self) -> NavigationField:
        """The field of both."""
        return self.virtual.with_obstacles(self.sensed)


def join_areas(
    field: NavigationField,
    areas: ObstacleSet,
    start: FloatArray,
    rim: Workspace | None = None,
) -> World:
    """Finds a sound world of a learned field and restricted areas, within the body.

    Args:
        field: The learned field.
        areas: Restricted areas in N, never made smaller.
        start: (2,) where the motion is now, in N.
        rim: Of the body, in N, that is to take the place of the learned rim. Only where
            start or goal is not well within it, or no such world is found to be sound,
            the learned rim stays.

    Returns:
        A world whose motion from `start` arrives and which is proved: all of its free
        space if one such is found, else what `start` can reach (its sublevel set). If
        there is none, the plain union with the certificate that says why not.
    """
    if rim is not None and min(rim.beta(np.stack([start, field.goal]))) > WELL_WITHIN:
        on_body = NavigationField(rim, field.goal, field.kappa, field.obstacles)
        within = _joined(on_body, areas, start)
        if within.certificate.passed:
            return replace(within, learned=field)
    return _joined(field, areas, start)


def _joined(field: NavigationField, areas: ObstacleSet, start: FloatArray) -> World:
    if not len(areas):
        alone = certify_from(field, start, budget=RUN_TIME_BUDGET)
        return World(field, start, field, areas, alone, "nothing")
    candidates = _candidates(field, areas, start)
    for region in (False, True):
        # The nearest first: what is far from the learned path need not be proved.
        for _, virtual, sensed, changed in candidates:
            world = virtual.with_obstacles(sensed)
            certificate = certify(
                world, starts=start if region else None, budget=RUN_TIME_BUDGET
            )
            if certificate.passed:
                return World(field, start, virtual, sensed, certificate, changed)
    union = certify_from(field.with_obstacles(areas), start, budget=RUN_TIME_BUDGET)
    nothing = "nothing: no sound world was found"
    return World(field, start, field, areas, union, nothing)


def left_aside(learned: FloatArray, path: FloatArray, areas: ObstacleSet) -> float:
    """Mean distance from the learned path, where it is free, to another path, in N.

    A way round must leave the learned one; what counts is that the motion comes back
    to it and does not cut the rest of the stroke short.
    """
    free = (beta(learned, areas) > 0.0).all(axis=-1)
    if not free.any():
        return 0.0
    offsets = learned[free][:, None, :] - path[None, :, :]
    return float(np.sqrt((offsets**2).sum(axis=2)).min(axis=1).mean())


def skims(path: FloatArray, world: NavigationField) -> bool:
    """Whether a path (n, 2) in N comes nearer than `CLEARANCE` to any boundary.

    Where it begins, and where it ends, it may be near: no world would change that.
    """
    near = (beta(path, inflated(world.obstacles, CLEARANCE)) <= 0.0).any(axis=-1)
    rim = world.workspace
    share = 1.0 - CLEARANCE / float(rim.semi_axes.min())
    near |= replace(rim, semi_axes=share * rim.semi_axes).beta(path) <= 0.0
    (away,) = np.nonzero(~near)
    return not len(away) or bool(near[away[0] : away[-1]].any())


_Candidate = tuple[tuple[bool, float], NavigationField, ObstacleSet, str]


def _candidates(
    field: NavigationField, areas: ObstacleSet, start: FloatArray
) -> list[_Candidate]:
    """Worlds whose motion arrives, what leaves least of the learned one aside first.

    A roll-out costs a hundredth of a proof: it goes before. Worlds near enough count
    as equally near; among them the first tried, the one changed least, comes first.
    Those whose motion skims something come last.
    """
    learned = rollout(start, field).path
    found: list[_Candidate] = []
    for virtual, sensed, changed in _worlds(field, areas):
        world = virtual.with_obstacles(sensed)
        path = rollout(start, world)
        if path.status is RolloutStatus.ARRIVED:
            distance = max(left_aside(learned, path.path, areas), NEAR_ENOUGH)
            rank = skims(path.path, world), distance
            found.append((rank, virtual, sensed, changed))
    return sorted(found, key=lambda candidate: candidate[0])


def _worlds(
    field: NavigationField, areas: ObstacleSet
) -> Iterator[tuple[NavigationField, ObstacleSet, str]]:
    shapes = {
        "kept": field.obstacles,
        "shrunk": make_room(field.obstacles, areas),
        "dropped": ObstacleSet(),
    }
    for factor in _KAPPA_FACTORS:
        for exponent in _EXPONENTS:
            sensed = ObstacleSet(areas.theta, np.full(len(areas), exponent))
            for name, obstacles in shapes.items():
                virtual = NavigationField(
                    field.workspace, field.goal, factor * field.kappa, obstacles
                )
                changed = f"{name}, kappa x {factor:g}, areas' exponent {exponent:g}"
                yield virtual, sensed, changed
