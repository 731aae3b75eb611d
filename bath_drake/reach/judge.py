"""What keeps the arm from a place, by the guard's own limits."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from bath_drake.notation import FloatArray, IntArray
from bath_drake.reach.follow import Followed
from bath_drake.reach.kinematics import ArmModel
from bath_drake.safety.limits import GuardLimits

# A nozzle that is this far off, m and rad, has not followed.
BEHIND_M, _BEHIND_RAD = 0.005, 0.05
_ELBOW = 3


class Cause(IntEnum):
    """Why a place is not reached."""

    NONE = 0
    NO_SKIN = 1
    TOO_FAR = 2
    JOINT_LIMIT = 3
    SINGULAR = 4
    SELF_COLLISION = 5
    LINK_NEAR = 6

    @property
    def words(self) -> str:
        """For people."""
        return _WORDS[self]


_WORDS = {
    Cause.NONE: "reached",
    Cause.NO_SKIN: "no skin there",
    Cause.TOO_FAR: "too far",
    Cause.JOINT_LIMIT: "joint limit",
    Cause.SINGULAR: "singular",
    Cause.SELF_COLLISION: "the arm would touch itself",
    Cause.LINK_NEAR: "a link would come too near to person, stool or pedestal",
}


@dataclass(frozen=True, eq=False)
class Places:
    """How the arm does at n places; of several poses of the person the worst.

    Attributes:
        p_N: (n, 2) canonical points.
        condition: (n,) condition numbers, as the guard has them; NaN without skin.
        margin: (n,) of all joints to the ends of their ranges, rad.
        self_distance: (n,) of links that must not touch, m.
        obstacle_distance: (n,) of links from person, stool and pedestal, as the guard
            has it, m.
        place_error: (n,) of the nozzle, m.
        elbow: (n,) position of joint 4, rad: the nearer to zero, the straighter.
        cause: (n,) of `Cause`.
    """

    p_N: FloatArray
    condition: FloatArray
    margin: FloatArray
    self_distance: FloatArray
    obstacle_distance: FloatArray
    place_error: FloatArray
    elbow: FloatArray
    cause: IntArray

    def __len__(self) -> int:
        """How many places."""
        return len(self.p_N)

    @property
    def reached(self) -> bool:
        """Whether all of them are, those without skin left out."""
        return not np.any(self.cause > Cause.NO_SKIN)

    @property
    def share(self) -> float:
        """Of the places with skin, how many are reached; 1 if there are none."""
        skin = self.cause != Cause.NO_SKIN
        if not skin.any():
            return 1.0
        return float(np.mean(self.cause[skin] == Cause.NONE))


def judge(
    arm: ArmModel, p_N: FloatArray, followed: Followed, limits: GuardLimits, lag: float
) -> Places:
    """Judges poses that were followed.

    Args:
        arm: Whose.
        p_N: (n, 2) the canonical points they are of.
        followed: What came of it.
        limits: The guard's.
        lag: Of the nozzle, m, from which on the loop waits for it: an arm that goes
            round a thing may lag less.
    """
    distance = followed.self_distance()
    slowed = followed.slowed
    behind = (followed.place_error > BEHIND_M) | (followed.jet_error > _BEHIND_RAD)
    behind &= ~slowed
    straight = followed.at_limit == _ELBOW
    straight &= followed.q[:, _ELBOW] > (arm.low + arm.high)[_ELBOW] / 2.0
    near = followed.obstacle_distance
    cause = np.full(len(p_N), Cause.NONE, dtype=np.int64)
    for there, why in (
        (near < limits.joints.obstacle_distance, Cause.LINK_NEAR),
        (distance < limits.joints.self_distance, Cause.SELF_COLLISION),
        (followed.condition >= limits.joints.condition_stop, Cause.SINGULAR),
        (behind, Cause.SINGULAR),
        (behind & (followed.at_limit >= 0), Cause.JOINT_LIMIT),
        (behind & straight, Cause.TOO_FAR),
        # It stands where the inverse kinematics lets no link go on.
        (slowed & (followed.place_error > lag), Cause.LINK_NEAR),
    ):
        cause[there] = why
    return Places(
        p_N=p_N,
        condition=followed.condition,
        margin=arm.margin(followed.q),
        self_distance=distance,
        obstacle_distance=near,
        place_error=followed.place_error,
        elbow=followed.q[:, _ELBOW],
        cause=cause,
    )


def nowhere(p_N: FloatArray) -> Places:
    """Places (n, 2) that nobody has been to: without skin."""
    return Places(
        p_N=p_N.copy(),
        condition=np.full(len(p_N), np.nan),
        margin=np.full(len(p_N), np.nan),
        self_distance=np.full(len(p_N), np.nan),
        obstacle_distance=np.full(len(p_N), np.nan),
        place_error=np.full(len(p_N), np.nan),
        elbow=np.full(len(p_N), np.nan),
        cause=np.full(len(p_N), Cause.NO_SKIN, dtype=np.int64),
    )


def worst(every: list[Places]) -> Places:
    """The worst of the same places under several poses of the person.

    Of the causes that of the pose with the greatest condition number, among those
    under which the place is not reached. A place without skin under any is left out.
    """
    cause = np.stack([places.cause for places in every])
    condition = np.stack([places.condition for places in every])
    # Not reached comes before reached, then the worse conditioned.
    failed = cause > Cause.NO_SKIN
    order = np.where(failed, 1e6, 0.0) + np.minimum(np.nan_to_num(condition), 1e5)
    chosen = np.take_along_axis(cause, order.argmax(axis=0)[None], axis=0)[0]
    skin = (cause != Cause.NO_SKIN).all(axis=0)

    def least(name: str) -> FloatArray:
        values = np.stack([getattr(places, name) for places in every])
        return np.where(skin, values.min(axis=0), np.nan)

    def most(name: str) -> FloatArray:
        values = np.stack([getattr(places, name) for places in every])
        return np.where(skin, values.max(axis=0), np.nan)

    return Places(
        p_N=every[0].p_N,
        condition=most("condition"),
        margin=least("margin"),
        self_distance=least("self_distance"),
        obstacle_distance=least("obstacle_distance"),
        place_error=most("place_error"),
        elbow=most("elbow"),
        cause=np.where(skin, chosen, Cause.NO_SKIN),
    )
