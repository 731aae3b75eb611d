"""The field of a chain that is followed now, as a Drake system."""

from typing import Any

from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteStateIndex,
    DiscreteValues,
    LeafSystem,
    ValueProducer,
)

from bath_drake.composition.chain import Chain
from bath_drake.control.staging import around_areas, left_out, next_stage
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.notation import BoolArray
from bath_drake.systems._ports import drake_vector, eval_value, eval_vector


class StageSequencer(LeafSystem):
    """Steps through a chain's fields at its gates, never back.

    .. pydrake_system::

        name: StageSequencer
        input_ports:
        - navigation_chain
        - canonical_reference
        - sensed_obstacles (optional)
        output_ports:
        - navigation_field
        - remaining_chain
        - stage
        - final_stage

    `canonical_reference` is the point, in N, that the flow is asked at. The state is
    the stage, from 0; `navigation_field` is its field, `remaining_chain` that and all
    to come, `final_stage` 1 where there is none to come and else 0. Goals that
    `sensed_obstacles` cover are moved, or their stages left out; see
    `bath_drake.control.staging`. Unconnected, there are none.
    """

    def __init__(self, *, period: float = 0.01) -> None:
        """Declares ports and state; raises ValueError unless period > 0."""
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._chain = self.DeclareAbstractInputPort("navigation_chain", Value[object]())
        self._p_NQ = self.DeclareVectorInputPort("canonical_reference", 2)
        self._sensed = self.DeclareAbstractInputPort(
            "sensed_obstacles", Value[object]()
        )
        stage = self.DeclareDiscreteState(drake_vector([0.0]))
        self._stage = int(stage)
        inputs = (self._chain, self._sensed)
        # Moving goals takes a while, and areas seldom change.
        self._moved = self.DeclareCacheEntry(
            "chain with covered goals moved, stages left out",
            ValueProducer(allocate=Value[object], calc=self._calc_moved),
            {self.input_port_ticket(port.get_index()) for port in inputs},
        )
        tickets = {
            self._moved.ticket(),
            self.discrete_state_ticket(DiscreteStateIndex(self._stage)),
        }
        for name, calc in (
            ("navigation_field", self._calc_field),
            ("remaining_chain", self._calc_remaining),
        ):
            self.DeclareAbstractOutputPort(name, Value[object], calc, tickets)
        self.DeclareStateOutputPort("stage", stage)
        self.DeclareVectorOutputPort("final_stage", 1, self._calc_final, tickets)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_moved(self, context: Any, output: Any) -> None:
        areas = ObstacleSet()
        if self._sensed.HasValue(context):
            areas = eval_value(self._sensed, context, ObstacleSet)
        chain = around_areas(eval_value(self._chain, context, Chain), areas)
        output.set_value((chain, left_out(chain, areas)))

    def _around(self, context: Any) -> tuple[Chain, BoolArray]:
        moved: Any = self._moved.Eval(context)
        chain, out = moved
        return chain, out

    def _remaining(self, context: Any) -> Chain:
        chain, _ = self._around(context)
        return chain.rest(self._reached(context))

    def _reached(self, context: Any) -> int:
        return int(context.get_discrete_state(self._stage).value()[0])

    def _update(self, context: Context, state: DiscreteValues) -> None:
        chain, out = self._around(context)
        point = eval_vector(self._p_NQ, context)
        stage = next_stage(chain, self._reached(context), point, out)
        state.set_value(self._stage, drake_vector([float(stage)]))

    def _calc_field(self, context: Any, output: Any) -> None:
        output.set_value(self._remaining(context).fields[0])

    def _calc_remaining(self, context: Any, output: Any) -> None:
        output.set_value(self._remaining(context))

    def _calc_final(self, context: Any, output: BasicVector) -> None:
        output.SetAtIndex(0, float(len(self._remaining(context)) == 1))
