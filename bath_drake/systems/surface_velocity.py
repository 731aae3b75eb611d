"""How fast the skin moves under the canonical reference, frame by frame."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import Context, EventStatus, LeafSystem, State

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.recalled_skin import RecalledSkin
from bath_drake.perception.surface import MAX_RADIUS, fit_surface
from bath_drake.perception.surface_velocity import VelocityFilter
from bath_drake.systems._ports import drake_vector, eval_value, eval_vector
from bath_drake.systems.canonical_projector import FRAME_DELAY_S, unknown_map

# After the projector's look at the frame: updates of one instant all see the state
# before it.
_AFTER_THE_MAP_S = 2.0 * FRAME_DELAY_S


class SurfaceVelocity(LeafSystem):
    """Compares the skin at the canonical reference in the last two frames.

    .. pydrake_system::

        name: SurfaceVelocity
        input_ports:
        - canonical_reference
        - canonical_map
        - body_observation
        - recalled_skin (optional)
        output_ports:
        - surface_velocity

    `surface_velocity` (6) is that of `bath_drake.perception.surface_velocity`: rad/s,
    then m/s, in W; zero until two frames have shown the body. The state is the last
    frame's observation, map and recalled skin, and the velocity.
    """

    def __init__(
        self,
        *,
        period: float,
        radius: float = 0.03,
        smoothing: VelocityFilter | None = None,
    ) -> None:
        """Declares ports and state.

        Args:
            period: Of the camera, s.
            radius: Of the fitted neighbourhood, m.
            smoothing: None for the default one.

        Raises:
            ValueError: If the period is not positive and finite, or the radius out of
                its range.
        """
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        if not 0.0 < radius <= MAX_RADIUS:
            raise ValueError(f"radius must be in (0, {MAX_RADIUS}] m, got {radius}")
        self._radius = radius
        self._filter = VelocityFilter() if smoothing is None else smoothing
        self._p_NQ = self.DeclareVectorInputPort("canonical_reference", 2)
        self._map = self.DeclareAbstractInputPort("canonical_map", Value(unknown_map()))
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value(BodyObservation())
        )
        self._recalled = self.DeclareAbstractInputPort(
            "recalled_skin", Value(RecalledSkin())
        )
        self._last = self.DeclareAbstractState(Value(BodyObservation()))
        self._last_map = self.DeclareAbstractState(Value(unknown_map()))
        self._last_recalled = self.DeclareAbstractState(Value(RecalledSkin()))
        self._velocity = self.DeclareDiscreteState(drake_vector(np.zeros(6)))
        self.DeclareStateOutputPort("surface_velocity", self._velocity)
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            period, _AFTER_THE_MAP_S, self._look
        )

    def _look(self, context: Context, state: State) -> EventStatus:
        now = eval_value(self._observation, context, BodyObservation)
        now_map = eval_value(self._map, context, CanonicalMap)
        held: Any = context.get_abstract_state(int(self._last))
        last: BodyObservation = held.get_value()
        if not now.stamp > last.stamp:
            return EventStatus.DidNothing()
        recalled = RecalledSkin()
        if self._recalled.HasValue(context):
            recalled = eval_value(self._recalled, context, RecalledSkin)
        velocity = np.zeros(6)
        if np.isfinite(last.stamp):
            held_map: Any = context.get_abstract_state(int(self._last_map))
            hidden: Any = context.get_abstract_state(int(self._last_recalled))
            p_NQ = eval_vector(self._p_NQ, context)
            # The reference moves on: both frames are fitted where it is now.
            velocity = self._filter.next(
                np.array(context.get_discrete_state(int(self._velocity)).value()),
                fit_surface(
                    last.points_W,
                    held_map.get_value(),
                    p_NQ,
                    self._radius,
                    hidden.get_value().points_W,
                ),
                fit_surface(
                    now.points_W, now_map, p_NQ, self._radius, recalled.points_W
                ),
                now.stamp - last.stamp,
            )
        state.get_mutable_abstract_state(int(self._last)).set_value(now)
        state.get_mutable_abstract_state(int(self._last_map)).set_value(now_map)
        state.get_mutable_abstract_state(int(self._last_recalled)).set_value(recalled)
        state.get_mutable_discrete_state().set_value(
            int(self._velocity), drake_vector(velocity)
        )
        return EventStatus.Succeeded()
