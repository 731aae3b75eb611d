"""Forward kinematics, compiled.

In the arm's base frame B; see `bath_drake.reach.kinematics` for what they mean. The
arm's dimensions are arguments, for numba freezes what is global.
"""

import numpy as np
from numba import njit

from bath_drake.control._joint_velocities import ROWS
from bath_drake.notation import FloatArray
from bath_drake.safety.arm_chain import next_link

_JOINTS = 7


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
