"""How the arm keeps its links off what they must not touch, while the nozzle works.

The null space is pushed so that near links move away, which costs the nozzle nothing.
And no link nears a thing faster than in proportion to how far it is from where it must
stop (a velocity damper; Faverjon and Tournassoud, "A local based approach for path
planning of manipulators with a high number of degrees of freedom", ICRA 1987): the null
space is bent as far as that takes, and where it does not do the whole arm is slowed.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.control import _keeping_off
from bath_drake.notation import FloatArray


@dataclass(frozen=True, kw_only=True)
class AvoidanceConfig:
    """When and how hard.

    Attributes:
        stop: No link comes nearer of itself than this, m.
        near: Links nearer than this are pushed away, m.
        self_stop: As `stop`, of links from each other; they are pushed away as far
            before it as from `stop` to `near`.
        gain: Speed for each metre within `near`, and for each off `stop`, 1/s.
        push: No joint is pushed faster than this, rad/s.
    """

    stop: float = 0.025
    near: float = 0.07
    self_stop: float = 0.04
    gain: float = 5.0
    push: float = 0.5

    def __post_init__(self) -> None:
        """Raises ValueError unless all are positive and finite, and stop is nearest."""
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        if not self.stop < self.near:
            raise ValueError(f"near must be above stop ({self.stop}), got {self.near}")


def push_away(rows: FloatArray, config: AvoidanceConfig) -> FloatArray:
    """Returns joint velocities (7,), rad/s, that take near links away.

    Args:
        rows: (n, 8) as of `bath_drake.safety.obstacle_distance.link_gaps`.
        config: When and how hard.
    """
    push = _keeping_off.push_away(_flat(rows), config.near, config.gain, config.push)
    return np.asarray(push)


def bend(
    v: FloatArray, J: FloatArray, rows: FloatArray, config: AvoidanceConfig
) -> FloatArray:
    """Returns what to add to a velocity so that no link nears a thing too fast.

    It changes nothing of what the nozzle does, and is as little as that takes; where it
    takes more than the null space has, it is what there is.

    Args:
        v: (7,) joint velocities, rad/s.
        J: (5, 7) Jacobian of what the nozzle follows.
        rows: (n, 8) as of `bath_drake.safety.obstacle_distance.link_gaps`.
        config: When and how hard.
    """
    v, J, rows = _flat(v), _flat(J), _flat(rows)
    return np.asarray(_keeping_off.bend(v, J, rows, config.stop, config.gain))


def reachable_share(
    start: FloatArray, change: FloatArray, low: FloatArray, high: FloatArray
) -> float:
    """Returns how much of a change (7,) keeps velocities within bounds, 0 to 1."""
    bounds = _flat(low), _flat(high)
    return float(_keeping_off.reachable_share(_flat(start), _flat(change), *bounds))


def damped_share(v: FloatArray, rows: FloatArray, config: AvoidanceConfig) -> float:
    """Returns how much of a velocity (7,), rad/s, may be gone: from 0 to 1.

    Args:
        v: (7,) joint velocities, rad/s.
        rows: (n, 8) as of `bath_drake.safety.obstacle_distance.link_gaps`.
        config: When and how hard.
    """
    v, rows = _flat(v), _flat(rows)
    return float(_keeping_off.damped_share(v, rows, config.stop, config.gain))


def _flat(values: FloatArray) -> FloatArray:
    return np.ascontiguousarray(values, dtype=np.float64)
