"""The learned fields and the sensed areas, reconciled, as a Drake system."""

from typing import Any

from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
    State,
)

from bath_drake.composition.chain import Chain
from bath_drake.control.outlook import Outlook, look_ahead
from bath_drake.control.world import World
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.perception.body_rim import SeenRim
from bath_drake.systems._ports import eval_value, eval_vector
from bath_drake.systems.canonical_projector import FRAME_DELAY_S


class WorldReconciler(LeafSystem):
    """Makes sound worlds of virtual obstacles and restricted areas.

    .. pydrake_system::

        name: WorldReconciler
        input_ports:
        - navigation_field
        - sensed_obstacles
        - canonical_reference
        - remaining_chain (optional)
        - body_rim (optional)
        output_ports:
        - reconciled_field
        - reconciled_obstacles
        - reconciled_worlds
        - restricted_areas
        - world_status

    `reconciled_field` is the learned field, its obstacles out of the areas' way;
    `reconciled_obstacles` are the areas. `world_status` is 1 where both together are
    proved sound and 0 where not: then the robot must hold. `remaining_chain` is the
    learned field and those to come: the world of the next is made ahead of time.
    With `body_rim` (a `SeenRim`) both are within the body, where that is sound.
    `reconciled_worlds` is a tuple of every `bath_drake.control.world.World` made so,
    `restricted_areas` are the areas in force; neither depends on the inputs.

    The state is a `bath_drake.control.outlook.Outlook`: the areas in force and their
    worlds. They are made anew when an area shows that the last ones did not allow for
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
        self._chain = self.DeclareAbstractInputPort("remaining_chain", Value[object]())
        self._rim = self.DeclareAbstractInputPort("body_rim", Value[object]())
        self._outlook = self.DeclareAbstractState(Value[object]())
        state = {self.abstract_state_ticket(self._outlook)}
        inputs = state | {self._field.ticket()}
        for name, calc, tickets in (
            ("reconciled_field", self._calc_field, inputs),
            ("reconciled_obstacles", self._calc_obstacles, inputs),
            ("reconciled_worlds", self._calc_worlds, state),
            ("restricted_areas", self._calc_areas, state),
        ):
            self.DeclareAbstractOutputPort(name, Value[object], calc, tickets)
        self.DeclareVectorOutputPort("world_status", 1, self._calc_status, inputs)
        # After the areas of the same frame.
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            period, 3.0 * FRAME_DELAY_S, self._reconcile
        )

    def _in_force(self, context: Any) -> Outlook | None:
        state: Any = context.get_abstract_state(int(self._outlook))
        outlook = state.get_value()
        return outlook if isinstance(outlook, Outlook) else None

    def _world(self, context: Any) -> World | None:
        outlook = self._in_force(context)
        if outlook is None:
            return None
        return outlook.world_of(eval_value(self._field, context, NavigationField))

    def _reconcile(self, context: Context, state: State) -> EventStatus:
        if self._chain.HasValue(context):
            chain = eval_value(self._chain, context, Chain)
        else:
            chain = Chain((eval_value(self._field, context, NavigationField),))
        rim = SeenRim()
        if self._rim.HasValue(context):
            rim = eval_value(self._rim, context, SeenRim)
        before = self._in_force(context)
        outlook = look_ahead(
            before,
            eval_value(self._areas, context, ObstacleSet),
            chain,
            eval_vector(self._p_NQ, context),
            slack=self._slack,
            rim=rim.workspace,
        )
        if outlook is before:
            return EventStatus.DidNothing()
        state.get_mutable_abstract_state(int(self._outlook)).set_value(outlook)
        return EventStatus.Succeeded()

    def _calc_field(self, context: Any, output: Any) -> None:
        world = self._world(context)
        learned = eval_value(self._field, context, NavigationField)
        output.set_value(learned if world is None else world.virtual)

    def _calc_obstacles(self, context: Any, output: Any) -> None:
        world, outlook = self._world(context), self._in_force(context)
        areas = ObstacleSet() if outlook is None else outlook.areas
        output.set_value(areas if world is None else world.sensed)

    def _calc_worlds(self, context: Any, output: Any) -> None:
        outlook = self._in_force(context)
        output.set_value(() if outlook is None else outlook.worlds)

    def _calc_areas(self, context: Any, output: Any) -> None:
        outlook = self._in_force(context)
        output.set_value(ObstacleSet() if outlook is None else outlook.areas)

    def _calc_status(self, context: Any, output: BasicVector) -> None:
        world = self._world(context)
        output.SetAtIndex(0, float(world is not None and world.certificate.passed))
