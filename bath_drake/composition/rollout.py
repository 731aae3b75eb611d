"""Reproduction of a motion through a chain: each field's flow until its gate."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.composition.chain import Chain
from bath_drake.field import _rollouts
from bath_drake.field.rollout import Rollout, RolloutStatus, check_rollout, path_times
from bath_drake.field.speed import NEVER_SLOWS
from bath_drake.notation import FloatArray, IntArray

_NO_GATE = np.zeros(5)
_NEVER = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True, eq=False)
class ChainRollout(Rollout):
    """A path through a chain's stages.

    Attributes:
        stages: Which field leads on from each point, shape (T,).
    """

    stages: IntArray


def chain_rollout(
    start: ArrayLike,
    chain: Chain,
    *,
    step: float = 0.01,
    max_steps: int = 5000,
    goal_tolerance: float = 1e-3,
) -> ChainRollout:
    """Follows the fields in guarded steps, each until its gate.

    A chain of one is rolled out just as `bath_drake.field.rollout.rollout` does it.

    Args:
        start: Shape (2,), in N.
        chain: The fields and gates.
        step: Arc length of a step, units of N.
        max_steps: How many steps at most, all stages together.
        goal_tolerance: Distance to the last goal that counts as arrived.

    Returns:
        The path; where it ends before the last goal, the status is that of the field
        it ends in. `min_beta` is the least of each field along its own part.

    Raises:
        ValueError: An argument is out of its range.
    """
    check_rollout(step, max_steps, goal_tolerance)
    x, y = np.asarray(start, dtype=np.float64).tolist()
    path = np.empty((max_steps + 1, 2))
    stages = np.empty(max_steps + 1, dtype=np.int64)
    path[0] = x, y
    done, clear, length = 0, np.inf, 0.0
    status = RolloutStatus.OUT_OF_STEPS
    for k, field in enumerate(chain.fields):
        workspace, gx, gy, kappa, forms = field.kernel_arguments
        gate, tolerance = _NO_GATE, goal_tolerance
        if k < len(chain.gates):
            # To be near a goal that is not the last is no arrival: the gate counts.
            gate, tolerance = chain.gates[k].as_array(), _NEVER
        x, y = path[done].tolist()
        count, code, least, way = _rollouts.roll_out(
            x,
            y,
            workspace,
            gx,
            gy,
            kappa,
            forms,
            step,
            tolerance,
            gate,
            path[done:],
        )
        stages[done : done + count] = k
        done += count - 1
        clear, length = min(clear, least), length + way
        if code != _rollouts.PASSED:
            status = RolloutStatus(code)
            if status is RolloutStatus.ARRIVED and k < len(chain.gates):
                status = RolloutStatus.TRAPPED  # on the goal, beside its gate
            break
    return ChainRollout(
        path[: done + 1].copy(), status, clear, length, stages[: done + 1].copy()
    )


def chain_times(
    found: ChainRollout,
    chain: Chain,
    *,
    speed: float,
    half_extents: ArrayLike = (1.0, 1.0),
    slow_radius: float = 0.1,
    goal_tolerance: float = 1e-3,
) -> FloatArray:
    """When the points of a chain's path are passed, shape (T,), s since the first.

    The speed is that of `bath_drake.field.speed.canonical_velocity`; it falls to zero
    at the last goal only.

    Raises:
        ValueError: An argument is out of its range.
    """
    times = np.zeros(len(found.path))
    for k, field in enumerate(chain.fields):
        at = np.flatnonzero(found.stages == k)
        if not len(at):
            continue
        # The way to the point where the next field takes over is this one's.
        part = slice(at[0], at[-1] + 2)
        last = k == len(chain.fields) - 1
        times[part] = times[part.start] + path_times(
            found.path[part],
            field,
            speed=speed,
            half_extents=half_extents,
            slow_radius=slow_radius if last else NEVER_SLOWS,
            goal_tolerance=goal_tolerance,
        )
    return times
