"""From the seen body to the canonical map."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import Context, EventStatus, LeafSystem, State

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import (
    MIN_POINTS,
    CanonicalMap,
    fit_canonical_map,
)
from bath_drake.perception.map_filter import MapFilter
from bath_drake.perception.segmentation import UP_W
from bath_drake.systems._ports import eval_value

# After the segmenter's frame, so that it is this very frame that is looked at:
# updates of one instant all see the state before it.
FRAME_DELAY_S = 0.001


def unknown_map() -> CanonicalMap:
    """Returns the map before any body was seen: the world's own axes, metres."""
    return CanonicalMap(np.eye(3), np.zeros(3), np.ones(2))


class CanonicalProjector(LeafSystem):
    """Fits the canonical map to the completed back of each frame and smooths it.

    .. pydrake_system::

        name: CanonicalProjector
        input_ports:
        - body_observation
        output_ports:
        - canonical_map

    The state is the smoothed map and the stamp of the frame it knows. While the
    body is lost the map stays as it is. Before the first frame that shows it, it is
    `unknown_map`, which says nothing: whoever moves the robot holds it then.
    """

    def __init__(self, *, period: float, smoothing: MapFilter | None = None) -> None:
        """Declares ports and state.

        Args:
            period: Of the camera, s.
            smoothing: Time constants; None for the default ones.

        Raises:
            ValueError: If the period is not positive and finite.
        """
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._filter = MapFilter() if smoothing is None else smoothing
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value(BodyObservation())
        )
        self._map = self.DeclareAbstractState(Value(unknown_map()))
        self._stamp = self.DeclareAbstractState(Value[object](-np.inf))
        self.DeclareStateOutputPort("canonical_map", self._map)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, FRAME_DELAY_S, self._look)

    def _look(self, context: Context, state: State) -> EventStatus:
        observation = eval_value(self._observation, context, BodyObservation)
        last: Any = context.get_abstract_state(int(self._stamp))
        elapsed = observation.stamp - float(last.get_value())
        enough = len(observation.completed_points_W) >= MIN_POINTS
        if not (observation.found and enough and elapsed > 0.0):
            return EventStatus.DidNothing()
        seen = fit_canonical_map(
            observation.completed_points_W,
            UP_W,
            observation.p_WC,
            observation.completed_areas,
        )
        if np.isfinite(elapsed):
            smooth: Any = context.get_abstract_state(int(self._map))
            seen = self._filter.next(smooth.get_value(), seen, elapsed)
        state.get_mutable_abstract_state(int(self._map)).set_value(seen)
        state.get_mutable_abstract_state(int(self._stamp)).set_value(observation.stamp)
        return EventStatus.Succeeded()
