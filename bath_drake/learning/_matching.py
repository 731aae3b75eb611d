"""How well a flow's direction matches what is wished, obstacle by obstacle, compiled.

The flow is a sum over the obstacles, so the best of many candidates for one more is
found without a roll-out.
"""

import math

import numpy as np
from numba import njit

from bath_drake.field._boundaries import quadratic_forms
from bath_drake.notation import FloatArray


@njit(cache=True, nogil=True)
def pushes(rows: FloatArray, points: FloatArray) -> FloatArray:
    """grad(beta_i) / beta_i of ellipses at points (T, 2), shape (n, T, 2).

    ``rows`` (n, 5) holds centre, semi-axes and angle. A point within an ellipse
    is pushed as hard as one just outside of it: such a candidate matches nothing.
    """
    forms = quadratic_forms(rows, np.ones(rows.shape[0]))
    out = np.empty((rows.shape[0], points.shape[0], 2))
    for i in range(rows.shape[0]):
        for t in range(points.shape[0]):
            dx = points[t, 0] - forms[i, 0]
            dy = points[t, 1] - forms[i, 1]
            gx = forms[i, 2] * dx + forms[i, 3] * dy
            gy = forms[i, 3] * dx + forms[i, 4] * dy
            beta = max(gx * dx + gy * dy - 1.0, 1e-2)
            out[i, t, 0] = 2.0 * gx / beta
            out[i, t, 1] = 2.0 * gy / beta
    return out


@njit(cache=True, nogil=True)
def mismatches(
    base: FloatArray,
    pulls: FloatArray,
    added: FloatArray,
    kappas: FloatArray,
    wished: FloatArray,
    weights: FloatArray,
) -> FloatArray:
    """Weighted sums of 1 - cos(flow, wish) for every candidate and kappa, (n, K).

    At T points: ``base`` (T, 2) is gamma times the pushes of all that is there
    already, ``pulls`` (T, 2) the goal's per kappa, ``added`` (n, T, 2) gamma times
    the candidates' pushes, ``wished`` (T, 2) unit vectors, ``weights`` (T,).
    """
    n, count = added.shape[:2]
    out = np.zeros((n, kappas.shape[0]))
    for i in range(n):
        for k in range(kappas.shape[0]):
            total = 0.0
            for t in range(count):
                vx = base[t, 0] + added[i, t, 0] + kappas[k] * pulls[t, 0]
                vy = base[t, 1] + added[i, t, 1] + kappas[k] * pulls[t, 1]
                along = vx * wished[t, 0] + vy * wished[t, 1]
                norm = math.sqrt(vx * vx + vy * vy) + 1e-12
                total += weights[t] * (1.0 - along / norm)
            out[i, k] = total
    return out


@njit(cache=True, nogil=True)
def clearances(centres: FloatArray, points: FloatArray) -> FloatArray:
    """Distance of each of n centres (n, 2) to the nearest of points (K, 2): (n,)."""
    out = np.empty(centres.shape[0])
    for i in range(centres.shape[0]):
        least = math.inf
        for k in range(points.shape[0]):
            dx = points[k, 0] - centres[i, 0]
            dy = points[k, 1] - centres[i, 1]
            least = min(least, dx * dx + dy * dy)
        out[i] = math.sqrt(least)
    return out
