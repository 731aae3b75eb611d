"""Takes outliers and hand tremor out of a recorded path, without phase lag.

Physiological and pathological hand tremor lies at 4 to 12 Hz, washing strokes
well below 1 Hz. The path is smoothed in time by a cubic smoothing spline whose
weights are the samples' shares of the time axis. The spline minimises

    integral |p(t) - g(t)|^2 dt + lambda integral |g''(t)|^2 dt

and so passes a frequency f with the gain 1 / (1 + (f / f_c)^4) where lambda =
(2 pi f_c)^-4: a fourth-order low-pass filter without lag, for any spacing of the
samples, whose natural ends go on straight. Within a third of a second of an end,
where a sample has neighbours on one side only, up to two thirds of the tremor stay.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, make_smoothing_spline

from bath_drake.demonstrations.outliers import find_outliers, find_strays
from bath_drake.notation import FloatArray, IntArray

# Half gain here: 4 Hz passes with 3.8 %, 12 Hz with 0.05 %, 0.3 Hz with 99.9 %.
CUTOFF_HZ = 1.8
# A faster stroke would be cut. The cutoff rises until the smoothed path stays this
# close to the recorded one, as shares of the longest side of the path's box: every
# sample, and the average over a quarter of a second, in which tremor of 4 Hz or more
# cancels out and a cut corner does not.
TOLERANCE, AVERAGE_TOLERANCE = 0.04, 0.005
AVERAGED_S = 0.25
CUTOFF_GROWTH = 1.25
# At this many cycles a sample the spline goes through every sample.
INTERPOLATING = 100.0
# Nothing a hand does needs more samples, and closer ones make the spline stiff.
MAX_RATE_HZ = 200.0
MIN_SAMPLES = 5


@dataclass(frozen=True, eq=False)
class DenoisedPath:
    """A smooth path through a recording.

    Attributes:
        start: First time of the recording, s.
        end: Last time, s.
        cutoff: Frequency of half gain that was used, Hz.
        outliers: Indices of the samples that were left out, shape (k,).
        spline: The cubic spline, in units of `unit` seconds after `start`.
        unit: Length of one unit of the spline's argument, s.
    """

    start: float
    end: float
    cutoff: float
    outliers: IntArray
    spline: BSpline
    unit: float

    @property
    def knots(self) -> FloatArray:
        """Times between which the path is a cubic, shape (k,), s."""
        return np.asarray(self.spline.t, dtype=np.float64) * self.unit + self.start

    def __call__(self, t: FloatArray) -> FloatArray:
        """Positions at times of any shape (...), s: shape (..., d), m."""
        return np.asarray(self.spline((t - self.start) / self.unit), dtype=np.float64)


def denoise(t: FloatArray, points: FloatArray) -> DenoisedPath:
    """Leaves out the outliers and smooths what is left.

    Args:
        t: Times, shape (n,), s, strictly increasing, n >= 5.
        points: Positions, shape (n, d), m.

    Returns:
        The smooth path. It stays within `TOLERANCE` of the samples used, and within
        `AVERAGE_TOLERANCE` on average over `AVERAGED_S` (as shares of the longest
        side of their box), or it interpolates them nearly.
    """
    outliers = find_outliers(t, points)
    kept = np.delete(np.arange(t.size), outliers)
    if kept.size < MIN_SAMPLES:
        kept = np.arange(t.size)
    path = _smoothed(t, points, kept, CUTOFF_HZ)
    side = float(np.max(np.ptp(points[kept], axis=0)))
    strays = find_strays(path(t[kept]) - points[kept], side)
    if 0 < strays.size <= kept.size - MIN_SAMPLES:
        kept = np.delete(kept, strays)
        path = _smoothed(t, points, kept, CUTOFF_HZ)
    while not _close(path, t[kept], points[kept]):
        path = _smoothed(t, points, kept, path.cutoff * CUTOFF_GROWTH)
    return path


def _smoothed(
    t: FloatArray, points: FloatArray, kept: IntArray, cutoff: float
) -> DenoisedPath:
    thin_t, thin = _thin(t[kept], points[kept])
    start, end = float(t[0]), float(t[-1])
    # The time axis of the fit has mean spacing 1: lambda scales with the fourth
    # power of the unit, and the solver's numbers stay near 1.
    unit = (end - start) / (thin_t.size - 1)
    u = (thin_t - start) / unit
    lam = (2.0 * np.pi * cutoff * unit) ** -4
    spline = make_smoothing_spline(u, thin, w=np.gradient(u), lam=lam)
    outliers = np.delete(np.arange(t.size), kept)
    return DenoisedPath(start, end, cutoff, outliers, spline, unit)


def _close(path: DenoisedPath, t: FloatArray, points: FloatArray) -> bool:
    """Whether a path is within the tolerance of samples, or goes through them."""
    if path.cutoff * path.unit > INTERPOLATING:
        return True
    side = float(np.max(np.ptp(points, axis=0)))
    off = path(t) - points
    largest = np.linalg.norm(off, axis=1).max()
    average = np.linalg.norm(_averaged(t, off), axis=1).max()
    return bool(largest <= TOLERANCE * side and average <= AVERAGE_TOLERANCE * side)


def _averaged(t: FloatArray, values: FloatArray) -> FloatArray:
    """Averages of values (n, d) over `AVERAGED_S` around each time, or over all."""
    edges = np.concatenate([t[:1], 0.5 * (t[1:] + t[:-1]), t[-1:]])
    areas = values * np.diff(edges)[:, None]
    sums = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(areas, axis=0)])
    window = min(AVERAGED_S, float(t[-1] - t[0]))
    low = np.clip(t - 0.5 * window, t[0], t[-1] - window)
    within = [
        np.interp(low + window, edges, column) - np.interp(low, edges, column)
        for column in sums.T
    ]
    return np.stack(within, axis=-1) / window


def _thin(t: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Averages samples closer in time than `MAX_RATE_HZ`; the ends stay."""
    if float(np.min(np.diff(t))) * MAX_RATE_HZ >= 1.0:
        return t, points
    # Never fewer than the spline needs, even for a stroke of a few milliseconds.
    rate = max(MAX_RATE_HZ, 4.0 * MIN_SAMPLES / float(t[-1] - t[0]))
    bins = np.floor((t - t[0]) * rate).astype(np.int64)
    bins[0], bins[-1] = -1, bins[-1] + 1
    _, groups = np.unique(bins, return_inverse=True)
    counts = np.bincount(groups).astype(np.float64)
    columns = [np.bincount(groups, column) / counts for column in (t, *points.T)]
    if counts.size < MIN_SAMPLES:
        return t, points
    return columns[0], np.stack(columns[1:], axis=-1)
