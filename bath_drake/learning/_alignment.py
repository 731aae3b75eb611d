"""Which point of one stroke answers to which of another: time warping, compiled."""

import numpy as np

from bath_drake.field._boundaries import compiled
from bath_drake.notation import FloatArray


@compiled
def matches(reference: FloatArray, stroke: FloatArray) -> FloatArray:
    """For each point of the reference (T, 2) the mean index it has in a stroke (n, 2).

    The monotone coupling of both ends with the least sum of squared distances.
    """
    n, m = reference.shape[0], stroke.shape[0]
    table = np.empty((n, m))
    for i in range(n):
        for j in range(m):
            dx = reference[i, 0] - stroke[j, 0]
            dy = reference[i, 1] - stroke[j, 1]
            d = dx * dx + dy * dy
            if i > 0 and j > 0:
                d += min(table[i - 1, j - 1], min(table[i - 1, j], table[i, j - 1]))
            elif i > 0:
                d += table[i - 1, j]
            elif j > 0:
                d += table[i, j - 1]
            table[i, j] = d
    total = np.zeros(n)
    count = np.zeros(n)
    i = n - 1
    j = m - 1
    while True:
        total[i] += j
        count[i] += 1.0
        if i == 0 and j == 0:
            break
        if i == 0:
            j -= 1
        elif j == 0:
            i -= 1
        else:
            both = table[i - 1, j - 1]
            up = table[i - 1, j]
            left = table[i, j - 1]
            if both <= up and both <= left:
                i -= 1
                j -= 1
            elif up <= left:
                i -= 1
            else:
                j -= 1
    return total / count
