"""How the arm keeps its links off what they must not touch, while the nozzle works.

The null space is pushed so that near links move away, which costs the nozzle nothing.
And no link nears a thing faster than in proportion to how far it is from where it must
stop (a velocity damper; Faverjon and Tournassoud, "A local based approach for path
planning of manipulators with a high number of degrees of freedom", ICRA 1987): the null
space is bent as far as that takes, and where it does not do the whole arm is slowed.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.notation import FloatArray

# Singular values below such a share of the greatest are lost; m^2/rad^2 below which no
# motion in the null space moves a link; how often the worst link is looked after.
_LOST, _FLAT, _BENDS = 1e-2, 1e-4, 6


@dataclass(frozen=True, kw_only=True)
class AvoidanceConfig:
    """When and how hard.

    Attributes:
        stop: No link comes nearer of itself than this, m.
        near: Links nearer than this are pushed away, m.
        gain: Speed for each metre within `near`, and for each off `stop`, 1/s.
        push: No joint is pushed faster than this, rad/s.
    """

    stop: float = 0.025
    near: float = 0.07
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
    push = np.zeros(rows.shape[1] - 1)
    for row in rows[rows[:, 0] < config.near]:
        slope = row[1:]
        size = float(slope @ slope)
        # A link that no joint moves away is nobody's to push.
        if size > 1e-6:
            push += slope * (config.gain * (config.near - row[0]) / size)
    most = float(np.abs(push).max(initial=0.0))
    return push * (config.push / most) if most > config.push else push


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
    allowed = _allowed(rows, config)
    added = np.zeros_like(v)
    if not (rows[:, 1:] @ v < -allowed).any():
        return added
    free = np.eye(len(v)) - np.linalg.pinv(J, rcond=_LOST) @ J
    slopes = rows[:, 1:] @ free
    for _ in range(_BENDS):
        missing = -allowed - rows[:, 1:] @ (v + added)
        worst = int(missing.argmax())
        size = float(slopes[worst] @ slopes[worst])
        if missing[worst] <= 0.0 or size < _FLAT:
            break
        added += slopes[worst] * (missing[worst] / size)
    return added


def reachable_share(
    start: FloatArray, change: FloatArray, low: FloatArray, high: FloatArray
) -> float:
    """Returns how much of a change (7,) keeps velocities within bounds, 0 to 1."""
    room = np.where(change > 0.0, high - start, start - low)
    size = np.abs(change)
    moved = size > 1e-12
    shares = np.maximum(room[moved], 0.0) / size[moved]
    return float(shares.min(initial=1.0))


def damped_share(v: FloatArray, rows: FloatArray, config: AvoidanceConfig) -> float:
    """Returns how much of a velocity (7,), rad/s, may be gone: from 0 to 1.

    Args:
        v: (7,) joint velocities, rad/s.
        rows: (n, 8) as of `bath_drake.safety.obstacle_distance.link_gaps`.
        config: When and how hard.
    """
    nearing, allowed = -(rows[:, 1:] @ v), _allowed(rows, config)
    fast = nearing > allowed
    return float((allowed[fast] / nearing[fast]).min(initial=1.0))


def _allowed(rows: FloatArray, config: AvoidanceConfig) -> FloatArray:
    """How fast each link may near what it is next to, m/s."""
    return np.asarray(config.gain * np.maximum(rows[:, 0] - config.stop, 0.0))
