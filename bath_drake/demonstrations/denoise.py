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

from bath_drake.notation import FloatArray, IntArray

# Half gain here: 4 Hz passes with 3.8 %, 12 Hz with 0.05 %, 0.3 Hz with 99.9 %.
CUTOFF_HZ = 1.8
# A faster stroke would be cut. The cutoff rises until the smoothed path stays this
# close to the recorded one, as a share of the longest side of the path's box; hand
# tremor of 1 cm on a stroke across the back is just below.
TOLERANCE = 0.025
CUTOFF_GROWTH = 1.25
# At this many cycles a sample the spline goes through every sample.
INTERPOLATING = 100.0
# Nothing a hand does needs more samples, and closer ones make the spline stiff.
MAX_RATE_HZ = 200.0
MIN_SAMPLES = 5
# A step there and back at this multiple of the speed around it is no hand's.
OUTLIER_SPEED = 6.0
# ... if it also leaves the path by this share of the box's longest side.
OUTLIER_SIZE = 0.02
OUTLIER_LENGTH = 3
OUTLIER_WINDOW = 10


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
        The smooth path. It stays within `TOLERANCE` of the samples used (as a
        share of the longest side of their box), or interpolates them nearly.
    """
    outliers = find_outliers(t, points)
    kept_t = np.delete(t, outliers)
    kept = np.delete(points, outliers, axis=0)
    if kept_t.size < MIN_SAMPLES:
        outliers, kept_t, kept = outliers[:0], t, points
    kept_t, kept = _thin(kept_t, kept)
    allowed = TOLERANCE * float(np.max(np.ptp(kept, axis=0)))
    start, end = float(t[0]), float(t[-1])
    # The time axis of the fit has mean spacing 1: lambda scales with the fourth
    # power of the unit, and the solver's numbers stay near 1.
    unit = (end - start) / (kept_t.size - 1)
    u = (kept_t - start) / unit
    shares = np.gradient(u)
    cutoff = CUTOFF_HZ
    while True:
        lam = (2.0 * np.pi * cutoff * unit) ** -4
        spline = make_smoothing_spline(u, kept, w=shares, lam=lam)
        error = float(np.max(np.linalg.norm(spline(u) - kept, axis=1)))
        if error <= allowed or cutoff * unit > INTERPOLATING:
            return DenoisedPath(start, end, cutoff, outliers, spline, unit)
        cutoff *= CUTOFF_GROWTH


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


def find_outliers(t: FloatArray, points: FloatArray) -> IntArray:
    """Finds samples that jump away from the path and back.

    A run of at most three samples is out when the steps into it and out of it are
    both far longer than the steps around, and longer than what is left between its
    neighbours once it is gone. The first and last samples never are: nothing
    tells a jump there from a motion.

    Args:
        t: Times, shape (n,), s, strictly increasing.
        points: Positions, shape (n, d), m.

    Returns:
        Indices of the outliers, shape (k,), increasing.
    """
    count = t.size
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    speeds = steps / np.diff(t)
    smallest = OUTLIER_SIZE * float(np.max(np.ptp(points, axis=0)))
    out = np.zeros(count, dtype=np.bool_)
    for length in range(1, min(OUTLIER_LENGTH, count - 2) + 1):
        into, back = steps[: count - 1 - length], steps[length:]
        gap = points[length + 1 :] - points[: -length - 1]
        across = np.linalg.norm(gap, axis=1)
        jumps = np.minimum(into, back) > np.maximum(smallest, 2.0 * across)
        for first in np.flatnonzero(jumps) + 1:
            last = first + length
            around = np.r_[
                speeds[max(0, first - 1 - OUTLIER_WINDOW) : first - 1],
                speeds[last : last + OUTLIER_WINDOW],
            ]
            usual = float(np.median(around)) if around.size else np.inf
            jump = min(speeds[first - 1], speeds[last - 1])
            # A neighbour found before has steps of its own that would mislead.
            if jump > OUTLIER_SPEED * usual and not np.any(out[first - 1 : last + 1]):
                out[first:last] = True
    return np.flatnonzero(out)
