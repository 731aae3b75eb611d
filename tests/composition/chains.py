"""Chains to test with: random ones, and one whose facts can be checked by hand."""

import numpy as np

from bath_drake.composition.chain import Chain, Gate
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import FloatArray

DISC = Workspace(np.zeros(2), np.full(2, 2.5))


def make(
    goal: tuple[float, float], *rows: list[float], kappa: float = 5.0
) -> NavigationField:
    """A field in a disc of radius 2.5; rows are (centre x, centre y, a, b, angle)."""
    theta = np.array(rows, dtype=float).reshape(-1, 5)
    return NavigationField(DISC, np.array(goal), kappa, ObstacleSet(theta))


def gate_at(
    goal: FloatArray, turn: float, radius: float = 0.12, ahead: float = 0.3
) -> Gate:
    """A gate with its goal a share of the radius ahead of the straight side."""
    direction = np.array([np.cos(turn), np.sin(turn)])
    return Gate(goal - ahead * radius * direction, direction, radius)


def random_chain(
    rng: np.random.Generator, stages: int = 3, obstacles: int = 3, kappa: float = 6.0
) -> Chain:
    """Discs and ellipses strewn about; those on a goal or on a gate are made smaller.

    Most are proved, some are not.
    """
    goals = rng.uniform(-1.2, 1.2, (stages, 2))
    turns = rng.uniform(-np.pi, np.pi, stages - 1)
    fields = []
    for k in range(stages):
        long = rng.uniform(0.1, 0.4, obstacles)
        centres = rng.uniform(-1.5, 1.5, (obstacles, 2))
        # Room for the goal, and for the gate and its radius.
        keep = goals[max(k - 1, 0) : k + 1]
        away = np.linalg.norm(centres[:, None] - keep, axis=-1).min(axis=1)
        long = np.clip(np.minimum(long, away - 0.25), 0.02, None)
        short = long * rng.uniform(0.5, 1.0, obstacles)
        far = away > 0.3
        theta = np.column_stack([centres, long, short, rng.uniform(-3, 3, obstacles)])
        fields.append(NavigationField(DISC, goals[k], kappa, ObstacleSet(theta[far])))
    gates = [gate_at(g, t) for g, t in zip(goals, turns, strict=False)]
    return Chain(tuple(fields), tuple(gates))
