"""What the hand is to do: a stroke in canonical space over time, rubbing on top."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from bath_drake.carer.config import CarerConfig, RubbingConfig
from bath_drake.demonstrations.canonical import CanonicalDemonstration
from bath_drake.notation import FloatArray

# Samples of a way-points' curve, and the share of its time in which the hand speeds up.
_CURVE_SAMPLES = 400
_SPEEDING_SHARE = 0.15
# s, in which a wandering frequency comes back to where it was.
_DRIFT_PERIOD = 7.0


@dataclass(frozen=True, eq=False)
class Stroke:
    """A path of the canonical plane with its timing.

    Attributes:
        times: (n,) s, from 0, not decreasing.
        points: (n, 2) canonical.
        pause: At rest before and after, s.
        rubbing: What comes on top; None for nothing.
    """

    times: FloatArray
    points: FloatArray
    pause: float
    rubbing: RubbingConfig | None

    @property
    def duration(self) -> float:
        """From the first moment at rest to the last, s."""
        return float(self.times[-1]) + 2.0 * self.pause

    def discrete(self, t: FloatArray) -> FloatArray:
        """The stroke itself at times t (m,): (m, 2), canonical."""
        moving = np.asarray(t) - self.pause
        columns = [np.interp(moving, self.times, c) for c in self.points.T]
        return np.stack(columns, axis=-1)

    def phase(self, t: FloatArray) -> FloatArray:
        """The rubbing's phase at times t (m,), rad; zeros without rubbing."""
        t = np.asarray(t, dtype=np.float64)
        if self.rubbing is None:
            return np.zeros_like(t)
        turn = 2.0 * np.pi / _DRIFT_PERIOD
        wandered = self.rubbing.drift * np.sin(turn * t) / turn
        return np.asarray(2.0 * np.pi * self.rubbing.frequency * (t + wandered))

    def periodic(self, t: FloatArray) -> FloatArray:
        """What comes on top at times t (m,): (m, 2), canonical.

        Its size grows from nothing during the first pause and dies in the last.
        """
        t = np.asarray(t, dtype=np.float64)
        if self.rubbing is None:
            return np.zeros((*t.shape, 2))
        phase, angle = self.phase(t), self.rubbing.angle
        if self.rubbing.kind == "circles":
            shape = np.stack([np.cos(phase), np.sin(phase)], axis=-1)
        else:
            direction = np.array([np.cos(angle), np.sin(angle)])
            shape = np.sin(phase)[..., None] * direction
        pause = max(self.pause, 1e-9)
        size = _smooth(t / pause) * _smooth((self.duration - t) / pause)
        return np.asarray(self.rubbing.amplitude * size[..., None] * shape)

    def at(self, t: FloatArray) -> FloatArray:
        """Where the marker is to touch the skin at times t (m,): (m, 2), canonical."""
        return self.discrete(t) + self.periodic(t)


def demonstrated_stroke(
    demonstration: CanonicalDemonstration, config: CarerConfig
) -> Stroke:
    """A demonstration's stroke, with its own timing."""
    return Stroke(
        demonstration.times, demonstration.points, config.pause, config.rubbing
    )


def waypoint_stroke(config: CarerConfig) -> Stroke:
    """A smooth stroke through the way-points, at one speed but for start and end.

    It stays within the box of any two neighbours.
    """
    # Nanometres: differences too small to divide by are none.
    points = np.round(np.array(config.waypoints), 9)
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    knots = np.r_[0.0, np.cumsum(chords)]
    curve = PchipInterpolator(knots, points)(
        np.linspace(0.0, knots[-1], _CURVE_SAMPLES)
    )
    lengths = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))]
    share = np.linspace(0.0, 1.0, _CURVE_SAMPLES)
    speed = _smooth(share / _SPEEDING_SHARE) * _smooth((1.0 - share) / _SPEEDING_SHARE)
    way = np.r_[0.0, np.cumsum((speed[1:] + speed[:-1]) / 2.0)]
    at = way / way[-1] * lengths[-1]
    path = np.stack([np.interp(at, lengths, c) for c in curve.T], axis=-1)
    return Stroke(share * config.seconds, path, config.pause, config.rubbing)


def _smooth(s: FloatArray) -> FloatArray:
    """From 0 at 0 to 1 at 1 and beyond, its slope continuous."""
    s = np.clip(s, 0.0, 1.0)
    return np.asarray(s * s * (3.0 - 2.0 * s))
