"""Takes a stroke apart: x(t) = discrete(t) + periodic(phase(t)).

A wash is often a slow stroke with circles or scrubbing on top. The paper treats the
two as motions of their own (Sections III and IV); here they are told apart by the
data alone. A stroke without a periodic part is left as it is, bit for bit.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from bath_drake.demonstrations._trend import make_trend
from bath_drake.demonstrations._waves import (
    HARMONICS,
    Waves,
    best_of_grid,
    fit_waves,
)
from bath_drake.demonstrations.canonical import read_only
from bath_drake.notation import FloatArray
from bath_drake.rhythm.limit_cycle import harmonics

# A hand does not scrub faster than this, Hz; tremor begins at 4.
MAX_FREQUENCY = 3.5
# Fewer cycles are bends of a stroke: a zigzag, a loop.
MIN_CYCLES = 3.0
# Share of the fast motion that is in the cycles; noise and bends have less.
MIN_EXPLAINED = 0.6
# Less than this share of the stroke's longest side, or of what is left unexplained,
# is nothing a carer meant.
MIN_SIZE, MIN_OVER_REST = 0.015, 1.5
# A period and its half: the shorter one is meant if it explains nearly as much.
NEARLY = 0.8
# Even samples the fit works on, and at least this many a cycle.
SAMPLES = (160, 480)
SAMPLES_A_CYCLE = 6.0
PERIODS = 40
# Periods that are tried in full: the best peaks that explain at least so much.
MAX_GUESSES, LEAST_GUESS = 4, 0.15
# What of the discrete part is kept: waves slower than this share of the cycle.
KEPT = 0.9

# Share explained, period in samples, drift.
_Guess = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Separation:
    """A stroke's discrete and periodic part.

    Attributes:
        t: Times, shape (n,), s.
        discrete: Shape (n, d), m; without a periodic part the points themselves.
        periodic: Shape (n, d), m; zero where there is none.
        phase: Shape (n,), rad, not decreasing, 2 pi a cycle; zero without one.
        envelope: Shape (n,): how much of the cycle there is, from 0 to about 1.
        period: Mean over the active part, s; None without a periodic part.
        amplitude: Half the longest extent of a cycle, m.
        plane: Orthonormal rows, shape (2, d): the cycle's principal axes.
    """

    t: FloatArray
    discrete: FloatArray
    periodic: FloatArray
    phase: FloatArray
    envelope: FloatArray
    period: float | None
    amplitude: float
    plane: FloatArray

    def __post_init__(self) -> None:
        for name in ("t", "discrete", "periodic", "phase", "envelope", "plane"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def cycles(self) -> float:
        """Cycles while the envelope is at half or more."""
        active = self.envelope >= 0.5
        turned = np.gradient(self.phase)[active].sum() if active.any() else 0.0
        return float(turned / (2.0 * np.pi))

    @property
    def drift(self) -> float:
        """How far the rate strays from its mean while active, as a share of it."""
        active = self.envelope >= 0.5
        if self.period is None or not active.any():
            return 0.0
        rate = (np.gradient(self.phase) / np.gradient(self.t))[active]
        return float(np.abs(rate / rate.mean() - 1.0).max())


def separate(t: FloatArray, points: FloatArray) -> Separation:
    """Separates a stroke into its discrete and its periodic part.

    Candidates for the period are judged by what waves on a smooth trend explain of
    the fast motion; the best one's phase, envelope and cycle are then fitted
    (`_waves`). There is a periodic part if at least `MIN_CYCLES` cycles explain at
    least `MIN_EXPLAINED` of the fast motion and stand out of the rest.

    Args:
        t: Times, shape (n,), s, strictly increasing.
        points: Positions, shape (n, d), m, outliers taken out.

    Raises:
        ValueError: On shapes that do not go together.
    """
    t, points = np.asarray(t, dtype=np.float64), np.asarray(points, dtype=np.float64)
    if t.ndim != 1 or points.shape[:1] != t.shape or points.ndim != 2:
        raise ValueError(
            f"t {t.shape} and points {points.shape} must have shapes (n,) and (n, d)"
        )
    found = _periodic_fit(t, points)
    if found is None:
        return _without(t, points)
    fit, grid = found
    # Beyond the active part the phase says nothing: it runs on evenly.
    phase = PchipInterpolator(grid, np.maximum.accumulate(fit.phase))(t)
    envelope = np.clip(np.interp(t, grid, fit.envelope), 0.0, None)
    cycle = harmonics(phase, HARMONICS) @ fit.coefficients
    periodic = envelope[:, None] * cycle
    step = float(grid[1] - grid[0])
    period = _period(fit, step)
    kept = make_trend(len(grid), min(0.45, KEPT * step / period))
    left = CubicSpline(t, points - periodic)(grid)
    discrete = CubicSpline(grid, kept.smooth(left))(t)
    plane, amplitude = _shape(fit.coefficients)
    return Separation(
        t, discrete, periodic, phase - phase[0], envelope, period, amplitude, plane
    )


def _without(t: FloatArray, points: FloatArray) -> Separation:
    dimension = points.shape[1]
    none = np.zeros(len(t))
    return Separation(
        t, points, np.zeros_like(points), none, none, None, 0.0, np.eye(2, dimension)
    )


def _periodic_fit(t: FloatArray, points: FloatArray) -> tuple[Waves, FloatArray] | None:
    """The waves of a stroke over even times, or None if there are none."""
    duration = float(t[-1] - t[0])
    count = int(np.clip(len(t), *SAMPLES))
    # Interpolation makes no information: the samples there are decide.
    shortest = max(SAMPLES_A_CYCLE * duration / min(count, len(t)), 1.0 / MAX_FREQUENCY)
    if len(t) < 4 * SAMPLES_A_CYCLE or duration < MIN_CYCLES * shortest:
        return None
    grid = np.linspace(t[0], t[-1], count)
    step = float(grid[1] - grid[0])
    samples = CubicSpline(t, points)(grid)
    longest = duration / MIN_CYCLES
    flat = np.ones(count)
    guesses = best_of_grid(
        samples, np.geomspace(shortest, longest, PERIODS) / step, flat
    )
    for guess in _peaks(guesses):
        for part in (3, 2, 1):
            periods = guess[1] / part * np.linspace(0.94, 1.06, 5)
            if periods[0] * step < shortest and part > 1:
                continue
            finer = max(best_of_grid(samples, periods, flat))
            if part == 1 or finer[0] > NEARLY * guess[0]:
                break
        fit = fit_waves(samples, finer[1], finer[2], flat)
        if _meant(fit, samples, points):
            return fit, grid
    return None


def _peaks(guesses: list[_Guess]) -> list[_Guess]:
    """Guesses that explain more than their neighbours, the best ones first."""
    shares = [-np.inf, *(share for share, _, _ in guesses), -np.inf]
    tops = [
        guess
        for k, guess in enumerate(guesses, start=1)
        if shares[k] >= max(shares[k - 1], shares[k + 1]) and shares[k] > LEAST_GUESS
    ]
    return sorted(tops, reverse=True)[:MAX_GUESSES]


def _meant(fit: Waves, samples: FloatArray, points: FloatArray) -> bool:
    """Whether a fit's waves are a motion, not bends or noise."""
    rest = samples - fit.trend - fit.waves
    size = float(np.sqrt(np.mean(np.sum(fit.waves**2, axis=1))))
    side = float(np.max(np.ptp(points, axis=0)))
    noise = float(np.sqrt(np.mean(np.sum(rest**2, axis=1))))
    return (
        fit.cycles >= MIN_CYCLES
        and bool(np.all(np.diff(fit.phase) > 0.0))
        and fit.explained >= MIN_EXPLAINED
        and size >= MIN_SIZE * side
        and size >= MIN_OVER_REST * noise
    )


def _period(fit: Waves, step: float) -> float:
    active = fit.envelope >= 0.5 * fit.envelope.max()
    return float(2.0 * np.pi * step / np.mean(np.gradient(fit.phase)[active]))


def _shape(coefficients: FloatArray) -> tuple[FloatArray, float]:
    """The cycle's principal axes, shape (2, d), and half its longest extent, m."""
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    cycle = harmonics(turn, HARMONICS) @ coefficients
    axes = np.linalg.svd(cycle, full_matrices=False)[2][:2]
    return axes, float(np.max(np.ptp(cycle @ axes.T, axis=0))) / 2.0
