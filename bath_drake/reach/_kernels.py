"""Forward kinematics and one step of the inverse kinematics, compiled.

In the arm's base frame B; see `bath_drake.reach.kinematics` for what they mean. The
arm's dimensions are arguments, for numba freezes what is global.
"""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray
from bath_drake.safety.arm_chain import next_link

# Rows of the Jacobian in E: all but the turn about the jet.
ROWS = 5
_JOINTS = 7
# Below such a share of the greatest singular value a direction is given up.
_LEAST_SHARE = 1e-4
# How many joints may stand at a bound before the nozzle must stay behind.
_MOST_BOUND = 2
_SHORT, TOO_FAST = -1, -2


@njit(cache=True)
def pose_and_jacobian(
    q: FloatArray,
    origins: FloatArray,
    turns: FloatArray,
    tip: FloatArray,
    p: FloatArray,
    R: FloatArray,
    J: FloatArray,
) -> None:
    """Writes the tip's place p (3,), R_BE (3, 3) and five rows of J in E (5, 7).

    Args:
        q: (7,) joint positions, rad.
        origins: (7, 3) each joint's origin in the link before it, m.
        turns: (7, 3, 3) its axes there, while the joint is at zero.
        tip: (3, 4) axes and origin of E in link 7, m.
        p: Out.
        R: Out.
        J: Out: turns about E's x and y, shifts along E's x, y and z.
    """
    A, B = np.eye(3), np.empty((3, 3))
    at = np.empty((_JOINTS, 3))
    axes = np.empty((_JOINTS, 3))
    for i in range(3):
        p[i] = 0.0
    for k in range(_JOINTS):
        next_link(p, A, B, origins[k], turns[k], q[k])
        for i in range(3):
            axes[k, i] = B[i, 2]
            at[k, i] = p[i]
        A, B = B, A
    for i in range(3):
        for j in range(3):
            p[i] += A[i, j] * tip[j, 3]
            R[i, j] = A[i, 0] * tip[0, j] + A[i, 1] * tip[1, j] + A[i, 2] * tip[2, j]
    for k in range(_JOINTS):
        rx, ry, rz = p[0] - at[k, 0], p[1] - at[k, 1], p[2] - at[k, 2]
        wx, wy, wz = axes[k, 0], axes[k, 1], axes[k, 2]
        vx, vy, vz = wy * rz - wz * ry, wz * rx - wx * rz, wx * ry - wy * rx
        for i in range(2):
            J[i, k] = R[0, i] * wx + R[1, i] * wy + R[2, i] * wz
        for i in range(3):
            J[2 + i, k] = R[0, i] * vx + R[1, i] * vy + R[2, i] * vz


@njit(cache=True)
def condition(J: FloatArray) -> float:
    """Greatest by least singular value of J (5, 7)."""
    values = np.linalg.eigvalsh(J @ J.T)
    if not values[0] > 0.0:
        return np.inf
    return float(np.sqrt(values[ROWS - 1] / values[0]))


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
        How many joints stand at a bound; _SHORT if the joints that are left cannot go
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
