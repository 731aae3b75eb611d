"""From the seen body to the canonical map."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
    State,
)

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.body_rim import SeenRim
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.map_follower import (
    FollowedMap,
    MapFollower,
    tracked_follower,
)
from bath_drake.perception.recalled_skin import RecalledSkin
from bath_drake.systems._ports import eval_value, set_vector

# After the segmenter's frame, so that it is this very frame that is looked at:
# updates of one instant all see the state before it.
FRAME_DELAY_S = 0.001


def unknown_map() -> CanonicalMap:
    """Returns the map before any body was seen: the world's own axes, metres."""
    return CanonicalMap(np.eye(3), np.zeros(3), np.ones(2))


class CanonicalProjector(LeafSystem):
    """Finds the canonical map in each frame and follows it.

    .. pydrake_system::

        name: CanonicalProjector
        input_ports:
        - body_observation
        output_ports:
        - canonical_map
        - map_status
        - rejected_frames
        - recalled_skin
        - body_rim

    The state is what a `MapFollower` knows. While the body is lost the map stays as it
    is. Before the first frame that shows it, it is `unknown_map`, which says nothing:
    whoever moves the robot holds it then. A frame whose map jumps further than a body
    can is not believed: `map_status` is 0 until one is again, and 1 otherwise;
    `rejected_frames` counts them. `recalled_skin` is what the robot hides of the skin,
    `body_rim` is a `bath_drake.perception.body_rim.SeenRim`.
    """

    def __init__(self, *, period: float, follower: MapFollower | None = None) -> None:
        """Declares ports and state.

        Args:
            period: Of the camera, s.
            follower: How the map is found; None for the default.

        Raises:
            ValueError: If the period is not positive and finite.
        """
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._follower = tracked_follower() if follower is None else follower
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value(BodyObservation())
        )
        self._known = self.DeclareAbstractState(Value(FollowedMap()))
        known = {self.abstract_state_ticket(self._known)}
        self.DeclareAbstractOutputPort(
            "canonical_map", lambda: Value(unknown_map()), self._calc_map, known
        )
        self.DeclareVectorOutputPort("map_status", 1, self._calc_status, known)
        self.DeclareVectorOutputPort("rejected_frames", 1, self._calc_count, known)
        self.DeclareAbstractOutputPort(
            "recalled_skin", lambda: Value(RecalledSkin()), self._calc_recalled, known
        )
        self.DeclareAbstractOutputPort(
            "body_rim", lambda: Value(SeenRim()), self._calc_rim, known
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, FRAME_DELAY_S, self._look)

    def _look(self, context: Context, state: State) -> EventStatus:
        observation = eval_value(self._observation, context, BodyObservation)
        known = self._remembered(context)
        followed = self._follower.next(known, observation)
        if followed is known:
            return EventStatus.DidNothing()
        state.get_mutable_abstract_state(int(self._known)).set_value(followed)
        return EventStatus.Succeeded()

    def _calc_map(self, context: Any, output: Any) -> None:
        smooth = self._remembered(context).smooth
        output.set_value(unknown_map() if smooth is None else smooth.canonical_map)

    def _calc_status(self, context: Context, output: BasicVector) -> None:
        believed = self._remembered(context).gate.rival is None
        set_vector(output, [float(believed)])

    def _calc_count(self, context: Context, output: BasicVector) -> None:
        set_vector(output, [float(self._remembered(context).gate.rejected)])

    def _calc_recalled(self, context: Any, output: Any) -> None:
        output.set_value(self._remembered(context).recalled)

    def _calc_rim(self, context: Any, output: Any) -> None:
        output.set_value(SeenRim(self._remembered(context).rim))

    def _remembered(self, context: Context) -> FollowedMap:
        held: Any = context.get_abstract_state(int(self._known))
        known: FollowedMap = held.get_value()
        return known
