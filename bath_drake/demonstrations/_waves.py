"""Waves of a drifting phase on a smooth trend, fitted to samples at even steps.

Model: x = z + a(t) c(theta(t)), with a trend z (see `_trend`), a closed curve c given
by a few harmonics, a phase theta that is a straight line plus a few polynomials, and
an envelope a. All but theta and a are linear and eliminated (variable projection,
Golub and Pereyra 1973); theta is found by Gauss-Newton from the best of a grid of
periods and drifts, a by the share of the mean cycle in what the trend leaves.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import legendre
from scipy.interpolate import BSpline
from scipy.ndimage import gaussian_filter1d

from bath_drake.demonstrations._trend import Trend, make_trend
from bath_drake.notation import FloatArray
from bath_drake.rhythm.limit_cycle import harmonics

# The trend keeps half of a wave this many times slower than the cycle's.
TREND_SHARE = 0.5
# Waves in a cycle: a circle is one, scrubbing with pauses at the turns a few.
HARMONICS = 3
# Of the grid: relative drifts of the rate over the whole stroke.
DRIFTS = np.linspace(-0.45, 0.45, 7)
# Gauss-Newton steps, and rounds of phase and envelope in turn.
STEPS, ROUNDS = 12, 6
# Polynomials of the phase beyond the straight line, at most.
MAX_DEGREE = 8
# Standard deviation of the phase's first polynomial, as a share of the whole phase;
# that of the k-th is k^3 times smaller.
DRIFT = 0.5
# Rounds of demodulation, and the standard deviation of its window in cycles.
LOCKING, LOCKING_WINDOW = 3, 0.6
# Between two knots of the envelope, cycles.
ENVELOPE_KNOTS = 0.5
# How much bends of the envelope cost.
ENVELOPE_STIFFNESS = 0.05
# Below this share of the cycle there is none.
ENVELOPE_FLOOR = 0.12


@dataclass(frozen=True, eq=False)
class Waves:
    """A fit over samples at even steps.

    Attributes:
        phase: Shape (m,), rad, increasing.
        envelope: Shape (m,), from 0 to about 1.
        coefficients: Cosines and sines of each harmonic, shape (2 H, d).
        trend: Shape (m, d).
        explained: Share of what the trend alone leaves that the waves take away.
    """

    phase: FloatArray
    envelope: FloatArray
    coefficients: FloatArray
    trend: FloatArray
    explained: float

    @property
    def waves(self) -> FloatArray:
        """A c(theta) at the samples, shape (m, d)."""
        basis = harmonics(self.phase, len(self.coefficients) // 2)
        return np.asarray(self.envelope[:, None] * (basis @ self.coefficients))

    @property
    def cycles(self) -> float:
        """Cycles while the envelope is at half or more."""
        steps = np.gradient(self.phase) / (2.0 * np.pi)
        return float(steps[self.envelope >= 0.5 * self.envelope.max()].sum())


def best_of_grid(
    samples: FloatArray, periods: FloatArray, envelope: FloatArray
) -> list[tuple[float, float, float]]:
    """What waves of each period explain, with the best drift of each.

    Args:
        samples: Shape (m, d).
        periods: Mean periods, in samples, shape (k,).
        envelope: Shape (m,).

    Returns:
        Of each period: the share explained, the period, and the drift.
    """
    found = []
    t = np.linspace(-1.0, 1.0, len(samples))
    for period in periods:
        trend = make_trend(len(samples), TREND_SHARE / period)
        rough = trend.rough(samples)
        swings = 0.25 * DRIFTS[:, None] * t**2
        phases = np.pi * len(samples) / period * (t + swings)
        bases = envelope[:, None] * harmonics(phases, HARMONICS)
        # One call for all drifts: the banded solver is fast on many columns.
        columns = np.moveaxis(bases, 0, 1).reshape(len(samples), -1)
        left = np.moveaxis(
            trend.rough(columns).reshape(len(samples), *bases.shape[::2]), 1, 0
        )
        shares = _explained(samples, rough, bases, left)
        best = int(np.argmax(shares))
        found.append((float(shares[best]), float(period), float(DRIFTS[best])))
    return found


def _explained(
    samples: FloatArray, rough: FloatArray, basis: FloatArray, left: FloatArray
) -> FloatArray:
    """Shares (...) of samples' roughness that bases (..., m, k) explain.

    left = (I - S) basis.
    """
    transposed = np.swapaxes(basis, -1, -2)
    right = transposed @ rough
    coefficients = _solve(transposed @ left, right)
    total = float(np.sum(samples * rough))
    taken = np.sum(coefficients * right, axis=(-1, -2))
    return np.asarray(taken / total if total > 0.0 else 0.0 * taken)


def _solve(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Least squares of normal equations, a little damped against singular ones."""
    size = matrix.shape[-1]
    damping = 1e-9 * np.trace(matrix, axis1=-2, axis2=-1) / size + 1e-300
    damped = matrix + damping[..., None, None] * np.eye(size)
    return np.asarray(np.linalg.solve(damped, right))


def fit_waves(
    samples: FloatArray, period: float, drift: float, envelope: FloatArray
) -> Waves:
    """Fits phase, cycle, envelope and trend from a first guess.

    Args:
        samples: Shape (m, d).
        period: Mean period, in samples.
        drift: By how much the rate grows over the stroke, as a share of its mean.
        envelope: Shape (m,), the first guess.
    """
    count = len(samples)
    t = np.linspace(-1.0, 1.0, count)
    cycles = count / period
    trend = make_trend(count, TREND_SHARE / period)
    polynomials = legendre.legvander(t, MAX_DEGREE)[:, 1:].astype(np.float64)
    theta = np.zeros(MAX_DEGREE)
    theta[0] = np.pi * cycles
    theta[1] = np.pi * cycles * 0.25 * drift * 2.0 / 3.0
    spread = DRIFT * np.pi * cycles / np.arange(1, MAX_DEGREE + 1) ** 3
    theta = _locked(trend.rough(samples), theta, polynomials, period)
    zero = np.zeros((2 * HARMONICS, samples.shape[1]))
    fit = Waves(polynomials @ theta, envelope, zero, samples, 0.0)
    fit = _linear(samples, fit, trend)
    for _ in range(ROUNDS):
        theta, fit = _with_phase(
            samples, fit, theta, _Phase(polynomials, spread, period), trend
        )
        envelope = _envelope(samples, fit, trend)
        if np.allclose(envelope, fit.envelope, atol=1e-3):
            break
        fit = _linear(samples, replace(fit, envelope=envelope), trend)
    return fit


def _locked(
    rough: FloatArray, theta: FloatArray, polynomials: FloatArray, period: float
) -> FloatArray:
    """Phase coefficients (K,) after the waves were demodulated with the guess.

    The phase error of a wave is the angle of the wave times exp(-i phase), averaged
    over about a cycle; unlike Gauss-Newton this bears errors of many radians, as long
    as they grow slowly.
    """
    axis = np.linalg.svd(rough, full_matrices=False)[2][0]
    wave = rough @ axis
    for _ in range(LOCKING):
        turning = wave * np.exp(-1j * (polynomials @ theta))
        mean = gaussian_filter1d(turning.real, LOCKING_WINDOW * period, mode="nearest")
        mean = mean + 1j * gaussian_filter1d(
            turning.imag, LOCKING_WINDOW * period, mode="nearest"
        )
        error = np.unwrap(np.angle(mean))
        weight = np.abs(mean)[:, None]
        basis = np.column_stack([np.ones(len(wave)), polynomials])
        change = np.linalg.lstsq(weight * basis, weight[:, 0] * error, rcond=None)[0]
        theta = theta + change[1:]
    return theta


def _linear(samples: FloatArray, fit: Waves, trend: Trend) -> Waves:
    """The best cycle and trend for a fit's phase and envelope."""
    rough = trend.rough(samples)
    basis = fit.envelope[:, None] * harmonics(fit.phase, HARMONICS)
    left = trend.rough(basis)
    coefficients = _solve(basis.T @ left, basis.T @ rough)
    return replace(
        fit,
        coefficients=coefficients,
        trend=trend.smooth(samples - basis @ coefficients),
        explained=float(_explained(samples, rough, basis, left)),
    )


@dataclass(frozen=True, eq=False)
class _Phase:
    """Polynomials of the phase and how large their coefficients tend to be.

    Attributes:
        polynomials: Shape (m, K).
        spread: Standard deviations of the coefficients, shape (K,), rad.
        period: Samples a cycle: neighbours closer than half of one err alike.
    """

    polynomials: FloatArray
    spread: FloatArray
    period: float


def _with_phase(
    samples: FloatArray, fit: Waves, theta: FloatArray, model: _Phase, trend: Trend
) -> tuple[FloatArray, Waves]:
    """Gauss-Newton steps on the phase, cycle and trend following."""
    polynomials, dimension = model.polynomials, samples.shape[1]
    orders = np.repeat(np.arange(1, HARMONICS + 1), 2)
    total = float(np.sum(samples * trend.rough(samples)))
    for _ in range(STEPS):
        basis = harmonics(fit.phase, HARMONICS)
        # d/dtheta of cos(k theta), sin(k theta) pairs.
        pairs = basis.reshape(-1, HARMONICS, 2)
        turned = np.stack([-pairs[..., 1], pairs[..., 0]], axis=-1)
        slope = (turned.reshape(basis.shape) * orders) @ fit.coefficients
        slope *= fit.envelope[:, None]
        linear = fit.envelope[:, None] * basis
        rough_linear = trend.rough(linear)
        gram = linear.T @ rough_linear
        rough_residual = trend.rough(samples - linear @ fit.coefficients)
        left = np.zeros((len(theta),) * 2)
        right = np.zeros(len(theta))
        for k in range(dimension):
            moved = slope[:, k : k + 1] * polynomials
            cross = moved.T @ rough_linear
            # What the cycle's own coefficients can do is taken out.
            left += moved.T @ trend.rough(moved) - cross @ _solve(gram, cross.T)
            right += moved.T @ rough_residual[:, k] - cross @ _solve(
                gram, linear.T @ rough_residual[:, k]
            )
        noise = (1.0 - fit.explained) * total / len(samples) * model.period / 2.0
        weight = noise / model.spread**2
        weight[0] = 0.0
        step = _solve(left + np.diag(weight), right - weight * theta)
        # Far steps leave the basin: at most a twelfth of a cycle at once.
        step *= min(1.0, 0.5 / max(float(np.abs(polynomials @ step).max()), 1e-12))
        before = (1.0 - fit.explained) * total + float(weight @ theta**2)
        for _ in range(6):
            phase = polynomials @ (theta + step)
            moved_fit = _linear(samples, replace(fit, phase=phase), trend)
            after = (1.0 - moved_fit.explained) * total
            after += float(weight @ (theta + step) ** 2)
            if after < before:
                break
            step = 0.5 * step
        else:
            break
        theta, fit = theta + step, moved_fit
        if before - after < 1e-5 * before:
            break
    return theta, fit


def _envelope(samples: FloatArray, fit: Waves, trend: Trend) -> FloatArray:
    """How much of the mean cycle there is at each sample, shape (m,)."""
    count = len(samples)
    cycles = float(fit.phase[-1] - fit.phase[0]) / (2.0 * np.pi)
    basis = _splines(count, max(4, round(cycles / ENVELOPE_KNOTS)))
    cycle = harmonics(fit.phase, HARMONICS) @ fit.coefficients
    left = np.zeros((basis.shape[1],) * 2)
    right = np.zeros(basis.shape[1])
    for k in range(samples.shape[1]):
        columns = basis * cycle[:, k : k + 1]
        rough = trend.rough(columns)
        left += columns.T @ rough
        right += rough.T @ samples[:, k]
    bends = np.diff(np.eye(basis.shape[1]), 2, axis=0)
    left += ENVELOPE_STIFFNESS * np.trace(left) / len(left) * bends.T @ bends
    envelope = np.clip(basis @ _solve(left, right), 0.0, None)
    envelope[envelope < ENVELOPE_FLOOR * envelope.max()] = 0.0
    top = float(np.quantile(envelope, 0.8))
    return np.asarray(envelope / top) if top > 0.0 else envelope


def _splines(count: int, pieces: int) -> FloatArray:
    """Cubic B-splines over evenly spaced knots, shape (count, pieces + 3)."""
    knots = np.arange(-3, pieces + 4) / pieces
    x = np.linspace(0.0, 1.0, count)
    return np.asarray(BSpline.design_matrix(x, knots, 3).toarray())
