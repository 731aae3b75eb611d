"""Restricted areas that come from nowhere, and move."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import Context, EventStatus, LeafSystem, State

from bath_drake.faults.effects import areas_at
from bath_drake.faults.script import AreaFault as Fault
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.perception.faults import within
from bath_drake.systems._ports import eval_value, eval_vector


class AreaFault(LeafSystem):
    """Adds made-up restricted areas to those that were sensed.

    .. pydrake_system::

        name: AreaFault
        input_ports:
        - sensed_obstacles
        - canonical_position
        output_ports:
        - sensed_obstacles

    The state holds where the nozzle was, (2,) in N, as each area began, and what areas
    there are since the last step.
    """

    def __init__(self, *, faults: Sequence[Fault], period: float) -> None:
        """Declares ports and state; raises ValueError unless period > 0."""
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._faults = list(faults)
        self._sensed = self.DeclareAbstractInputPort(
            "sensed_obstacles", Value(ObstacleSet())
        )
        self._p_NQ = self.DeclareVectorInputPort("canonical_position", 2)
        self._tools = self.DeclareAbstractState(Value[object]({}))
        self._made = self.DeclareAbstractState(Value(ObstacleSet()))
        self.DeclareAbstractOutputPort(
            "sensed_obstacles",
            lambda: Value(ObstacleSet()),
            self._calc,
            {self._sensed.ticket(), self.abstract_state_ticket(self._made)},
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, state: State) -> EventStatus:
        t = context.get_time()
        held: Any = context.get_abstract_state(int(self._tools))
        begun = {k for k, fault in enumerate(self._faults) if within(fault, t)}
        tools = dict(held.get_value())
        for k in begun - set(tools):
            tools[k] = np.array(eval_vector(self._p_NQ, context))
        made = areas_at(self._faults, t, tools)
        state.get_mutable_abstract_state(int(self._tools)).set_value(tools)
        state.get_mutable_abstract_state(int(self._made)).set_value(made)
        return EventStatus.Succeeded()

    def _calc(self, context: Any, output: Any) -> None:
        made: Any = context.get_abstract_state(int(self._made))
        sensed = eval_value(self._sensed, context, ObstacleSet)
        output.set_value(sensed + made.get_value())
