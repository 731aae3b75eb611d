"""From frame to frame: whether a map is believed, and the map that is known then."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from bath_drake.field.obstacles import Workspace
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.body_rim import body_rim
from bath_drake.perception.canonical import (
    MIN_POINTS,
    CanonicalMap,
    fit_canonical_map,
)
from bath_drake.perception.jump_gate import GateState, JumpGate, Verdict
from bath_drake.perception.map_filter import MapFilter, SmoothMap
from bath_drake.perception.recalled_skin import RecalledSkin, recall
from bath_drake.perception.segmentation import UP_W
from bath_drake.perception.tracked_map import MapTracker, TrackedBody
from bath_drake.shared import Shared


@dataclass(frozen=True, eq=False)
class FollowedMap(Shared):
    """What is known after some frames.

    Attributes:
        smooth: The map; None before the first.
        body: The skin it is carried along with; None if only the mask is looked at.
        gate: Which maps were believed.
        stamp: Of the last frame that was judged, s: each is judged once.
        recalled: What the robot hides of the skin in the last frame that was believed;
            none where only the mask is looked at.
        rim: Of the back, in N, as it was when first seen: it is the body's own.
    """

    smooth: SmoothMap | None = None
    body: TrackedBody | None = None
    gate: GateState = field(default_factory=GateState)
    stamp: float = -math.inf
    recalled: RecalledSkin = field(default_factory=RecalledSkin)
    rim: Workspace | None = None


@dataclass(frozen=True, kw_only=True)
class MapFollower:
    """How the canonical map is found frame by frame.

    Attributes:
        tracker: Carries the map along with the skin; None for the paper's, the box
            around the mask of each frame.
        smoothing: How frames are smoothed.
        gate: What jumps are refused.
    """

    tracker: MapTracker | None
    smoothing: MapFilter
    gate: JumpGate = field(default_factory=JumpGate)

    def next(self, known: FollowedMap, observation: BodyObservation) -> FollowedMap:
        """Looks at a frame.

        Args:
            known: What was known; `FollowedMap()` at first.
            observation: The frame. One without a body, or not newer than the last one,
                changes nothing.
        """
        enough = len(observation.completed_points_W) >= MIN_POINTS
        new = observation.stamp > known.stamp
        if not (observation.found and enough and new):
            return known
        seen = frame_map(observation)
        body = self._followed(known.body, seen, observation)
        # With the skin lost the mask alone says where a body is, but not that it is
        # the same one.
        lost = self.tracker is not None and known.body is not None and body is None
        newest = body.canonical_map if body is not None else seen
        stamp = observation.stamp
        gate, verdict = self.gate.next(known.gate, newest, stamp, same_body=not lost)
        if verdict is Verdict.REJECTED:
            return replace(known, gate=gate, stamp=stamp)
        if verdict is Verdict.RELOCKED or known.smooth is None:
            if self.tracker is not None:
                body = self.tracker.start(seen, observation.points_W, stamp)
            rim = body_rim(seen.canonical_from_world(observation.completed_points_W))
            smooth = self.smoothing.start(seen)
            return FollowedMap(smooth, body, gate, stamp, rim=rim)
        elapsed = stamp - known.gate.accepted_at
        smooth = self.smoothing.next(known.smooth, newest, elapsed)
        recalled = RecalledSkin()
        if body is not None:
            recalled = recall(body, observation)
        return FollowedMap(smooth, body, gate, stamp, recalled, known.rim)

    def _followed(
        self,
        body: TrackedBody | None,
        seen: CanonicalMap,
        observation: BodyObservation,
    ) -> TrackedBody | None:
        if self.tracker is None or body is None:
            return None
        return self.tracker.next(
            body,
            seen,
            observation.points_W,
            observation.point_areas,
            observation.stamp,
        )


def affine_follower() -> MapFollower:
    """Returns the paper's way: the box around each mask, whose edges flicker."""
    return MapFollower(tracker=None, smoothing=MapFilter())


def tracked_follower() -> MapFollower:
    """Returns the way that carries the box along with the skin.

    Such a map trembles less: it may be smoothed less.
    """
    smoothing = MapFilter(
        shift_noise=0.001,
        turn_noise=0.004,
        acceleration=0.02,
        most_shift=0.003,
        most_turn=0.015,
    )
    return MapFollower(tracker=MapTracker(), smoothing=smoothing)


MAP_FOLLOWERS: dict[str, Callable[[], MapFollower]] = {
    "tracked": tracked_follower,
    "affine": affine_follower,
}


def frame_map(observation: BodyObservation) -> CanonicalMap:
    """Returns the paper's map: the box around one frame's completed back."""
    return fit_canonical_map(
        observation.completed_points_W,
        UP_W,
        observation.p_WC,
        observation.completed_areas,
    )
