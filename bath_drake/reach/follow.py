"""How the arm follows a sequence of nozzle poses, with the memory that it has.

What joint positions a pose is reached with depends on where the arm came from. So a
path is followed from home on, as `bath_drake.systems.differential_ik.DifferentialIk`
follows it: the velocity of the pose, the turn about the jet free, the null space drawn
to the posture with 1/s, joints within their range less a margin, links kept off boxes
as of `bath_drake.control.avoidance`. Not modelled are the bounds on acceleration and
the lag that comes of them.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.control.pose_tracking import TrackingConfig
from bath_drake.notation import BoolArray, FloatArray, IntArray
from bath_drake.reach import _following
from bath_drake.reach.kinematics import ArmModel, pose_and_jacobian
from bath_drake.safety.arm_chain import ArmChain
from bath_drake.safety.obstacle_distance import FAR, arm_arrays, box_arrays
from bath_drake.safety.obstacles import Boxes
from bath_drake.safety.self_distance import self_distance

# Between two poses the arm is moved in steps of at most so much: m, rad and s. The
# last is for the null space, which moves on while the nozzle stands.
_STEP_M, _STEP_RAD, _STEP_S = 0.008, 0.05, 0.12
# What any step takes at least, s.
_SHORTEST_S = 1e-3


@dataclass(frozen=True, eq=False)
class Poses:
    """Nozzle poses to be followed in turn.

    Attributes:
        tips: (n, 3) places of the nozzle's tip in W, m.
        jets: (n, 3) unit vectors along the jet in W.
        seconds: (n,) what the way to each takes from the one before, s.
    """

    tips: FloatArray
    jets: FloatArray
    seconds: FloatArray

    def __len__(self) -> int:
        """How many there are."""
        return len(self.tips)


@dataclass(frozen=True, eq=False)
class Followed:
    """What came of following n poses.

    Attributes:
        arm: Whose.
        q: (n, 7) joint positions, rad.
        condition: (n,) condition numbers, as the guard has them.
        place_error: (n,) from the wanted place, m.
        jet_error: (n,) to the wanted jet, rad.
        at_limit: (n,) the joint that stands at the end of its range, from 0; -1: none.
        obstacle_distance: (n,) of the links from what they keep off, at most `FAR`, m.
        slowed: (n,) whether the nozzle lags, for the arm was slowed to keep them off.
    """

    arm: ArmChain
    q: FloatArray
    condition: FloatArray
    place_error: FloatArray
    jet_error: FloatArray
    at_limit: IntArray
    obstacle_distance: FloatArray
    slowed: BoolArray

    def self_distance(self) -> FloatArray:
        """Returns how near links that must not touch come to each other, (n,), m."""
        return np.array([self_distance(q, self.arm) for q in self.q])


def follow(
    arm: ArmModel, poses: Poses, boxes: Boxes | None = None, q: FloatArray | None = None
) -> Followed:
    """Follows poses, as well as it goes.

    Args:
        arm: The arm.
        poses: In turn.
        boxes: What its links keep off, in B; None for nothing.
        q: (7,) where it begins, rad; None for home.
    """
    q = np.array(arm.home if q is None else q, dtype=np.float64)
    tips, jets = arm.into_base(poses.tips, poses.jets)
    p, R, _ = pose_and_jacobian(q, arm.chain)
    dense, place = _dense(
        np.vstack([p, tips]), np.vstack([R[:, 2], jets]), poses.seconds
    )
    counts = np.diff(place)
    seconds = np.repeat(np.maximum(poses.seconds / counts, _SHORTEST_S), counts)
    n, avoidance, tracking = len(dense[0]), arm.avoidance, TrackingConfig()
    positions, facts = np.empty((n, len(q))), np.empty((n, _following.FACTS))
    _following.follow(
        q,
        *dense,
        seconds,
        arm.posture,
        arm.low,
        arm.high,
        arm.speed,
        (tracking.angular_speed, tracking.speed),
        arm_arrays(arm.chain),
        arm.chain.pairs,
        arm.chain.tip,
        box_arrays(Boxes() if boxes is None else boxes),
        (
            avoidance.stop,
            avoidance.near,
            avoidance.gain,
            avoidance.push,
            avoidance.self_stop,
        ),
        positions,
        facts,
    )
    # What happens between two poses counts for the one it leads to.
    starts, ends = place[:-1], place[1:] - 1

    def most(column: int) -> FloatArray:
        if not len(starts):
            return np.zeros(0)
        return np.asarray(np.maximum.reduceat(facts[:, column], starts))

    facts[:, _following.GAP] *= -1.0
    return Followed(
        arm=arm.chain,
        q=positions[ends],
        condition=most(_following.CONDITION),
        place_error=most(_following.PLACE_ERROR),
        jet_error=most(_following.JET_ERROR),
        at_limit=facts[ends, _following.AT_LIMIT].astype(np.int64),
        obstacle_distance=np.minimum(-most(_following.GAP), FAR),
        slowed=most(_following.SLOWED) > 0.5,
    )


def way_to(arm: ArmModel, q: FloatArray, tip: FloatArray, jet: FloatArray) -> Poses:
    """Returns the way to a far pose, as the pose tracking takes it from q (7,).

    Straight, and the turn on it comes to its end with it.

    Args:
        arm: The arm.
        q: Where it is, rad.
        tip: (3,) where to, in W, m.
        jet: (3,) unit vector in W.
    """
    p, R = arm.nozzle(q)
    tracking = TrackingConfig()
    turn = np.arccos(np.clip(R[:, 2] @ jet, -1.0, 1.0))
    seconds = max(
        float(np.linalg.norm(tip - p)) / tracking.speed,
        float(turn) / tracking.angular_speed,
        _SHORTEST_S,
    )
    count = max(2, int(np.ceil(seconds / 0.1)))
    share = np.linspace(0.0, 1.0, count + 1)[1:, None]
    return Poses(
        p + share * (tip - p),
        _turned(R[:, 2], jet, share),
        np.full(count, seconds / count),
    )


def joined(parts: list[Poses]) -> Poses:
    """Returns poses one after the other."""
    return Poses(
        np.concatenate([part.tips for part in parts]),
        np.concatenate([part.jets for part in parts]),
        np.concatenate([part.seconds for part in parts]),
    )


def _dense(
    tips: FloatArray, jets: FloatArray, seconds: FloatArray
) -> tuple[tuple[FloatArray, FloatArray], IntArray]:
    """Poses between poses (n + 1), and at which of them each of the n begins."""
    shift = np.linalg.norm(np.diff(tips, axis=0), axis=1) / _STEP_M
    cosine = np.clip((jets[1:] * jets[:-1]).sum(axis=1), -1.0, 1.0)
    steps = np.maximum(np.arccos(cosine) / _STEP_RAD, seconds / _STEP_S)
    counts = np.maximum(np.ceil(np.maximum(shift, steps)), 1.0).astype(np.int64)
    place = np.concatenate([[0], np.cumsum(counts)])
    share = (np.arange(place[-1]) - np.repeat(place[:-1], counts) + 1.0) / np.repeat(
        counts, counts
    )
    share = share[:, None]
    before, after = (np.repeat(np.arange(len(counts)) + k, counts) for k in (0, 1))
    return (
        np.ascontiguousarray(tips[before] + share * (tips[after] - tips[before])),
        np.ascontiguousarray(_turned(jets[before], jets[after], share)),
    ), place


def _turned(a: FloatArray, b: FloatArray, share: FloatArray) -> FloatArray:
    """Unit vectors so far on the way from one (..., 3) to another, along the arc."""
    cosine = np.clip((a * b).sum(axis=-1, keepdims=True), -1.0, 1.0)
    angle = np.arccos(cosine)
    # Nearly equal ones: the chord. Opposite ones have no arc; none are asked for.
    small = angle < 1e-6
    sine = np.where(small, 1.0, np.sin(angle))
    first = np.where(small, 1.0 - share, np.sin((1.0 - share) * angle) / sine)
    second = np.where(small, share, np.sin(share * angle) / sine)
    turned = first * a + second * b
    return np.asarray(turned / np.linalg.norm(turned, axis=-1, keepdims=True))
