"""Quantiles of some ten thousand numbers: no more is put in order than must be."""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray, IntArray

# Quantiles are looked for in a histogram of this many bins first.
BINS = 512


def median(values: FloatArray) -> float:
    """Returns the median of finite numbers (n,), n > 0: numpy's, but sooner."""
    half = len(values) // 2
    parted = np.partition(values, half)
    if len(values) % 2 == 1:
        return float(parted[half])
    return float(0.5 * (parted[:half].max() + parted[half]))


@njit(cache=True)
def ordered(values: FloatArray, places: IntArray) -> FloatArray:
    """Returns what stands at each of some places once the values are in order.

    Args:
        values: (n,) finite, n > 0.
        places: (m,) from 0 to n - 1.
    """
    low, high = values.min(), values.max()
    found = np.full(len(places), low)
    if not high > low:
        return found
    scale = BINS / (high - low)
    counts = np.zeros(BINS, dtype=np.int64)
    bins = np.empty(len(values), dtype=np.int64)
    for i in range(len(values)):
        bins[i] = min(int((values[i] - low) * scale), BINS - 1)
        counts[bins[i]] += 1
    last, inside = -1, np.empty(0)
    for p in range(len(places)):
        k, before = 0, 0
        while places[p] >= before + counts[k]:
            before += counts[k]
            k += 1
        if k != last:
            inside = values[np.flatnonzero(bins == k)]
            # Not sort: the order of a tail is asked for too, and one compiles sooner.
            last, inside = k, inside[np.argsort(inside)]
        found[p] = inside[places[p] - before]
    return found


def trimmed_range(
    values: FloatArray, weights: FloatArray, trim: float
) -> tuple[float, float]:
    """Returns the weighted quantiles of `trim` and one minus it.

    Args:
        values: (n,) finite, n > 0.
        weights: (n,) not negative, of any sum but none.
        trim: Of the weight that is left out at either end.
    """
    shares = np.ascontiguousarray(weights / np.sum(weights))
    low = low_quantile(np.array(values), shares, trim)
    return low, -low_quantile(-values, shares, trim)


@njit(cache=True)
def low_quantile(values: FloatArray, weights: FloatArray, share: float) -> float:
    """Returns the weighted quantile; only the values up to it are put in order.

    Args:
        values: (n,).
        weights: (n,), of sum one.
        share: The quantile asked for.
    """
    lowest, highest = values.min(), values.max()
    if not highest > lowest:
        return float(lowest)
    tail = _tail(values, weights, share, lowest, BINS / (highest - lowest))
    order = tail[np.argsort(values[tail])]
    # Each point's weight is centred on it, so equal weights give the usual ones.
    before, last, at_last = 0.0, values[order[0]], -np.inf
    for k in order:
        at = before + 0.5 * weights[k]
        if at >= share:
            if at_last == -np.inf:
                return float(values[k])
            way = (values[k] - last) / (at - at_last)
            return float(last + way * (share - at_last))
        before, last, at_last = before + weights[k], values[k], at
    return float(last)


@njit(cache=True)
def _tail(
    values: FloatArray,
    weights: FloatArray,
    share: float,
    lowest: float,
    scale: float,
) -> IntArray:
    """Returns where the values are that tell the quantile: all up to some bin's end."""
    bins = np.empty(len(values), dtype=np.int64)
    cumulated = np.zeros(BINS)
    for i in range(len(values)):
        bins[i] = min(int((values[i] - lowest) * scale), BINS - 1)
        cumulated[bins[i]] += weights[i]
    for k in range(1, BINS):
        cumulated[k] += cumulated[k - 1]
    # The values on either side of the quantile are in this bin, the ones before it
    # or the next that is not empty.
    last = int(np.searchsorted(cumulated, share, side="right"))
    reached = cumulated[min(last, BINS - 1)]
    last = int(np.searchsorted(cumulated, reached, side="right"))
    return np.flatnonzero(bins <= last)
