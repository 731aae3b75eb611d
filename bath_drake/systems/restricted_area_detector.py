"""From the seen body to the areas the jet must keep off."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import Context, EventStatus, LeafSystem, State

from bath_drake.field.obstacles import ObstacleSet
from bath_drake.perception.area_memory import AreaKeeper, AreaMemory, seen_in_full
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.given_areas import check_polygon, given_areas
from bath_drake.perception.restricted import find_restricted_areas
from bath_drake.systems._ports import eval_value
from bath_drake.systems.canonical_projector import FRAME_DELAY_S, unknown_map


class RestrictedAreaDetector(LeafSystem):
    """Finds wounds by their colour, and remembers them and what the carer gave.

    .. pydrake_system::

        name: RestrictedAreaDetector
        input_ports:
        - body_observation
        - canonical_map
        output_ports:
        - sensed_obstacles

    The state is an `AreaMemory` of ellipses in N. N moves with the body, so an area
    the robot hides now is still where it was. It is kept off from the first frame on
    that shows it; after some more it stays for the run and only ever grows. The areas
    that the carer gave are there from the first frame that shows the body.
    """

    def __init__(
        self,
        *,
        margin: float,
        period: float,
        min_area: float = 2e-4,
        given: Sequence[Sequence[Sequence[float]]] = (),
    ) -> None:
        """Declares ports and state.

        Args:
            margin: Kept around each area, metres.
            period: Seconds between looks; the camera's.
            min_area: Smaller areas are not counted, m^2.
            given: Polygons in N that the carer wants kept off, corners (n, 2) each.

        Raises:
            ValueError: If the margin is negative, another number not positive or a
                polygon none.
        """
        super().__init__()
        if not (np.isfinite(margin) and margin >= 0.0):
            raise ValueError(f"margin must be >= 0, got {margin}")
        if not (np.isfinite(period) and period > 0.0):
            raise ValueError(f"period must be positive, got {period}")
        if not min_area > 0.0:
            raise ValueError(f"min_area must be positive, got {min_area}")
        self._given = [check_polygon(corners) for corners in given]
        self._margin = margin
        self._min_area = min_area
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value(BodyObservation())
        )
        self._map = self.DeclareAbstractInputPort("canonical_map", Value(unknown_map()))
        self._keeper = AreaKeeper()
        self._memory = self.DeclareAbstractState(Value(AreaMemory()))
        self._stamp = self.DeclareAbstractState(Value[object](-np.inf))
        self.DeclareAbstractOutputPort(
            "sensed_obstacles",
            lambda: Value(ObstacleSet()),
            self._calc_areas,
            {self.abstract_state_ticket(self._memory)},
        )
        # A frame's own map comes with the projector's delay; look after that.
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            period, 2.0 * FRAME_DELAY_S, self._look
        )

    def _look(self, context: Context, state: State) -> EventStatus:
        observation = eval_value(self._observation, context, BodyObservation)
        stamps: Any = context.get_abstract_state(int(self._stamp))
        if not (observation.found and observation.stamp > stamps.get_value()):
            return EventStatus.DidNothing()
        canonical_map = eval_value(self._map, context, CanonicalMap)
        if np.isfinite(stamps.get_value()):
            memory = self._remembered(context)
        else:
            given = given_areas(self._given, canonical_map, self._margin)
            memory = AreaMemory(confirmed=given)
        seen = find_restricted_areas(
            observation, canonical_map, self._margin, self._min_area
        )
        memory = self._keeper.next(
            memory,
            seen,
            observation.stamp,
            lambda ellipse: seen_in_full(ellipse, observation, canonical_map),
        )
        state.get_mutable_abstract_state(int(self._memory)).set_value(memory)
        state.get_mutable_abstract_state(int(self._stamp)).set_value(observation.stamp)
        return EventStatus.Succeeded()

    def _calc_areas(self, context: Any, output: Any) -> None:
        output.set_value(self._remembered(context).areas)

    def _remembered(self, context: Context) -> AreaMemory:
        held: Any = context.get_abstract_state(int(self._memory))
        memory: AreaMemory = held.get_value()
        return memory
