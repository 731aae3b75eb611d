"""Which field of a chain is followed, and what restricted areas change of it.

The motion goes on to the next field at its gate and never back. An area on the way to
a gate is the world's business (`bath_drake.control.world`); one that covers the goal
before a gate leaves nothing to arrive at. A carer washes up to the wound, round it and
on: the goal is moved to where it is free, its gate with it. Where there is no such
place near, the field is left out.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.composition.chain import Chain, Gate
from bath_drake.composition.rollout import chain_rollout
from bath_drake.control.areas import GAP, inflated
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, beta
from bath_drake.notation import BoolArray, FloatArray

# Of a gate that was moved, in N: small, to fit between area and obstacles.
MOVED_RADIUS = 0.06
# How far a goal is moved at most, and in what steps, in N.
_REACH, _STEP, _DIRECTIONS = 0.6, 0.02, 36
# A place beyond the old goal counts as so much farther than one before it.
_BEYOND = 0.5
# beta_0 of a place well inside the workspace, |x| and |y| of one well on the body.
_INSIDE, _ON_BODY = 0.1, 0.9


def around_areas(chain: Chain, areas: ObstacleSet) -> Chain:
    """Moves goals that areas cover, the last one excepted, and their gates.

    A goal counts as covered within `GAP` of an area. It is moved to the nearest place
    that is free of areas and of the obstacles of its own field and the next, if there
    is one near.

    Args:
        chain: As it was learned.
        areas: Restricted areas in N.

    Returns:
        The chain itself where nothing is covered.
    """
    if not len(areas):
        return chain
    fields, gates = list(chain.fields), list(chain.gates)
    for k in np.flatnonzero(covered(chain, areas)[:-1]):
        gate = gates[k]
        goal = _free_place(fields[k], fields[k + 1], gate, areas)
        if goal is not None:
            fields[k], gates[k] = fields[k].with_goal(goal), gate_at(goal, gate)
    return replace(chain, fields=tuple(fields), gates=tuple(gates))


def gate_at(goal: FloatArray, gate: Gate) -> Gate:
    """A small gate about a goal (2,) that was moved out of its own one."""
    radius = min(gate.radius, MOVED_RADIUS)
    return Gate(goal - 0.5 * radius * gate.direction, gate.direction, radius)


def covered(chain: Chain, areas: ObstacleSet) -> BoolArray:
    """Whether fields' goals are in an area or within `GAP` of one, shape (K,)."""
    goals = np.stack([field.goal for field in chain.fields])
    return ~_clear(goals, areas, GAP)


def left_out(chain: Chain, areas: ObstacleSet) -> BoolArray:
    """Which stages are not followed, for areas cover their goals, shape (K,).

    Args:
        chain: As `around_areas` gave it. Its last stage always is followed.
        areas: Restricted areas in N.
    """
    if not len(areas):
        return np.zeros(len(chain), dtype=bool)
    out = covered(chain, areas)
    out[-1] = False
    return out


def next_stage(chain: Chain, stage: int, point: ArrayLike, left_out: BoolArray) -> int:
    """The stage that follows at a point (2,): later if in its gates, never earlier.

    Args:
        chain: As `around_areas` gave it.
        stage: The one that was followed so far.
        point: Where the flow is asked, in N.
        left_out: (K,) as of `left_out`.
    """
    stage = chain.stage_at(point, stage)
    while left_out[stage]:
        stage = chain.stage_at(point, stage + 1)
    return stage


def entry_point(point: FloatArray, chain: Chain) -> FloatArray:
    """Where a motion from ``point`` (2,) is going to enter a chain's second field.

    The first field's goal, which lies in the gate, if the motion does not get there.
    """
    found = chain_rollout(point, chain)
    entered = np.flatnonzero(found.stages == 1)
    return found.path[entered[0]] if len(entered) else chain.fields[0].goal


def _free_place(
    field: NavigationField, after: NavigationField, gate: Gate, areas: ObstacleSet
) -> FloatArray | None:
    """The nearest free place (2,) for the goal before a gate; None if none is near."""
    lengths = np.arange(_STEP, _REACH + 0.5 * _STEP, _STEP)
    turns = np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False)
    rays = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    shifts = (lengths[:, None, None] * rays).reshape(-1, 2)
    places = field.goal + shifts
    free = _clear(places, areas, GAP) & (np.abs(places).max(axis=-1) <= _ON_BODY)
    # The gate reaches less than one and a half radii from the goal. Where it reaches
    # into an area nothing comes to be.
    for other, distance in ((field, GAP), (after, 1.5 * MOVED_RADIUS)):
        free &= _clear(places, other.obstacles, distance)
        free &= other.workspace.beta(places) > _INSIDE
    if not free.any():
        return None
    beyond = np.maximum(shifts @ gate.direction, 0.0)
    cost = np.hypot(shifts[:, 0], shifts[:, 1]) + _BEYOND * beyond
    return np.asarray(places[np.where(free, cost, np.inf).argmin()])


def _clear(q: FloatArray, obstacles: ObstacleSet, distance: float) -> BoolArray:
    """Which points (n, 2) keep about a distance to all obstacles, shape (n,)."""
    return np.asarray((beta(q, inflated(obstacles, distance)) > 0.0).all(axis=-1))
