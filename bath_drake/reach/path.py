"""The way that a skill is going to take over a back, wounds and cycles included."""

from dataclasses import replace

import numpy as np

from bath_drake.composition.rollout import chain_rollout
from bath_drake.control.staging import around_areas
from bath_drake.control.world import join_areas
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.learning.skill import Skill
from bath_drake.notation import FloatArray
from bath_drake.rhythm.superposition import Room
from bath_drake.rhythm.whole_motion import whole_motion

# Kept by the cycles to areas, rim and box, in N: the default of `PeriodicMotion`.
_MARGIN = 0.02
# Of a cycle so many of the motion's 10 ms steps are one.
_EVERY = 5


def driven_path(
    skill: Skill, areas: ObstacleSet, half_extents: FloatArray, speed: float
) -> FloatArray:
    """Returns the points (n, 2) in N that are going to be washed, in turn.

    The body's rim is not in it: the learned one stands in its place.

    Args:
        skill: What is reproduced, from its start.
        areas: Restricted ones in N; the way around them is the one the loop would find
            if the camera told it just these.
        half_extents: (2,) of the back's box, m.
        speed: Along the skin, m/s.
    """
    chain = skill.chain
    if len(areas):
        chain = around_areas(chain, areas)
        starts = [skill.start, *(field.goal for field in chain.fields[:-1])]
        fields = tuple(
            join_areas(field, areas, start).field
            for field, start in zip(chain.fields, starts, strict=True)
        )
        chain = replace(chain, fields=fields)
    path = chain_rollout(skill.start, chain).path
    if skill.periodic is None or len(path) < 2:
        return path
    room = Room(areas=areas, workspace=chain.fields[-1].workspace, margin=_MARGIN)
    _, points = whole_motion(
        skill.periodic, path, room, speed=speed, half_extents=half_extents
    )
    return np.concatenate([points[:-1:_EVERY], points[-1:]])
