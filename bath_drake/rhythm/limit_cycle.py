"""The periodic motion: a phase and an attractive cycle, in canonical space N.

An oscillator turns the phase phi at its own rate; the hand is off the discrete motion
by f(phi) + d, f a Fourier series and d the deviation, which decays at the rate
lambda:

    dphi/dt = 2 pi / T,    dd/dt = -lambda d.

So every point of the plane is drawn to the cycle, whatever the cycle's shape: scrubbing
to and fro on one line is a cycle too, and has no inside (phase oscillators for rhythmic
primitives: Ijspeert et al., Neural Computation 25, 2013). The paper leaves periodic
motion to future work (Section VI).
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.notation import FloatArray

# exp(-5) = 0.7 % of a deviation is left after one period.
DECAY_A_PERIOD = 5.0
# Points at which a cycle is looked at for its size and its nearest phase.
FINE = 256
_TURN = np.linspace(0.0, 2.0 * np.pi, FINE, endpoint=False)


@dataclass(frozen=True, eq=False)
class LimitCycle:
    """A learned cycle and how it goes with the discrete motion.

    Attributes:
        coefficients: Rows cos phi, sin phi, cos 2 phi, ... by x and y, shape (2 K, 2),
            in N. There is no constant: the cycle goes round the discrete motion.
        period: T, s: the demonstrations'.
        pitch: Length of the discrete motion in one period, in N, positive.
        begin: Length of the discrete motion before the cycles set in, in N.
        end: Length of the discrete motion after they have gone, in N.

    Raises:
        ValueError: A shape is wrong, a number is not finite, the cycle is a point, the
            period or the pitch is not positive or a length is negative.
    """

    coefficients: FloatArray
    period: float
    pitch: float
    begin: float = 0.0
    end: float = 0.0
    _radius: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        rows = np.array(self.coefficients, dtype=np.float64)
        shape = rows.shape
        if rows.ndim != 2 or shape[1] != 2 or shape[0] < 2 or shape[0] % 2:
            raise ValueError(f"coefficients must have shape (2 K, 2), got {shape}")
        if not np.isfinite(rows).all():
            raise ValueError("coefficients must be finite")
        if not rows.any():
            raise ValueError("coefficients are all zero: the cycle is a point")
        rows.setflags(write=False)
        object.__setattr__(self, "coefficients", rows)
        for name in ("period", "pitch"):
            value = getattr(self, name)
            if not 0.0 < value < np.inf:
                raise ValueError(f"{name} must be positive and finite, got {value}")
        for name in ("begin", "end"):
            value = getattr(self, name)
            if not 0.0 <= value < np.inf:
                raise ValueError(f"{name} must be finite and >= 0, got {value}")
        # Between two points a curve strays from its chord by h^2 / 8 of its bend.
        bend = np.arange(1, self.count + 1) ** 2 @ self._sizes()
        slack = float(bend) * (2.0 * np.pi / FINE) ** 2 / 8.0
        farthest = float(np.linalg.norm(self.offset(_TURN), axis=1).max())
        object.__setattr__(self, "_radius", farthest + slack)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, LimitCycle):
            return NotImplemented
        return np.array_equal(self.coefficients, other.coefficients) and all(
            getattr(self, name) == getattr(other, name)
            for name in ("period", "pitch", "begin", "end")
        )

    def __hash__(self) -> int:
        lengths = (self.period, self.pitch, self.begin, self.end)
        return hash((self.coefficients.tobytes(), lengths))

    @property
    def count(self) -> int:
        """K, the number of multiples of the phase."""
        return len(self.coefficients) // 2

    @property
    def radius(self) -> float:
        """No point of the cycle is further from the discrete motion, in N."""
        return self._radius

    @property
    def rate(self) -> float:
        """Of the phase, rad/s."""
        return 2.0 * np.pi / self.period

    def offset(self, phase: ArrayLike) -> FloatArray:
        """f(phi) for phases (...), rad: shape (..., 2), in N."""
        return np.asarray(harmonics(phase, self.count) @ self.coefficients)

    def tangent(self, phase: ArrayLike) -> FloatArray:
        """df/dphi for phases (...), rad: shape (..., 2), in N a radian."""
        basis = harmonics(phase, self.count)
        k = np.repeat(np.arange(1, self.count + 1), 2)
        swapped = self.coefficients.reshape(-1, 2, 2)[:, ::-1] * [[[1.0], [-1.0]]]
        return np.asarray((basis * k) @ swapped.reshape(-1, 2))

    def nearest_phase(self, point: ArrayLike) -> float:
        """The phase in [0, 2 pi) whose point of the cycle is nearest to `point` (2,).

        From there a pushed hand goes on round the cycle.
        """
        apart = np.linalg.norm(self.offset(_TURN) - np.asarray(point), axis=1)
        return float(_TURN[int(np.argmin(apart))])

    def _sizes(self) -> FloatArray:
        """An upper bound of each harmonic's amplitude, shape (K,)."""
        pairs = self.coefficients.reshape(-1, 4)
        return np.asarray(np.linalg.norm(pairs, axis=1))


def decayed(deviation: FloatArray, periods: float) -> FloatArray:
    """What is left of a deviation from the cycle after a number of periods."""
    return np.asarray(deviation * np.exp(-DECAY_A_PERIOD * periods))


def harmonics(phase: ArrayLike, count: int) -> FloatArray:
    """Cosine and sine of each of `count` harmonics, phases (...): (..., 2 count)."""
    first = np.exp(1j * np.asarray(phase, dtype=np.float64))
    powers = np.cumprod(np.repeat(first[..., None], count, axis=-1), axis=-1)
    return np.asarray(powers.view(np.float64))
