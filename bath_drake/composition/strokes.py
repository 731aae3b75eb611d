"""Strokes strung together: many start and goal pairs, washed in one go.

A stroke is a learned chain carried by the similarity that takes the ends it was learned
for to those that are asked for: its proof is carried along
(`bath_drake.composition.similarity`). Between two strokes a field without obstacles
leads over. All in turn are one chain, to be proved as a whole like any other.
"""

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.composition.chain import Chain, Gate
from bath_drake.composition.clearing import cleared
from bath_drake.composition.rollout import chain_rollout
from bath_drake.composition.similarity import Similarity
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import FloatArray

# Of the gate at a stroke's end, in N: small, so that strokes are washed to their ends.
GATE_RADIUS = 0.04
# Of the fields between two strokes: the learner's own, in which every back lies.
_WIDE = Workspace(np.zeros(2), np.array([2.0, 2.0]))
# Shorter than this no stroke has a direction, in N.
_SHORTEST = 1e-3


def lanes(
    low: ArrayLike, high: ArrayLike, spacing: float
) -> list[tuple[FloatArray, FloatArray]]:
    """Strokes to and fro across a box, from below upwards, as an ox ploughs.

    Args:
        low: (2,) the box's lower corner, in N: on the first lane, which begins at the
            higher x.
        high: (2,) the upper one, on the last.
        spacing: Between lanes, in N, at most; they are spaced evenly.

    Returns:
        Start and goal (2,) of each lane.

    Raises:
        ValueError: The corners are not so, or the spacing is not positive.
    """
    left, bottom = np.asarray(low, dtype=np.float64).tolist()
    right, top = np.asarray(high, dtype=np.float64).tolist()
    if not (left < right and bottom <= top):
        raise ValueError(
            f"high must be above low ({[left, bottom]}), got {[right, top]}"
        )
    if not 0.0 < spacing < np.inf:
        raise ValueError(f"spacing must be positive and finite, got {spacing}")
    count = int(np.ceil((top - bottom) / spacing - 1e-9)) + 1
    strokes = []
    for k, y in enumerate(np.linspace(bottom, top, count).tolist()):
        ends = (np.array([right, y]), np.array([left, y]))
        strokes.append(ends if k % 2 == 0 else ends[::-1])
    return strokes


def carried(
    chain: Chain, learned_start: ArrayLike, start: ArrayLike, goal: ArrayLike
) -> Chain:
    """A chain moved so that it leads from one point to another, in its own shape.

    Args:
        chain: As it was learned.
        learned_start: (2,) where it was learned to start, in N.
        start: (2,) where it is to start.
        goal: (2,) where it is to end.

    Raises:
        ValueError: The ends are one point, or a field's workspace is no disc.
    """
    ends = np.array([learned_start, chain.goal, start, goal], dtype=np.float64)
    if ends.shape != (4, 2) or not np.isfinite(ends).all():
        raise ValueError(f"start and goal must be two finite numbers, got {ends}")
    before, after = (complex(*(ends[k + 1] - ends[k])) for k in (0, 2))
    for name, way in (("the learned stroke", before), ("the stroke", after)):
        if abs(way) < _SHORTEST:
            raise ValueError(f"{name} must be {_SHORTEST:g} long or more")
    move = Similarity(ends[0], after / before, ends[2] - ends[0])
    moved = chain.moved((move,) * len(chain))
    # To the last bit, which rounding may have changed.
    last = moved.fields[-1].with_goal(ends[3])
    return Chain((*moved.fields[:-1], last), moved.gates)


def strung(strokes: Sequence[tuple[FloatArray, Chain]]) -> Chain:
    """One chain of many: each is followed to its goal, then over to the next's start.

    Args:
        strokes: Start (2,) and chain of each, in N. One that starts where the last
            ended follows at once.

    Returns:
        The chain, its gates drawn in where they reach into an obstacle.

    Raises:
        ValueError: There is no stroke.
    """
    if not strokes:
        raise ValueError("at least one stroke is needed, got none")
    fields, gates = list(strokes[0][1].fields), list(strokes[0][1].gates)
    for (begun, before), (start, chain) in itertools.pairwise(strokes):
        gates.append(_end_gate(before.goal, _arrival(begun, before)))
        way = start - before.goal
        if np.hypot(*way) > 0.5 * GATE_RADIUS:
            kappa = before.fields[-1].kappa
            fields.append(NavigationField(_WIDE, start, kappa, ObstacleSet()))
            gates.append(_end_gate(start, way))
        fields += chain.fields
        gates += chain.gates
    return cleared(Chain(tuple(fields), tuple(gates)))


def _arrival(start: FloatArray, chain: Chain) -> FloatArray:
    """Direction (2,) in which a stroke comes to its goal, of no unit length."""
    path = chain_rollout(start, chain).path
    last = chain.goal - path[np.hypot(*(path - chain.goal).T) > 0.5 * GATE_RADIUS][-1:]
    return np.asarray(last[0] if len(last) else chain.goal - start)


def _end_gate(goal: FloatArray, direction: FloatArray) -> Gate:
    unit = direction / np.hypot(*direction)
    return Gate(goal - 0.5 * GATE_RADIUS * unit, unit, GATE_RADIUS)
