"""Refuses canonical maps that jump further than a body can.

Another person walks through the picture, a lamp goes out, half a back is covered: the
map of such a frame is wrong, not late. It is not believed, and counted; only if the
frames after it agree with each other for long enough was it the body that had moved.
"""

import math
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.turns import turn_vector

# The longer nothing was believed, the further the body can have come, s; but more than
# this would let anything in.
LONGEST = 0.2


class Verdict(Enum):
    """What became of a frame's map."""

    ACCEPTED = "accepted"
    REJECTED = "rejected"
    RELOCKED = "relocked"  # accepted anew, as if nothing had been seen before


@dataclass(frozen=True, eq=False)
class GateState:
    """What the gate remembers.

    Attributes:
        accepted: The last map that was believed; None before the first.
        accepted_at: When its frame was taken, s.
        rival: The last map that was not; None where the last one was.
        rival_since: Since when the rivals have agreed with each other, s.
        rival_at: When the last one's frame was taken, s.
        rejected: How many maps were not believed.
    """

    accepted: CanonicalMap | None = None
    accepted_at: float = -math.inf
    rival: CanonicalMap | None = None
    rival_since: float = math.inf
    rival_at: float = -math.inf
    rejected: int = 0


@dataclass(frozen=True, kw_only=True)
class JumpGate:
    """How far the map of a seated body can come from one frame to another.

    Attributes:
        shift: Of the back's centre, m, between any two frames: the mask's own flicker.
        speed: And so much more for each second between them, m/s.
        turn: Of the back's frame, rad.
        angular_speed: rad/s.
        stretch: Of the box's extents, as a share.
        relock_time: So long must maps that are not believed agree before they are, s.

    Raises:
        ValueError: Unless all are positive and finite.
    """

    shift: float = 0.02
    speed: float = 0.5
    turn: float = 0.1
    angular_speed: float = 2.0
    stretch: float = 0.1
    relock_time: float = 1.0

    def __post_init__(self) -> None:
        """Checks all numbers."""
        for name, value in vars(self).items():
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} must be positive and finite, got {value}")

    def agree(self, a: CanonicalMap, b: CanonicalMap, dt: float) -> bool:
        """Whether a body can have come from a to b in `dt` seconds."""
        turn = np.linalg.norm(turn_vector(a.R_WP.T @ b.R_WP))
        stretch = np.abs(np.log(b.half_extents / a.half_extents)).max()
        return bool(
            np.linalg.norm(b.p_WP - a.p_WP) <= self.shift + self.speed * dt
            and turn <= self.turn + self.angular_speed * dt
            and stretch <= math.log1p(self.stretch)
        )

    def next(
        self,
        state: GateState,
        seen: CanonicalMap,
        stamp: float,
        *,
        same_body: bool = True,
    ) -> tuple[GateState, Verdict]:
        """Judges a frame's map.

        Args:
            state: What is remembered.
            seen: The map of a frame, of this alone.
            stamp: When the frame was taken, s; later than any before.
            same_body: False where something else says that it is not the body that
                was seen before: then it is refused however near it is.

        Returns:
            What to remember next, and the verdict.
        """
        last = state.accepted
        known = GateState(accepted=seen, accepted_at=stamp, rejected=state.rejected)
        if last is None:
            return known, Verdict.RELOCKED
        since = min(stamp - state.accepted_at, LONGEST)
        if same_body and self.agree(last, seen, since):
            return known, Verdict.ACCEPTED
        rival = state.rival
        apart = stamp - state.rival_at
        goes_on = (
            rival is not None and apart <= LONGEST and self.agree(rival, seen, apart)
        )
        begun = state.rival_since if goes_on else stamp
        if stamp - begun >= self.relock_time - 1e-9:
            return known, Verdict.RELOCKED
        return (
            replace(
                state,
                rival=seen,
                rival_since=begun,
                rival_at=stamp,
                rejected=state.rejected + 1,
            ),
            Verdict.REJECTED,
        )
