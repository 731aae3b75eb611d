"""A smooth trend beside a known set of waves, fitted together.

The trend z of samples x at even steps is Whittaker's: it minimises |x - z|^2 +
lam |D^3 z|^2, D the differences (Eilers 2003). With waves B the two are fitted
jointly: the best trend for given coefficients c is S (x - B c), so that c solves
least squares in the inner product of I - S. No wave is bent by the trend, and the
trend's ends do not swing with the waves, as they would behind a filter.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky_banded
from scipy.linalg.lapack import dpbtrs

from bath_drake.notation import FloatArray

# Third differences: what is left of a wave of twice the cutoff's frequency is 1/65.
ORDER = 3


@dataclass(frozen=True, eq=False)
class Trend:
    """The smoother of one length and stiffness.

    Attributes:
        factor: Banded Cholesky factor of I + lam D'D.
    """

    factor: FloatArray

    def smooth(self, samples: FloatArray) -> FloatArray:
        """S x of samples, shape (m,) or (m, k)."""
        # LAPACK itself: what wraps it costs more than a short stroke's solution.
        smoothed, _ = dpbtrs(self.factor, samples)
        return np.asarray(smoothed).reshape(samples.shape)

    def rough(self, samples: FloatArray) -> FloatArray:
        """(I - S) x: what the trend leaves of samples, shape (m,) or (m, k)."""
        return np.asarray(samples - self.smooth(samples))


def make_trend(count: int, cutoff: float) -> Trend:
    """A trend that halves waves of a given frequency.

    Args:
        count: Samples, at least 8.
        cutoff: Waves a sample, in (0, 0.5).

    Raises:
        ValueError: On fewer samples or another cutoff.
    """
    if count < 8:
        raise ValueError(f"count must be at least 8, got {count}")
    if not 0.0 < cutoff < 0.5:
        raise ValueError(f"cutoff must be in (0, 0.5) waves a sample, got {cutoff}")
    # A difference multiplies a wave of angular step w by 2 sin(w/2).
    lam = (2.0 * np.sin(np.pi * cutoff)) ** (-2.0 * ORDER)
    difference = np.diff(np.eye(ORDER + 1), ORDER, axis=0)[0]
    bands = np.zeros((ORDER + 1, count))
    rows = count - ORDER
    for i in range(ORDER + 1):
        for j in range(i, ORDER + 1):
            # Upper form: the k-th diagonal lies in row ORDER - k, from column k on.
            bands[ORDER - (j - i), j : j + rows] += lam * difference[i] * difference[j]
    bands[ORDER] += 1.0
    return Trend(np.asarray(cholesky_banded(bands, lower=False)))
