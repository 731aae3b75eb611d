"""The canonical map that follows the skin itself instead of the mask's box.

The paper lays a box around the mask of every frame (IV-B). Where a back bends, skin
comes and goes at the mask's ends, and the box slides over the body. Here the box is
taken once, as the mean of the first second's, and carried along with the skin: each
frame's surface is registered to the one that is known. The map stays affine: what a
seated back bends is within a hundredth of N of a rigid motion.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.notation import FloatArray
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.height_field import HeightField
from bath_drake.perception.registration import BodyPose, register
from bath_drake.perception.turns import turn_matrix, turn_vector


@dataclass(frozen=True, eq=False)
class TrackedBody:
    """What is known of a body after some frames.

    Attributes:
        canonical_map: That of the newest frame.
        pose: Where the body was in it.
        skin: Heights over the plane of the first frame's map, frame B.
        box: (8,) sum over `frames` of the box in B: turn, rad; middle, m;
            half extents, m.
        frames: How many frames have gone into skin and box.
        first: The stamp of the first, s.
        agreement: How much of the surface lay on the known skin in those frames, as a
            mean share: a noisy camera's points lie less near to it.
    """

    canonical_map: CanonicalMap
    pose: BodyPose
    skin: HeightField
    box: FloatArray
    frames: int
    first: float
    agreement: float = 1.0


@dataclass(frozen=True, kw_only=True)
class MapTracker:
    """How a body is got to know and followed.

    Attributes:
        settle_time: For so long skin and box are gathered, s; then they stand.
        least_agreement: If a smaller share of the surface lies on the known skin than
            this of what lay on it while it was gathered, it is another body, or none.
            The same body reaches 0.99 of all, bending too, with a RealSense D435's
            noise 0.77 to 0.88; another person's back 0.55 to 0.99, for some are much
            alike.

    Raises:
        ValueError: If the time is not positive and finite, or the share not in 0..1.
    """

    settle_time: float = 1.5
    least_agreement: float = 0.8

    def __post_init__(self) -> None:
        """Checks both numbers."""
        if not 0.0 < self.settle_time < float("inf"):
            raise ValueError(
                f"settle_time must be positive and finite, got {self.settle_time}"
            )
        if not 0.0 < self.least_agreement <= 1.0:
            raise ValueError(
                f"least_agreement must be in (0, 1], got {self.least_agreement}"
            )

    def start(
        self, seen: CanonicalMap, points_W: FloatArray, stamp: float
    ) -> TrackedBody:
        """Returns what is known after the first frame.

        Args:
            seen: The box around that frame's mask.
            points_W: (n, 3) its visible points, m.
            stamp: When it was taken, s.
        """
        pose = BodyPose(seen.R_WP, seen.p_WP)
        box = np.concatenate([np.zeros(6), seen.half_extents])
        skin = HeightField().with_points(pose.unbent(points_W))
        return TrackedBody(seen, pose, skin, box, 1, stamp)

    def next(
        self,
        body: TrackedBody,
        seen: CanonicalMap,
        points_W: FloatArray,
        areas: FloatArray,
        stamp: float,
    ) -> TrackedBody | None:
        """Returns what is known after another frame.

        Args:
            body: What was known.
            seen: The box around the frame's mask.
            points_W: (n, 3) its visible points, m.
            areas: (n,) surface each stands for, m^2.
            stamp: When it was taken, s.

        Returns:
            What is known now; None if the frame's surface is not that of the body.
        """
        mean = body.box / body.frames
        turn = turn_matrix(mean[:3])
        # Where B must be for its box to be the one that is seen.
        R_WB = seen.R_WP @ turn.T
        outline = BodyPose(R_WB, seen.p_WP - R_WB @ mean[3:6])
        pose, agreement = register(points_W, areas, body.skin, body.pose, outline)
        if agreement < self.least_agreement * body.agreement:
            return None
        middle = _middle(pose, seen.half_extents[1])
        box, skin, frames = body.box, body.skin, body.frames
        usual = body.agreement
        if stamp - body.first <= self.settle_time:
            seen_turn = turn_vector(pose.R_WB.T @ seen.R_WP)
            place = pose.R_WB.T @ (seen.p_WP - middle)
            box = box + np.concatenate([seen_turn, place, seen.half_extents])
            skin = skin.with_points(pose.unbent(points_W))
            frames += 1
            usual += (agreement - usual) / frames
            mean = box / frames
            turn = turn_matrix(mean[:3])
        followed = CanonicalMap(
            pose.R_WB @ turn, middle + pose.R_WB @ mean[3:6], mean[6:]
        )
        return TrackedBody(followed, pose, skin, box, frames, body.first, usual)


def _middle(pose: BodyPose, half_length: float) -> FloatArray:
    """Returns where the box's middle is (3,) in W, m: that of the bent back.

    The rod touches B at its middle and leaves it by y^2 / 2 of the curvature: on the
    mean over the box's length, by a sixth of its square.
    """
    bow = half_length**2 / 6.0 * np.cross(pose.curvature, [0.0, 1.0, 0.0])
    return np.asarray(pose.p_WB + pose.R_WB @ bow)
