"""Forward kinematics and the steps of the inverse kinematics, compiled.

In the arm's base frame B; see `bath_drake.reach.kinematics` and
`bath_drake.reach.follow` for what they mean. The arm's dimensions are arguments, for
numba freezes what is global.
"""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray
from bath_drake.safety.arm_chain import next_link

# Rows of the Jacobian in E: all but the turn about the jet.
_ROWS = 5
_JOINTS = 7
# Below such a share of the greatest singular value a direction is given up.
_LEAST_SHARE = 1e-4
# How many joints may stand at a bound before the nozzle must stay behind.
_MOST_BOUND = 2
_SHORT, _TOO_FAST = -1, -2
# How often a velocity that is too fast is halved.
_SLOWER = 4
# A pose is met within this, rad and m, or is waited for in so many steps at most.
# and no more once a step brings it no nearer than to such a share.
_NEAR, _NEARER, _PATIENCE = 1e-3, 0.96, 16


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
    return float(np.sqrt(values[_ROWS - 1] / values[0]))


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
        all of V's directions, and the others are gone; _TOO_FAST if too many joints
        would pass their bounds: then v says nothing.
    """
    bound = np.zeros(_JOINTS)
    count = 0
    left = np.empty(_ROWS)
    A = np.empty((_ROWS, _JOINTS))
    while True:
        for i in range(_ROWS):
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
        for i in range(_ROWS):
            # Directions that are as good as lost are given up.
            if not values[i] > values[_ROWS - 1] * _LEAST_SHARE**2:
                short += 1
                continue
            share = 0.0
            for j in range(_ROWS):
                share += U[j, i] * left[j]
            share /= values[i]
            for k in range(_JOINTS):
                if bound[k] == 0.0:
                    for j in range(_ROWS):
                        v[k] += A[j, k] * U[j, i] * share
        worst, most = -1, 1e-9
        for k in range(_JOINTS):
            over = max(v[k] - high[k], low[k] - v[k])
            if bound[k] == 0.0 and over > most:
                worst, most = k, over
        if worst < 0:
            return count if short == 0 else _SHORT
        if count == _MOST_BOUND:
            return _TOO_FAST
        bound[worst] = 1.0
        v[worst] = min(max(v[worst], low[worst]), high[worst])
        count += 1


@njit(cache=True)
def follow(
    q: FloatArray,
    tips: FloatArray,
    jets: FloatArray,
    seconds: FloatArray,
    posture: FloatArray,
    low: FloatArray,
    high: FloatArray,
    speed: FloatArray,
    origins: FloatArray,
    turns: FloatArray,
    tip: FloatArray,
    positions: FloatArray,
    facts: FloatArray,
) -> None:
    """Follows poses from q (7,) on, which is left where the last one was.

    Args:
        q: In and out, rad.
        tips: (n, 3) places of the nozzle's tip in B, m.
        jets: (n, 3) unit vectors along the jet.
        seconds: (n,) what each step takes.
        posture: (7,) that the null space is drawn to with 1/s, rad.
        low: (7,) rad.
        high: (7,) rad.
        speed: (7,) rad/s.
        origins: As of `pose_and_jacobian`.
        turns: The same.
        tip: The same.
        positions: (n, 7) out, rad.
        facts: (n, 4) out: condition number, distance from the wanted place (m), angle
            to the wanted jet (rad), the joint at its limit (-1: none).
    """
    p, R, J = np.empty(3), np.empty((3, 3)), np.empty((_ROWS, _JOINTS))
    V, wanted, v = np.empty(_ROWS), np.empty(_JOINTS), np.empty(_JOINTS)
    least, most = np.empty(_JOINTS), np.empty(_JOINTS)
    pose_and_jacobian(q, origins, turns, tip, p, R, J)
    for n in range(len(tips)):
        dt, before = seconds[n], np.inf
        for _ in range(_PATIENCE):
            _twist(p, R, tips[n], jets[n], dt, V)
            for k in range(_JOINTS):
                least[k] = max(-speed[k], (low[k] - q[k]) / dt)
                most[k] = min(speed[k], (high[k] - q[k]) / dt)
                # Exactly what a long step of the pull with 1/s comes to.
                wanted[k] = (posture[k] - q[k]) * (1.0 - np.exp(-dt)) / dt
            # Slower in the same direction, where it would be too fast.
            found = solve(J, V, wanted, least, most, v)
            for _ in range(_SLOWER):
                if found != _TOO_FAST:
                    break
                for k in range(_JOINTS):
                    wanted[k] *= 0.5
                for k in range(_ROWS):
                    V[k] *= 0.5
                found = solve(J, V, wanted, least, most, v)
            for k in range(_JOINTS):
                if found == _TOO_FAST:
                    v[k] = 0.0
                q[k] = min(max(q[k] + dt * v[k], low[k]), high[k])
                positions[n, k] = q[k]
            pose_and_jacobian(q, origins, turns, tip, p, R, J)
            _twist(p, R, tips[n], jets[n], 1.0, V)
            # The loop waits for an arm that lags, as long as it comes nearer.
            behind = np.abs(V).max()
            if behind < _NEAR or behind > _NEARER * before:
                break
            before = behind
        facts[n, 0] = condition(J)
        facts[n, 1] = np.sqrt(V[2] ** 2 + V[3] ** 2 + V[4] ** 2)
        facts[n, 2] = np.sqrt(V[0] ** 2 + V[1] ** 2)
        facts[n, 3] = -1.0
        for k in range(_JOINTS):
            if q[k] < low[k] + 1e-6 or q[k] > high[k] - 1e-6:
                facts[n, 3] = k


@njit(cache=True)
def _twist(
    p: FloatArray,
    R: FloatArray,
    there: FloatArray,
    jet: FloatArray,
    dt: float,
    V: FloatArray,
) -> None:
    """Writes the five rows of the twist in E that leads to a pose in dt."""
    along = across_x = across_y = 0.0
    for j in range(3):
        across_x += R[j, 0] * jet[j]
        across_y += R[j, 1] * jet[j]
        along += R[j, 2] * jet[j]
    sine = np.sqrt(across_x**2 + across_y**2)
    turn = np.arctan2(sine, along)
    share = turn / sine / dt if sine > 1e-12 else 0.0
    # z x jet, in E: the least turn from the one to the other.
    V[0], V[1] = -across_y * share, across_x * share
    for i in range(3):
        V[2 + i] = 0.0
        for j in range(3):
            V[2 + i] += R[j, i] * (there[j] - p[j]) / dt
