"""The learned field and the sensed areas, reconciled, as a Drake system."""

from typing import Any

from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
    State,
)

from bath_drake.control.world import World, contain, inflated, join_areas
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.systems._ports import eval_value, eval_vector
from bath_drake.systems.canonical_projector import FRAME_DELAY_S


class WorldReconciler(LeafSystem):
    """Makes one sound world of virtual obstacles and restricted areas.

    .. pydrake_system::

        name: WorldReconciler
        input_ports:
        - navigation_field
        - sensed_obstacles
        - canonical_reference
        output_ports:
        - reconciled_field
        - reconciled_obstacles
        - world_status

    `reconciled_field` is the learned field, its obstacles out of the areas' way;
    `reconciled_obstacles` are the areas. `world_status` is 1 where both together are
    proved sound and 0 where not: then the robot must hold. The state is the world in
    force; it is made anew when an area shows that the last one did not allow for
    (`slack` is added to each, so that a flicker is not a new world).
    """

    def __init__(self, *, period: float, slack: float = 0.02) -> None:
        """Declares ports and state.

        Args:
            period: Seconds between looks; the camera's.
            slack: Added to the areas' semi-axes, in N.

        Raises:
            ValueError: Unless the period is positive and the slack not negative.
        """
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        if not 0.0 <= slack < float("inf"):
            raise ValueError(f"slack must be finite and >= 0, got {slack}")
        self._slack = slack
        self._field = self.DeclareAbstractInputPort("navigation_field", Value[object]())
        self._areas = self.DeclareAbstractInputPort(
            "sensed_obstacles", Value(ObstacleSet())
        )
        self._p_NQ = self.DeclareVectorInputPort("canonical_reference", 2)
        self._world = self.DeclareAbstractState(Value[object]())
        state = {self.abstract_state_ticket(self._world)}
        inputs = state | {self._field.ticket()}
        self.DeclareAbstractOutputPort(
            "reconciled_field", Value[object], self._calc_field, inputs
        )
        self.DeclareAbstractOutputPort(
            "reconciled_obstacles",
            lambda: Value(ObstacleSet()),
            self._calc_obstacles,
            state,
        )
        self.DeclareVectorOutputPort("world_status", 1, self._calc_status, state)
        # After the areas of the same frame.
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            period, 3.0 * FRAME_DELAY_S, self._reconcile
        )

    def _in_force(self, context: Any) -> World | None:
        state: Any = context.get_abstract_state(int(self._world))
        world = state.get_value()
        return world if isinstance(world, World) else None

    def _reconcile(self, context: Context, state: State) -> EventStatus:
        areas = eval_value(self._areas, context, ObstacleSet)
        world = self._in_force(context)
        if world is not None and contain(world.sensed, areas):
            return EventStatus.DidNothing()
        world = join_areas(
            eval_value(self._field, context, NavigationField),
            inflated(areas, self._slack),
            eval_vector(self._p_NQ, context),
        )
        state.get_mutable_abstract_state(int(self._world)).set_value(world)
        return EventStatus.Succeeded()

    def _calc_field(self, context: Any, output: Any) -> None:
        world = self._in_force(context)
        learned = eval_value(self._field, context, NavigationField)
        output.set_value(learned if world is None else world.virtual)

    def _calc_obstacles(self, context: Any, output: Any) -> None:
        world = self._in_force(context)
        output.set_value(ObstacleSet() if world is None else world.sensed)

    def _calc_status(self, context: Any, output: BasicVector) -> None:
        world = self._in_force(context)
        output.SetAtIndex(0, float(world is not None and world.certificate.passed))
