"""The discrete Fréchet distance, compiled: exact, and only as much as is needed.

The textbook's dynamic programme over the pairs (i, j) of points,

    D(i, j) = max(|a_i - b_j|, min(D(i-1, j), D(i, j-1), D(i-1, j-1))),

takes only minima and maxima, which do not round: in whatever order its cells come,
and however many that cannot matter are left out, the result is the same to the last
bit. Three things are made of that freedom. Distances stay squared until the end.
Cells come by anti-diagonals i + j = k, where none waits for another, so that the
processor does eight at once. And a greedy coupling comes first: its leash is an upper
bound, and only cells below it can be part of a better coupling. They lie in a band,
which is narrow where two strokes are alike.

All release the interpreter lock. Squares must neither overflow nor underflow:
`bath_drake.learning.frechet` sees to that, and canonical coordinates do by themselves.
"""

import math

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray

# Cells come in blocks of as many doubles as the widest registers hold.
_BLOCK = 8


@njit(cache=True, nogil=True)
def frechet(a: FloatArray, n: int, b: FloatArray) -> float:
    """Discrete Fréchet distance of a[:n] and b (m, 2)."""
    return math.sqrt(squared_frechet(a, n, b, math.inf))


@njit(cache=True, nogil=True)
def squared_frechet(a: FloatArray, n: int, b: FloatArray, bound: float) -> float:
    """The smaller of a bound and the squared distance of a[:n] and b (m, 2).

    The smaller the bound, the faster: pairs that are farther apart are left out.
    """
    m = b.shape[0]
    least = max(_square(a, 0, b, 0), _square(a, n - 1, b, m - 1))
    if least >= bound:
        return bound
    bound = min(bound, _greedy(a, n, b))
    if least >= bound:
        return bound
    return _below(a, n, b, bound)


@njit(cache=True, nogil=True)
def _square(a: FloatArray, i: int, b: FloatArray, j: int) -> float:
    dx = a[i, 0] - b[j, 0]
    dy = a[i, 1] - b[j, 1]
    return float(dx * dx + dy * dy)


@njit(cache=True, nogil=True)
def _greedy(a: FloatArray, n: int, b: FloatArray) -> float:
    """The squared leash of the coupling that always takes the nearest next pair."""
    m = b.shape[0]
    i = 0
    j = 0
    leash = _square(a, 0, b, 0)
    while i < n - 1 and j < m - 1:
        both = _square(a, i + 1, b, j + 1)
        one = _square(a, i + 1, b, j)
        other = _square(a, i, b, j + 1)
        if both <= one and both <= other:
            i += 1
            j += 1
            leash = max(leash, both)
        elif one <= other:
            i += 1
            leash = max(leash, one)
        else:
            j += 1
            leash = max(leash, other)
    for k in range(i + 1, n):
        leash = max(leash, _square(a, k, b, m - 1))
    for k in range(j + 1, m):
        leash = max(leash, _square(a, n - 1, b, k))
    return leash


@njit(cache=True, nogil=True)
def _below(a: FloatArray, n: int, b: FloatArray, bound: float) -> float:
    """The smaller of a bound and the squared distance; the first pair is below it.

    Cells (i, k - i) of the k-th anti-diagonal lie at index i. Blocks of them overhang
    the grid and the band. There b is padded with inf, and so cells are inf; cells of
    the band's edge may be too large, but only if their true value reaches the bound.
    """
    m = b.shape[0]
    size = (n + _BLOCK - 1) // _BLOCK * _BLOCK
    ax = np.zeros(size)
    ay = np.zeros(size)
    bx = np.full(m + 2 * _BLOCK, np.inf)
    by = np.full(m + 2 * _BLOCK, np.inf)
    for i in range(n):
        ax[i] = a[i, 0]
        ay[i] = a[i, 1]
    for j in range(m):
        bx[_BLOCK + m - 1 - j] = b[j, 0]
        by[_BLOCK + m - 1 - j] = b[j, 1]
    square = np.empty(size)
    # The diagonal before; and of the last two, the smaller of the cells at i - 1.
    cells = np.full(size, np.inf)
    before = np.full(size + 1, np.inf)
    after = np.full(size + 1, np.inf)
    cells[0] = _square(a, 0, b, 0)
    before[1] = cells[0]
    # Of the last two diagonals, the cells below the bound; and where blocks end.
    low = 0
    high = 0
    end = _BLOCK
    for k in range(1, n + m - 1):
        low = max(low, k - m + 1)
        high = min(high + 1, n - 1)
        if low > high:
            return bound
        start = low // _BLOCK * _BLOCK
        ended = end
        end = (high // _BLOCK + 1) * _BLOCK
        # Where a band shrank it may grow again. What is left there is not below the
        # bound, but for what `after` holds of the diagonals before it shrank.
        for i in range(end, ended):
            after[i + 1] = np.inf
        shift = _BLOCK + m - 1 - k
        # Two loops, with few arrays in each and as long as their slices: otherwise
        # the compiler finds too much to check before it may use vectors.
        px = ax[start:end]
        py = ay[start:end]
        qx = bx[shift + start : shift + end]
        qy = by[shift + start : shift + end]
        s = square[start:end]
        for t in range(len(s)):
            dx = px[t] - qx[t]
            dy = py[t] - qy[t]
            s[t] = dx * dx + dy * dy
        c = cells[start:end]
        best = before[start:end]
        following = after[start + 1 : end + 1]
        for t in range(len(c)):
            last = c[t]
            now = max(s[t], min(last, best[t]))
            c[t] = now
            following[t] = min(last, now)
        after[start] = np.inf
        # The band may be too wide for a while: looking at its edges costs as well.
        if k % _BLOCK == 0:
            while low <= high and after[low + 1] >= bound:
                low += 1
            while low <= high and after[high + 1] >= bound:
                high -= 1
        before, after = after, before
    return float(min(bound, cells[n - 1]))


@njit(cache=True, nogil=True)
def bottleneck(a: FloatArray, n: int, b: FloatArray) -> tuple[float, int, int]:
    """Discrete Fréchet distance of a[:n] and b, and the pair of points it is between.

    Where several pairs are as far apart, it is one that an optimal coupling needs.
    """
    m = b.shape[0]
    value = squared_frechet(a, n, b, math.inf)
    found = 0
    row = 0
    for i in range(n):
        hits = 0
        for j in range(m):
            hits += _square(a, i, b, j) == value
        if hits > 0:
            row = i
            found += hits
    if found == 1:
        for j in range(m):
            if _square(a, row, b, j) == value:
                return math.sqrt(value), row, j
    return scaled_bottleneck(a, n, b, 1.0)


@njit(cache=True, nogil=True)
def scaled_bottleneck(
    a: FloatArray, n: int, b: FloatArray, scale: float
) -> tuple[float, int, int]:
    """As `bottleneck`, row by row, with differences scaled before they are squared.

    With a power of two, the distance is what it would be if squares had no limits.
    """
    m = b.shape[0]
    value = np.empty(m)
    pair = np.empty(m, dtype=np.int64)
    for i in range(n):
        corner = math.inf
        corner_pair = 0
        for j in range(m):
            dx = (a[i, 0] - b[j, 0]) * scale
            dy = (a[i, 1] - b[j, 1]) * scale
            s = dx * dx + dy * dy
            # The best predecessor: diagonal, then above, then to the left.
            best = corner
            best_pair = corner_pair
            if i > 0:
                corner = value[j]
                corner_pair = pair[j]
                if corner < best:
                    best = corner
                    best_pair = corner_pair
            if j > 0 and value[j - 1] < best:
                best = value[j - 1]
                best_pair = pair[j - 1]
            if i + j == 0 or s >= best:
                best = s
                best_pair = i * m + j
            value[j] = best
            pair[j] = best_pair
    return math.sqrt(value[m - 1]) / scale, pair[m - 1] // m, pair[m - 1] % m


@njit(cache=True, nogil=True)
def all_finite(points: FloatArray) -> bool:
    """Whether no coordinate of points (n, 2) is infinite or NaN."""
    for i in range(points.shape[0]):
        if not (math.isfinite(points[i, 0]) and math.isfinite(points[i, 1])):
            return False
    return True
