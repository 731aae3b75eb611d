"""A way along a line from rest to rest: speed, acceleration and jerk are bounded.

The quickest one within its bounds, and as a function of time, not of what was before:
it neither overshoots nor drifts (Biagiotti and Melchiorri, "Trajectory Planning for
Automatic Machines and Robots", 2008, Sec. 3.4, the double-S profile).
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class SmoothWay:
    """So far, and no faster than this.

    Attributes:
        distance: How far, m; >= 0.
        speed: At most, m/s.
        acceleration: At most, m/s^2.
        jerk: At most, m/s^3.
    """

    distance: float
    speed: float
    acceleration: float
    jerk: float

    def __post_init__(self) -> None:
        """Raises ValueError unless all are finite, the bounds positive."""
        for name, value in vars(self).items():
            least = 0.0 if name == "distance" else math.ulp(0.0)
            if not (math.isfinite(value) and value >= least):
                raise ValueError(f"{name} must be positive and finite, got {value}")

    @property
    def seconds(self) -> float:
        """What the way takes, s."""
        _, _, _, to_half = self._times()
        return 2.0 * to_half

    def travelled(self, seconds: float) -> float:
        """How far one has come `seconds` after the start, m: 0 before, all after."""
        peak, ramp, rise, to_half = self._times()
        if not seconds > 0.0 or self.distance == 0.0:
            return 0.0
        if seconds >= 2.0 * to_half:
            return self.distance
        if seconds > to_half:
            # The second half is the first one backwards.
            return self.distance - self._risen(
                2.0 * to_half - seconds, peak, ramp, rise
            )
        return self._risen(seconds, peak, ramp, rise)

    def mean_speed(self, seconds: float, dt: float) -> float:
        """The speed over the `dt` seconds that begin `seconds` after the start, m/s."""
        return (self.travelled(seconds + dt) - self.travelled(seconds)) / dt

    def _times(self) -> tuple[float, float, float, float]:
        """Peak speed; s: of a ramp of the acceleration, of the rise, to the middle."""
        d, a, j = self.distance, self.acceleration, self.jerk
        # What the way leaves time for: acceleration held for a while, or not at all.
        steady = a * (math.sqrt(0.25 * (a / j) ** 2 + d / a) - 0.5 * a / j)
        peak = steady if steady > a * a / j else (0.5 * d * math.sqrt(j)) ** (2.0 / 3.0)
        peak = min(peak, self.speed)
        ramp = min(a / j, math.sqrt(peak / j))
        rise = ramp + peak / (j * ramp) if ramp > 0.0 else 0.0
        cruise = max(0.0, d - peak * rise) / peak if peak > 0.0 else 0.0
        return peak, ramp, rise, rise + 0.5 * cruise

    def _risen(self, t: float, peak: float, ramp: float, rise: float) -> float:
        """How far one has come at t, up to the middle."""
        j = self.jerk
        if t <= ramp:
            return j * t**3 / 6.0
        if t <= rise - ramp:
            # Steady acceleration, after the ramp's j ramp^3 / 6 and j ramp^2 / 2.
            s = t - ramp
            return j * ramp * (ramp**2 / 6.0 + 0.5 * ramp * s + 0.5 * s**2)
        if t <= rise:
            # A rise is symmetric about its middle: half the peak's way in all.
            return peak * (t - 0.5 * rise) + j * (rise - t) ** 3 / 6.0
        return peak * (t - 0.5 * rise)
