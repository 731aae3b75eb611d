"""Smooths the canonical map over frames, without lagging behind a body that moves.

A mask's edge flickers by a pixel or two, and what the arm hides is a guess; the
canonical frame must not follow either, or the nozzle would, and hide something
else in turn. A body that moves, moves on: pose and velocity are estimated together
by a Kalman filter, so that a steady motion is followed with no lag, and a body does
not change its size, whose mean is kept.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from bath_drake.notation import FloatArray
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.turns import turn_matrix, turn_vector


def _unsure() -> FloatArray:
    return np.zeros((2, 2))


@dataclass(frozen=True, eq=False)
class SmoothMap:
    """What is known of the map after some frames.

    Attributes:
        canonical_map: The smoothed map.
        velocity: (6,) of the frame P: rad/s about axes of W, then m/s.
        covariance: (2, 2) of a component of the pose and of its velocity, in units of
            a single frame's own variance.
        seconds: For how long its size has been seen.
    """

    canonical_map: CanonicalMap
    velocity: FloatArray = field(default_factory=lambda: np.zeros(6))
    covariance: FloatArray = field(default_factory=_unsure)
    seconds: float = 0.0


@dataclass(frozen=True, kw_only=True)
class MapFilter:
    """How much of what a frame says is believed.

    Attributes:
        shift_noise: Of the place a single frame finds, rms, m; measured on people of
            several builds who sit still.
        turn_noise: Likewise of the axes, rad.
        speed: Of a body when first seen, rms, m/s.
        acceleration: How fast a seated body's velocity wanders, m/s in a second.
        size_time: Over which the box's extents are averaged, s.
        most_shift: The smoothed map is never further from the newest frame's, m: a body
            that starts or stops is followed within this, not some time later.
        most_turn: Likewise, rad.

    Raises:
        ValueError: Unless all are positive and finite.
    """

    shift_noise: float = 0.002
    turn_noise: float = 0.006
    speed: float = 0.004
    acceleration: float = 0.002
    size_time: float = 3.0
    most_shift: float = 0.008
    most_turn: float = 0.03

    def __post_init__(self) -> None:
        """Checks all numbers."""
        for name, value in vars(self).items():
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} must be positive and finite, got {value}")

    def start(self, seen: CanonicalMap) -> SmoothMap:
        """Returns what is known after the first frame."""
        wandering = (self.speed / self.shift_noise) ** 2
        return SmoothMap(seen, covariance=np.diag([1.0, wandering]))

    def next(self, smooth: SmoothMap, seen: CanonicalMap, dt: float) -> SmoothMap:
        """Returns what is known `dt` seconds later.

        Args:
            smooth: What was known so far.
            seen: The newest frame's own map.
            dt: s, positive.
        """
        expected = predicted(smooth, dt).canonical_map
        covariance, (pose_gain, velocity_gain) = self._gains(smooth.covariance, dt)
        error = _difference(expected, seen)
        left = self._bounded((1.0 - pose_gain) * error)
        seconds = smooth.seconds + dt
        # A mean at first, and an exponentially weighted one in the long run.
        share = max(dt / (seconds + dt), 1.0 - math.exp(-dt / self.size_time))
        size = smooth.canonical_map.half_extents
        moved = _moved(seen, -left)
        return SmoothMap(
            replace(moved, half_extents=size + share * (seen.half_extents - size)),
            smooth.velocity + velocity_gain * error,
            covariance,
            seconds,
        )

    def _gains(
        self, covariance: FloatArray, dt: float
    ) -> tuple[FloatArray, tuple[float, float]]:
        """Returns the covariance after a frame and the gains for pose and velocity."""
        forward = np.array([[1.0, dt], [0.0, 1.0]])
        # White acceleration, integrated once and twice.
        power = (self.acceleration / self.shift_noise) ** 2
        wandered = power * np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]])
        before = forward @ covariance @ forward.T + wandered
        gain = before[:, 0] / (before[0, 0] + 1.0)
        after = before - np.outer(gain, before[0])
        return (after + after.T) / 2.0, (float(gain[0]), float(gain[1]))

    def _bounded(self, error: FloatArray) -> FloatArray:
        turn, shift = np.linalg.norm(error[:3]), np.linalg.norm(error[3:])
        return np.concatenate(
            [
                error[:3] * min(1.0, self.most_turn / max(float(turn), 1e-12)),
                error[3:] * min(1.0, self.most_shift / max(float(shift), 1e-12)),
            ]
        )


def predicted(smooth: SmoothMap, dt: float) -> SmoothMap:
    """Returns where the body is `dt` seconds on if it moves as it did."""
    return replace(
        smooth, canonical_map=_moved(smooth.canonical_map, dt * smooth.velocity)
    )


def _difference(a: CanonicalMap, b: CanonicalMap) -> FloatArray:
    """Returns (6,) what takes a's frame to b's: a turn about axes of W, a shift."""
    turn = turn_vector(b.R_WP @ a.R_WP.T)
    return np.concatenate([turn, b.p_WP - a.p_WP])


def _moved(canonical_map: CanonicalMap, motion: FloatArray) -> CanonicalMap:
    R_WP = turn_matrix(motion[:3]) @ canonical_map.R_WP
    # Thousands of products drift off the rotations by rounding.
    u, _, vt = np.linalg.svd(R_WP)
    return replace(canonical_map, R_WP=u @ vt, p_WP=canonical_map.p_WP + motion[3:])
