"""The guard between the navigation function and what follows it."""

from typing import Any

from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
    State,
)

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.safety.canonical_command import guarded_world
from bath_drake.safety.guard_ticks import CanonicalTick, canonical_tick
from bath_drake.safety.limits import GuardLimits, check_limits
from bath_drake.systems._guard_facts import FactPorts
from bath_drake.systems._guard_outputs import declare_guard_outputs
from bath_drake.systems._ports import eval_scalar, eval_value, eval_vector, set_vector


class CanonicalGuard(LeafSystem):
    """Passes a checked velocity of the canonical point, or none.

    .. pydrake_system::

        name: CanonicalGuard
        input_ports:
        - canonical_velocity
        - canonical_position
        - navigation_field
        - canonical_map
        - body_observation
        - sensed_obstacles (optional)
        - condition_number (optional)
        - frame_status, camera_status, map_status, body_status, surface_status,
          surface_normal, world_status, ik_status, self_distance, obstacle_distance,
          nozzle_clearance, command_stamp, wrench, loop_seconds, robot_stamp,
          following_error, reset, other_reason (optional)
        output_ports:
        - checked_velocity
        - guard_mode
        - guard_reason
        - present_reason
        - guard_counts
        - limited_count

    `canonical_velocity` (2) is in 1/s at `canonical_position` (2), in N.
    `navigation_field` is the field without the `sensed_obstacles`. An optional port
    that is not connected is not watched; see `bath_drake.safety.facts.GuardFacts` for
    what each says. `guard_mode` and `guard_reason` are of
    `bath_drake.safety.reasons`; `present_reason` is NONE as soon as all is well, and
    what another guard may take as its `other_reason`; `guard_counts` counts how often
    each reason began, `limited_count` the ticks at which less passed than asked for.

    Everything is checked in the periodic update, and every output is state: nothing
    leaves that was not checked. Unrestricted updates go before discrete ones of the
    same instant, so that a reference with the same period gets the velocity checked at
    that very instant. Until the first update it holds.
    """

    def __init__(
        self, *, limits: GuardLimits, period: float = 0.01, offset: float = 0.0
    ) -> None:
        """Declares ports and state.

        Args:
            limits: What to keep to.
            period: Between two checks, s.
            offset: Of the first, s.

        Raises:
            ValueError: If a limit is out of its range or the period not positive.
        """
        super().__init__()
        check_limits(limits)
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._limits, self._period = limits, period
        self._v_NQ = self.DeclareVectorInputPort("canonical_velocity", 2)
        self._p_NQ = self.DeclareVectorInputPort("canonical_position", 2)
        self._field = self.DeclareAbstractInputPort("navigation_field", Value[object]())
        self._map = self.DeclareAbstractInputPort("canonical_map", Value[object]())
        self._sensed = self.DeclareAbstractInputPort(
            "sensed_obstacles", Value(ObstacleSet())
        )
        self._condition = self.DeclareVectorInputPort("condition_number", 1)
        self._facts = FactPorts(self)
        index = self.DeclareAbstractState(Value[object](CanonicalTick()))
        self._state, ticket = int(index), self.abstract_state_ticket(index)
        self.DeclareVectorOutputPort(
            "checked_velocity", 2, self._calc_velocity, {ticket}
        )
        declare_guard_outputs(self, self.last_tick, ticket)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, offset, self._update)

    def last_tick(self, context: Any) -> CanonicalTick:
        """Returns what the last update came to, from this system's own `context`."""
        tick: CanonicalTick = context.get_abstract_state(self._state).get_value()
        return tick

    def _update(self, context: Context, state: State) -> EventStatus:
        areas, condition = ObstacleSet(), 1.0
        if self._sensed.HasValue(context):
            areas = eval_value(self._sensed, context, ObstacleSet)
        if self._condition.HasValue(context):
            condition = eval_scalar(self._condition, context)
        field = eval_value(self._field, context, NavigationField)
        tick = canonical_tick(
            self.last_tick(context),
            eval_vector(self._v_NQ, context),
            eval_vector(self._p_NQ, context),
            self._facts.read(context, condition),
            world=guarded_world(field, areas, self._limits.canonical.margin),
            half_extents=eval_value(self._map, context, CanonicalMap).half_extents,
            dt=self._period,
            limits=self._limits,
        )
        state.get_mutable_abstract_state(self._state).set_value(tick)
        return EventStatus.Succeeded()

    def _calc_velocity(self, context: Context, output: BasicVector) -> None:
        set_vector(output, self.last_tick(context).velocity)
