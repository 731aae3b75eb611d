"""How the arm follows poses, compiled; in the arm's base frame B.

See `bath_drake.reach.follow` for what it means.
"""

import numpy as np
from numba import njit

from bath_drake.control._joint_velocities import ROWS, TOO_FAST, solve
from bath_drake.control._keeping_off import (
    bend,
    damped_share,
    push_away,
    reachable_share,
)
from bath_drake.notation import FloatArray, IntArray
from bath_drake.reach._kernels import condition, pose_and_jacobian
from bath_drake.safety._box_distance import ArmArrays, BoxArrays, gaps
from bath_drake.safety.self_gaps import write_gaps

# Columns of what is told of a pose.
CONDITION, PLACE_ERROR, JET_ERROR, AT_LIMIT, GAP, SLOWED = range(6)
FACTS = 6
# How often a velocity that is too fast is halved.
_SLOWER = 4
# A pose is met within this, rad and m, or is waited for in so many steps at most,
# and no more once a step brings it no nearer than to such a share.
_NEAR, _NEARER, _PATIENCE = 1e-3, 0.96, 16
# One that is slowed to keep links off is waited for while its null space still moves
# them away, rad/s, in so many steps at most.
_MOVING, _LONG_PATIENCE = 0.01, 60
# The inverse kinematics minds what is nearer than so often where it begins to avoid.
_MINDED = 2.0


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
    nozzle_speed: tuple[float, float],
    arm: ArmArrays,
    pairs: IntArray,
    tip: FloatArray,
    boxes: BoxArrays,
    avoidance: tuple[float, float, float, float, float],
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
        nozzle_speed: What the nozzle is led with at most: rad/s, m/s.
        arm: As of `gaps`.
        pairs: (m, 2) of its capsules, which must not touch.
        tip: As of `pose_and_jacobian`.
        boxes: As of `gaps`.
        avoidance: stop, near, gain, push and self_stop of `AvoidanceConfig`.
        positions: (n, 7) out, rad.
        facts: (n, FACTS) out: condition number, distance from the wanted place (m),
            angle to the wanted jet (rad), the joint at its limit (-1: none), least
            distance of a link from a box (m), 1 if the nozzle lags for one else 0.
    """
    origins, turns, capsules = arm
    stop, near, gain, most_push, self_stop = avoidance
    # As in the inverse kinematics, pairs of links are told as much nearer.
    further = self_stop - stop
    joints, minded = len(q), _MINDED * near
    p, R, J = np.empty(3), np.empty((3, 3)), np.empty((ROWS, joints))
    V, wanted, v = np.empty(ROWS), np.empty(joints), np.empty(joints)
    least, most = np.empty(joints), np.empty(joints)
    every = np.empty((len(capsules) + len(pairs), 1 + joints))
    pose_and_jacobian(q, origins, turns, tip, p, R, J)
    gap, count = _look(q, arm, pairs, boxes, minded, near, further, every)
    # Whether it was slowed for a link and has not caught up since.
    late = False
    for n in range(len(tips)):
        dt, before = seconds[n], np.inf
        # Exactly what a long step of a pull with 1/s comes to.
        pull = (1.0 - np.exp(-dt)) / dt
        facts[n, GAP] = gap
        for step in range(_LONG_PATIENCE):
            rows = every[:count]
            nearest = rows[:, 0].min()
            _twist(p, R, tips[n], jets[n], dt, V)
            # One that lags is led no faster: what is asked for slows all the rest too.
            if nearest < near:
                _limit(V, nozzle_speed)
            for k in range(joints):
                least[k] = max(-speed[k], (low[k] - q[k]) / dt)
                most[k] = min(speed[k], (high[k] - q[k]) / dt)
                wanted[k] = (posture[k] - q[k]) * pull
            if nearest < near:
                push = push_away(rows, near, gain, most_push)
                for k in range(joints):
                    wanted[k] += push[k] * pull
            _solve_slower(J, V, wanted, least, most, v)
            share = 1.0
            if nearest < minded and damped_share(v, rows, stop, gain) < 1.0:
                added = bend(v, J, rows, stop, gain)
                v += reachable_share(v, added, least, most) * added
                share = damped_share(v, rows, stop, gain)
                v *= share
                late = late or share < 1.0
            for k in range(joints):
                q[k] = min(max(q[k] + dt * v[k], low[k]), high[k])
            pose_and_jacobian(q, origins, turns, tip, p, R, J)
            gap, count = _look(q, arm, pairs, boxes, minded, near, further, every)
            facts[n, GAP] = min(facts[n, GAP], gap)
            _twist(p, R, tips[n], jets[n], 1.0, V)
            # The loop waits for an arm that lags, as long as it comes nearer.
            behind = np.abs(V).max()
            if behind < _NEAR:
                late = False
                break
            moving = share < 1.0 and np.abs(v).max() > _MOVING
            if not moving and (behind > _NEARER * before or step + 1 >= _PATIENCE):
                break
            before = behind
        for k in range(joints):
            positions[n, k] = q[k]
        facts[n, CONDITION] = condition(J)
        facts[n, PLACE_ERROR] = np.sqrt(V[2] ** 2 + V[3] ** 2 + V[4] ** 2)
        facts[n, JET_ERROR] = np.sqrt(V[0] ** 2 + V[1] ** 2)
        facts[n, SLOWED] = 1.0 if late else 0.0
        facts[n, AT_LIMIT] = -1.0
        for k in range(joints):
            if q[k] < low[k] + 1e-6 or q[k] > high[k] - 1e-6:
                facts[n, AT_LIMIT] = k


@njit(cache=True)
def _look(
    q: FloatArray,
    arm: ArmArrays,
    pairs: IntArray,
    boxes: BoxArrays,
    minded: float,
    near: float,
    further: float,
    rows: FloatArray,
) -> tuple[float, int]:
    """Writes rows of things, then of near pairs; the things' gap, and how many."""
    origins, turns, capsules = arm
    n = len(capsules)
    gaps(q, arm, boxes, minded, rows[:n])
    own = write_gaps(q, origins, turns, capsules, pairs, near + further, rows[n:])
    for k in range(n, n + own):
        rows[k, 0] -= further
    return rows[:n, 0].min(), n + own


@njit(cache=True)
def _solve_slower(
    J: FloatArray,
    V: FloatArray,
    wanted: FloatArray,
    least: FloatArray,
    most: FloatArray,
    v: FloatArray,
) -> None:
    """Solves for v (7,), slower in the same direction where it would be too fast."""
    for _ in range(_SLOWER):
        if solve(J, V, wanted, least, most, v) != TOO_FAST:
            return
        wanted *= 0.5
        V *= 0.5
    if solve(J, V, wanted, least, most, v) == TOO_FAST:
        v[:] = 0.0


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


@njit(cache=True)
def _limit(V: FloatArray, most: tuple[float, float]) -> None:
    """Slows a twist (5,), in its direction, to a turn and a shift at most."""
    turn = np.sqrt(V[0] ** 2 + V[1] ** 2)
    shift = np.sqrt(V[2] ** 2 + V[3] ** 2 + V[4] ** 2)
    over = max(turn / most[0], shift / most[1])
    if over > 1.0:
        V /= over
