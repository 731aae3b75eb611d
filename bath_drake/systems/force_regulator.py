"""Hybrid control: the field moves along the skin, the measured force across it."""

from typing import Any

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from bath_drake.control.approach import Phase
from bath_drake.control.force_regulation import (
    ForceLimits,
    ForceState,
    Touch,
    next_force_state,
    touch_phase,
)
from bath_drake.systems._ports import (
    drake_vector,
    eval_scalar,
    eval_vector,
    set_vector,
)


class ForceRegulator(LeafSystem):
    """Moves the stand-off so that the sponge presses with the force asked for.

    .. pydrake_system::

        name: ForceRegulator
        input_ports:
        - approach_standoff
        - approach_phase
        - wrench
        - hold (optional)
        output_ports:
        - standoff
        - phase
        - asked_force
        - touch

    `approach_standoff` (1), m, and `approach_phase` (1) are the approach sequencer's,
    who stops before contact; `standoff` and `phase` are what all others go by: the
    stand-off as far in as the force asks for, and WASH only once the force has settled.
    `wrench` (7) is that of the force sensor, in E: when, s, torque, N m, force on the
    tool, N. `asked_force` (1) is in N, `touch` (1) a
    `bath_drake.control.force_regulation.Touch`. While `hold` is above one half all is
    as at first, away from the skin.
    """

    def __init__(self, *, limits: ForceLimits, period: float = 0.005) -> None:
        """Declares ports and state; raises ValueError unless period > 0."""
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._limits, self._period = limits, period
        self._standoff = self.DeclareVectorInputPort("approach_standoff", 1)
        self._phase = self.DeclareVectorInputPort("approach_phase", 1)
        self._wrench = self.DeclareVectorInputPort("wrench", 7)
        self._hold = self.DeclareVectorInputPort("hold", 1)
        state = self.DeclareDiscreteState(drake_vector(_row(ForceState())))
        ticket = self.discrete_state_ticket(state)
        for name, calc, tickets in (
            ("standoff", self._calc_standoff, {ticket, self._standoff.ticket()}),
            ("phase", self._calc_phase, {ticket, self._phase.ticket()}),
            ("asked_force", self._calc_asked, {ticket}),
            ("touch", self._calc_touch, {ticket}),
        ):
            self.DeclareVectorOutputPort(name, 1, calc, tickets)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, state: DiscreteValues) -> None:
        held = self._hold.HasValue(context) and eval_scalar(self._hold, context) > 0.5
        # The skin pushes the tool back, against E's z.
        force = -float(eval_vector(self._wrench, context)[6])
        after = next_force_state(
            _state(context),
            force,
            self._phase_now(context),
            held=held,
            dt=self._period,
            limits=self._limits,
        )
        state.set_value(drake_vector(_row(after)))

    def _phase_now(self, context: Context) -> Phase:
        return Phase(int(eval_scalar(self._phase, context)))

    def _calc_standoff(self, context: Context, output: BasicVector) -> None:
        before = eval_scalar(self._standoff, context)
        set_vector(output, [before - _state(context).depth])

    def _calc_phase(self, context: Context, output: BasicVector) -> None:
        phase = touch_phase(_state(context), self._phase_now(context))
        set_vector(output, [float(phase)])

    def _calc_asked(self, context: Context, output: BasicVector) -> None:
        set_vector(output, [_state(context).asked])

    def _calc_touch(self, context: Context, output: BasicVector) -> None:
        set_vector(output, [float(_state(context).touch)])


def _row(state: ForceState) -> np.ndarray:
    return np.array(
        [state.touch, state.depth, state.asked, state.washing, state.lost_for],
        dtype=np.float64,
    )


def _state(context: Any) -> ForceState:
    touch, depth, asked, washing, lost = (
        context.get_discrete_state_vector().value().tolist()
    )
    return ForceState(
        touch=Touch(int(touch)),
        depth=depth,
        asked=asked,
        washing=washing > 0.5,
        lost_for=lost,
    )
