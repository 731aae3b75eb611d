"""Denoising compared: recordings of strokes whose truth is known, three smoothers.

Every method is given the same recording with its outliers taken out by
`find_outliers`; what is compared is the smoothing. Each method's one parameter is the
one that serves best over strokes of its own, which none of the compared ones is.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, savgol_filter, sosfiltfilt

from bath_drake.demonstrations.denoise import denoise
from bath_drake.demonstrations.outliers import find_outliers
from bath_drake.demonstrations.strokes import (
    STROKES,
    Stroke,
    hand_at,
    meant_curve,
    perturbed,
)
from bath_drake.learning.frechet import discrete_frechet
from bath_drake.learning.strokes import resample
from bath_drake.notation import FloatArray

# Frequencies and sizes of tremor: physiological to pathological.
TREMOR_HZ, TREMOR_M = (4.0, 12.0), (0.0005, 0.004)
TONES = 4
# A depth camera's steps, and how often it errs, by how much.
QUANTUM_M, OUTLIERS, OUTLIER_M = 0.001, 0.01, 0.05
RATES_HZ = (30.0, 60.0, 100.0)
SPEED_M_S = (0.08, 0.20)
# Corners: where the direction turns by more than this within 2 % of the length, rad.
CORNER = 0.6

Smoother = Callable[[FloatArray, FloatArray, float], FloatArray]


@dataclass(frozen=True, eq=False)
class NoisyStroke:
    """A recording and the hand's true path at the same times; s and m."""

    name: str
    t: FloatArray
    points: FloatArray
    truth: FloatArray


@dataclass(frozen=True)
class Errors:
    """What is left after smoothing, as shares of the stroke's longest side.

    Attributes:
        rms: Root mean square distance to the truth.
        frechet: Of the path, equal steps of arc length.
        corner: How far the path passes by the truth's sharpest bends, at most.
    """

    rms: float
    frechet: float
    corner: float


def noisy_stroke(stroke: Stroke, rng: np.random.Generator) -> NoisyStroke:
    """One demonstration with tremor, outliers and quantisation, and its truth."""
    points, heading = meant_curve(stroke)
    points = perturbed(points, stroke.size, rng)
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    duration, rate = length / rng.uniform(*SPEED_M_S), float(rng.choice(RATES_HZ))
    t = np.linspace(0.0, duration, max(40, round(duration * rate)))
    t[1:-1] += rng.uniform(-0.2, 0.2, len(t) - 2) * (t[1] - t[0])
    truth = hand_at(points, heading, t / duration, rng)
    size = rng.uniform(*TREMOR_M)
    angles = 2.0 * np.pi * rng.uniform(*TREMOR_HZ, (TONES, 2)) * t[:, None, None]
    waves = np.sin(angles + rng.uniform(0.0, 2.0 * np.pi, (TONES, 2)))
    shaking = size * np.sqrt(2.0 / TONES) * waves.sum(axis=1)
    recorded = np.round((truth + shaking) / QUANTUM_M) * QUANTUM_M
    out = np.flatnonzero(rng.random(len(t)) < OUTLIERS)
    out = out[(out > 2) & (out < len(t) - 3)]
    turn = rng.uniform(0.0, 2.0 * np.pi, len(out))
    recorded[out] += OUTLIER_M * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    return NoisyStroke(stroke.name, t, recorded, truth)


def spline(t: FloatArray, points: FloatArray, parameter: float) -> FloatArray:
    """The smoothing spline of `denoise`; the parameter is not used."""
    return denoise(t, points)(t)


def savitzky_golay(t: FloatArray, points: FloatArray, window: float) -> FloatArray:
    """Cubics over windows of so many seconds, on even samples."""

    def smooth(even: FloatArray, step: float) -> FloatArray:
        count = max(5, 2 * round(0.5 * window / step) + 1)
        count = min(count, 2 * ((len(even) - 1) // 2) + 1)
        return np.asarray(savgol_filter(even, count, 3, axis=0, mode="interp"))

    return _evenly(t, points, smooth)


def low_pass(t: FloatArray, points: FloatArray, cutoff: float) -> FloatArray:
    """A Butterworth filter of second order, there and back, on even samples."""

    def smooth(even: FloatArray, step: float) -> FloatArray:
        sections = butter(2, min(cutoff * 2.0 * step, 0.9), output="sos")
        return np.asarray(sosfiltfilt(sections, even, axis=0))

    return _evenly(t, points, smooth)


METHODS: dict[str, tuple[Smoother, tuple[float, ...]]] = {
    "smoothing spline, tolerance": (spline, (0.0,)),
    "Savitzky-Golay": (savitzky_golay, (0.2, 0.3, 0.4, 0.5, 0.7, 0.9)),
    "zero-phase low-pass": (low_pass, (1.0, 1.5, 2.0, 2.5, 3.0, 4.0)),
}
"""Each with the values of its parameter that are tried: none, s, Hz."""


def compare(seeds: int = 2) -> dict[str, tuple[float, list[Errors]]]:
    """Runs every method over all shipped strokes, `seeds` recordings of each.

    Returns:
        Of each method the parameter chosen on recordings of its own, and the errors.
    """
    tuning = [_recording(stroke, 1000 + k) for k, stroke in enumerate(STROKES)]
    tests = [
        _recording(s, 10 * k + i) for k, s in enumerate(STROKES) for i in range(seeds)
    ]
    found = {}
    for name, (smoother, values) in METHODS.items():
        costs = [
            np.mean([errors(smoother, n, value).frechet for n in tuning])
            for value in values
        ]
        chosen = values[int(np.argmin(costs))]
        found[name] = (chosen, [errors(smoother, n, chosen) for n in tests])
    return found


def errors(smoother: Smoother, noisy: NoisyStroke, parameter: float) -> Errors:
    """What a method leaves of one recording's noise."""
    outliers = find_outliers(noisy.t, noisy.points)
    kept = np.delete(noisy.t, outliers)
    smooth = smoother(kept, np.delete(noisy.points, outliers, axis=0), parameter)
    truth = np.delete(noisy.truth, outliers, axis=0)
    side = float(np.ptp(noisy.truth, axis=0).max())
    off = np.linalg.norm(smooth - truth, axis=1)
    paths = resample(smooth, 200), resample(truth, 200)
    corners = _corners(noisy.truth)
    passed = [np.linalg.norm(smooth - corner, axis=1).min() for corner in corners]
    return Errors(
        rms=float(np.sqrt(np.mean(off**2))) / side,
        frechet=discrete_frechet(*paths) / side,
        corner=float(max(passed, default=0.0)) / side,
    )


def _recording(stroke: Stroke, seed: int) -> NoisyStroke:
    return noisy_stroke(stroke, np.random.default_rng([77, seed]))


def _corners(path: FloatArray) -> FloatArray:
    """The points of a path where it turns most sharply, shape (k, 2)."""
    even = resample(path, 400)
    steps = np.diff(even, axis=0)
    heading = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    turned = np.abs(heading[8:] - heading[:-8])
    peaks = (turned[1:-1] >= turned[:-2]) & (turned[1:-1] >= turned[2:])
    at = np.flatnonzero(peaks & (turned[1:-1] > CORNER)) + 1
    return np.asarray(even[at + 4])


def _evenly(
    t: FloatArray,
    points: FloatArray,
    smooth: Callable[[FloatArray, float], FloatArray],
) -> FloatArray:
    """Smooths samples at even times in place of the recorded ones."""
    even = np.linspace(t[0], t[-1], len(t))
    columns = [np.interp(even, t, column) for column in points.T]
    smoothed = smooth(np.stack(columns, axis=-1), float(even[1] - even[0]))
    back = [np.interp(t, even, column) for column in smoothed.T]
    return np.stack(back, axis=-1)
