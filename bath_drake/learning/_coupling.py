"""Which point of a stroke a roll-out's point answers for, compiled.

Both run forward only; the best such coupling is found by dynamic programming, and
held while the roll-outs are linearised.
"""

from numba import njit

from bath_drake.notation import FloatArray, IntArray


@njit(cache=True, nogil=True)
def _couple(
    path: FloatArray,
    n: int,
    target: FloatArray,
    m: int,
    power: float,
    weight: FloatArray,
    pull: FloatArray,
    table: FloatArray,
) -> float:
    """Best monotone coupling of a path and a target under sum |difference|^power."""
    half = 0.5 * power
    for i in range(n):
        x = path[i, 0]
        y = path[i, 1]
        row = table[i]
        # First what does not hang on its neighbour: it goes several at a time.
        for j in range(m):
            dx = x - target[j, 0]
            dy = y - target[j, 1]
            row[j] = dx * dx + dy * dy + 1e-12
        if power == 6.0:
            for j in range(m):
                row[j] = row[j] * row[j] * row[j]
        elif power != 2.0:
            for j in range(m):
                row[j] = row[j] ** half
        if i == 0:
            for j in range(1, m):
                row[j] += row[j - 1]
            continue
        above = table[i - 1]
        last = row[0] + above[0]
        row[0] = last
        for j in range(1, m):
            before = above[j] if above[j] < above[j - 1] else above[j - 1]
            last = row[j] + (last if last < before else before)
            row[j] = last
    for i in range(n):
        weight[i] = 0.0
        pull[i, 0] = 0.0
        pull[i, 1] = 0.0
    i = n - 1
    j = m - 1
    while True:
        dx = path[i, 0] - target[j, 0]
        dy = path[i, 1] - target[j, 1]
        w = 1.0
        if power != 2.0:
            w = (dx * dx + dy * dy + 1e-12) ** (half - 1.0)
        weight[i] += w
        pull[i, 0] += w * dx
        pull[i, 1] += w * dy
        if i == 0 and j == 0:
            break
        if i == 0:
            j -= 1
        elif j == 0:
            i -= 1
        else:
            a = table[i - 1, j - 1]
            b = table[i - 1, j]
            c = table[i, j - 1]
            if a <= b and a <= c:
                i -= 1
                j -= 1
            elif b <= c:
                i -= 1
            else:
                j -= 1
    return float(table[n - 1, m - 1])


@njit(cache=True, nogil=True)
def couple_windows(
    paths: FloatArray,
    counts: IntArray,
    targets: FloatArray,
    lengths: IntArray,
    weights: FloatArray,
    power: float,
    weight: FloatArray,
    pull: FloatArray,
    table: FloatArray,
) -> float:
    """The windows' cost, and the pull of their coupling on every path point.

    For each window F = (mean |difference|^power)^(1/power) over the best monotone
    coupling. Returns sum_w weights F and fills ``weight`` (W, T) and the weighted mean
    differences ``pull`` (W, T, 2) such that, the coupling held, F is locally a sum of
    weight |point - target|^2 / 2. ``table`` is room to work in.
    """
    total = 0.0
    for w in range(paths.shape[0]):
        m = lengths[w]
        steps = counts[w] + 1
        value = _couple(
            paths[w], steps, targets[w], m, power, weight[w], pull[w], table
        )
        f = (value / m) ** (1.0 / power)
        total += weights[w] * f
        # d F = F^(1 - p) / m * sum |d|^(p - 2) d . dx
        scale = weights[w] * max(f, 1e-3) ** (1.0 - power) / m
        for i in range(steps):
            if weight[w, i] > 0.0:
                pull[w, i, 0] /= weight[w, i]
                pull[w, i, 1] /= weight[w, i]
            weight[w, i] *= scale
    return total
