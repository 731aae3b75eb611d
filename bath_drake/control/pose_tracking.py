"""From a desired nozzle pose to a smooth spatial velocity: pure arithmetic.

Spatial velocities are (6,): angular part first (rad/s), then the translation of
E's origin (m/s), both in W, as Drake orders them.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from bath_drake.control.skin_speed import SKIN_SPEED, WashedPoint, within_skin_speed
from bath_drake.control.smooth_twist import next_smooth
from bath_drake.notation import FloatArray

# Of a nozzle that washes nothing.
_ANYWHERE, _AT_REST = np.array([0.0, 0.0, 1.0]), np.zeros(6)


@dataclass(frozen=True, kw_only=True)
class TrackingConfig:
    """Gains and limits of the pose tracking.

    The gain takes the position error away within some 1/gain seconds. The feed-
    forward is the desired pose's own velocity, low-pass filtered, so that a pose
    that moves steadily is followed without a lag, while a jump of the pose moves
    the nozzle only at the gain's pace and within the limits. The velocity that comes of
    both is approached with four times the gain, critically damped.
    """

    gain: float = 20.0  # 1/s
    feed_forward_time: float = 0.08  # s, time constant of its low-pass filter
    speed: float = 0.12  # m/s
    angular_speed: float = 1.0  # rad/s
    acceleration: float = 2.5  # m/s^2
    angular_acceleration: float = 20.0  # rad/s^2
    jerk: float = 100.0  # m/s^3
    angular_jerk: float = 800.0  # rad/s^3
    skin_speed: float = SKIN_SPEED  # m/s, of the washed point along the skin

    def __post_init__(self) -> None:
        """Raises ValueError unless every number is positive and finite."""
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be positive and finite, got {value}")


def jet_difference(
    R_from: FloatArray, p_from: FloatArray, R_to: FloatArray, p_to: FloatArray
) -> FloatArray:
    """Returns (6,) what takes one jet to another: a turn (rad) and a shift (m).

    The least turn from one z axis to the other: about neither of them. A turn about
    the jet itself is nothing to a round one, and would use up what a bound on the
    angular speed leaves to the others.
    """
    return _jet_difference(
        np.ascontiguousarray(R_from),
        np.ascontiguousarray(p_from),
        np.ascontiguousarray(R_to),
        np.ascontiguousarray(p_to),
    )


@njit(cache=True)
def _jet_difference(
    R_from: FloatArray, p_from: FloatArray, R_to: FloatArray, p_to: FloatArray
) -> FloatArray:
    ax, ay, az = R_from[0, 2], R_from[1, 2], R_from[2, 2]
    bx, by, bz = R_to[0, 2], R_to[1, 2], R_to[2, 2]
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    sine, cosine = np.sqrt(x * x + y * y + z * z), ax * bx + ay * by + az * bz
    result = np.empty(6)
    if sine > 1e-12:
        turn = np.arctan2(sine, cosine) / sine
        result[0], result[1], result[2] = x * turn, y * turn, z * turn
    elif cosine > 0.0:
        result[0], result[1], result[2] = x, y, z
    else:  # opposite: any turn by a half about an axis across
        for k in range(3):
            result[k] = np.pi * R_from[k, 0]
    for k in range(3):
        result[3 + k] = p_to[k] - p_from[k]
    return result


def across_jet(twist: FloatArray, R: FloatArray) -> FloatArray:
    """Returns the twist (6,) without its turn about the jet, the z axis of R (3, 3)."""
    return _across_jet(np.ascontiguousarray(twist), np.ascontiguousarray(R))


@njit(cache=True)
def _across_jet(twist: FloatArray, R: FloatArray) -> FloatArray:
    left = twist.copy()
    along = twist[0] * R[0, 2] + twist[1] * R[1, 2] + twist[2] * R[2, 2]
    for k in range(3):
        left[k] -= along * R[k, 2]
    return left


def is_pose(R: FloatArray, p: FloatArray) -> bool:
    """Whether R (3, 3) is a rotation and p (3,) finite."""
    return bool(_is_pose(np.ascontiguousarray(R), np.ascontiguousarray(p)))


@njit(cache=True)
def _is_pose(R: FloatArray, p: FloatArray) -> bool:
    if not (np.isfinite(R).all() and np.isfinite(p).all()):
        return False
    for i in range(3):
        for j in range(3):
            dot = 0.0
            for k in range(3):
                dot += R[i, k] * R[j, k]
            # Well above rounding, far below any real change of shape.
            if not abs(dot - (1.0 if i == j else 0.0)) < 1e-6:
                return False
    across = R[1, 1] * R[2, 2] - R[1, 2] * R[2, 1]
    along = R[1, 0] * R[2, 2] - R[1, 2] * R[2, 0]
    last = R[1, 0] * R[2, 1] - R[1, 1] * R[2, 0]
    return bool(R[0, 0] * across - R[0, 1] * along + R[0, 2] * last > 0.0)


@njit(cache=True)
def _norm(twist: FloatArray, first: int) -> float:
    """Of the three numbers from `first` on."""
    x, y, z = twist[first], twist[first + 1], twist[first + 2]
    return float(np.sqrt(x * x + y * y + z * z))


@njit(cache=True)
def limited(twist: FloatArray, angular: float, linear: float) -> FloatArray:
    """Returns the twist (6,) with both parts' norms bounded, directions kept."""
    result = twist.copy()
    for first, bound in ((0, angular), (3, linear)):
        norm = _norm(result, first)
        if norm > bound:
            for k in range(first, first + 3):
                result[k] *= bound / norm
    return result


@njit(cache=True)
def together(twist: FloatArray, angular: float, linear: float) -> FloatArray:
    """Returns the twist (6,) made slower as a whole until both parts are in bounds.

    So a long way is gone straight, and the turn on it comes to its end with it: a
    nozzle that turned first would take the arm where it need not go.
    """
    return twist / max(1.0, _norm(twist, 0) / angular, _norm(twist, 3) / linear)


def next_feed_forward(
    previous: FloatArray, moved: FloatArray, config: TrackingConfig, dt: float
) -> FloatArray:
    """Returns the filtered velocity (6,) of the desired pose.

    Args:
        previous: (6,) the filter's last output.
        moved: (6,) how far the desired pose moved in the last `dt`.
        config: Filter time and limits.
        dt: s.
    """
    time, bounds = config.feed_forward_time, (config.angular_speed, config.speed)
    return _feed_forward(previous, moved, time, bounds, dt)


@njit(cache=True)
def _feed_forward(
    previous: FloatArray,
    moved: FloatArray,
    time: float,
    bounds: tuple[float, float],
    dt: float,
) -> FloatArray:
    # A jump is no velocity: what enters the filter is bounded.
    raw = limited(moved / dt, bounds[0], bounds[1])
    share = dt / (time + dt)
    return previous + share * (raw - previous)


def next_twist(
    previous: FloatArray,
    acceleration: FloatArray,
    error: FloatArray,
    feed_forward: FloatArray,
    config: TrackingConfig,
    dt: float,
    washed: WashedPoint | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Returns the spatial velocity (6,) to command next, and its acceleration (6,).

    Args:
        previous: (6,) the one commanded last.
        acceleration: (6,) its own, rad/s^2 and m/s^2.
        error: (6,) from the commanded to the desired pose.
        feed_forward: (6,) of `next_feed_forward`.
        config: Gains and limits.
        dt: s.
        washed: What is to go along the skin no faster than `config.skin_speed`.
    """
    p_ES, skin, bound = _ANYWHERE, _AT_REST, np.inf
    if washed is not None:
        p_ES, skin, bound = washed.p_ES_W, washed.skin, config.skin_speed
    rows = _next_twist(
        np.ascontiguousarray(previous),
        np.ascontiguousarray(acceleration),
        np.ascontiguousarray(error),
        np.ascontiguousarray(feed_forward),
        np.ascontiguousarray(p_ES),
        np.ascontiguousarray(skin),
        bound,
        config.gain,
        (config.angular_speed, config.angular_acceleration, config.angular_jerk),
        (config.speed, config.acceleration, config.jerk),
        dt,
    )
    return rows[0], rows[1]


@njit(cache=True)
def _next_twist(
    previous: FloatArray,
    acceleration: FloatArray,
    error: FloatArray,
    feed_forward: FloatArray,
    p_ES: FloatArray,
    skin: FloatArray,
    skin_speed: float,
    gain: float,
    angular: tuple[float, float, float],
    linear: tuple[float, float, float],
    dt: float,
) -> FloatArray:
    """As `next_twist`: both in the rows of one array (2, 6)."""
    towards = together(gain * error, angular[0], linear[0])
    wanted = limited(feed_forward + towards, angular[0], linear[0])
    if skin_speed < np.inf:
        wanted = within_skin_speed(wanted, p_ES, skin, skin_speed)
    rows = np.empty((2, 6))
    for first, bounds in ((0, angular), (3, linear)):
        part = slice(first, first + 3)
        row = next_smooth(
            previous[part],
            acceleration[part],
            wanted[part],
            bounds[0],
            bounds[1],
            bounds[2],
            4.0 * gain,
            dt,
        )
        for k in range(3):
            rows[0, first + k], rows[1, first + k] = row[k], row[3 + k]
    return rows


def gentler(asked: FloatArray, done: FloatArray) -> FloatArray:
    """Returns of two accelerations (6,) the smaller one, each part for itself.

    A motion that the joints' limits slowed down goes on from what it really does, and
    one that they braked hard is not braked further for its own smoothness' sake.
    """
    return _gentler(np.ascontiguousarray(asked), np.ascontiguousarray(done))


@njit(cache=True)
def _gentler(asked: FloatArray, done: FloatArray) -> FloatArray:
    chosen = asked.copy()
    for first in (0, 3):
        if _norm(done, first) < _norm(asked, first):
            for k in range(first, first + 3):
                chosen[k] = done[k]
    return chosen
