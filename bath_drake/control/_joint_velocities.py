"""One step of the inverse kinematics, compiled: joint velocities for one of the nozzle.

It is told in the nozzle's frame E, without the turn about the jet.
"""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray

# Rows of the Jacobian in E: all but the turn about the jet.
ROWS = 5
_JOINTS = 7
# Below such a share of the greatest singular value a direction is given up.
_LEAST_SHARE = 1e-4
# How many joints may stand at a bound before the nozzle must stay behind.
_MOST_BOUND = 2
FREE, _SHORT, TOO_FAST = 0, -1, -2


@njit(cache=True)
def solve(
    J: FloatArray,
    V: FloatArray,
    wanted: FloatArray,
    low: FloatArray,
    high: FloatArray,
    v: FloatArray,
) -> int:
    """Writes joint velocities v (7,) with J v = V, else nearest to `wanted` (7,).

    The solution of Drake's DoDifferentialInverseKinematics where it keeps up with V.
    One joint after another that would pass its bound is left standing there.

    Returns:
        How many joints stand at a bound, FREE if none does: then nothing else is as
        near to `wanted`; _SHORT if the joints that are left cannot go
        all of V's directions, and the others are gone; TOO_FAST if too many joints
        would pass their bounds: then v says nothing.
    """
    bound = np.zeros(_JOINTS)
    count = 0
    left = np.empty(ROWS)
    A = np.empty((ROWS, _JOINTS))
    while True:
        for i in range(ROWS):
            left[i] = V[i]
            for k in range(_JOINTS):
                if bound[k] != 0.0:
                    left[i] -= J[i, k] * v[k]
                    A[i, k] = 0.0
                else:
                    left[i] -= J[i, k] * wanted[k]
                    A[i, k] = J[i, k]
        values, U = np.linalg.eigh(A @ A.T)
        short = 0
        for k in range(_JOINTS):
            if bound[k] == 0.0:
                v[k] = wanted[k]
        for i in range(ROWS):
            # Directions that are as good as lost are given up.
            if not values[i] > values[ROWS - 1] * _LEAST_SHARE**2:
                short += 1
                continue
            share = 0.0
            for j in range(ROWS):
                share += U[j, i] * left[j]
            share /= values[i]
            for k in range(_JOINTS):
                if bound[k] == 0.0:
                    for j in range(ROWS):
                        v[k] += A[j, k] * U[j, i] * share
        worst, most = -1, 1e-9
        for k in range(_JOINTS):
            over = max(v[k] - high[k], low[k] - v[k])
            if bound[k] == 0.0 and over > most:
                worst, most = k, over
        if worst < 0:
            return count if short == 0 else _SHORT
        if count == _MOST_BOUND:
            return TOO_FAST
        bound[worst] = 1.0
        v[worst] = min(max(v[worst], low[worst]), high[worst])
        count += 1
