"""A port whose readers get something else for a while."""

from typing import Any

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from bath_drake.faults.effects import faulty_signal
from bath_drake.faults.script import SignalFault as Fault
from bath_drake.notation import FloatArray
from bath_drake.perception.faults import within
from bath_drake.systems._ports import drake_vector, eval_vector, set_vector


class SignalFault(LeafSystem):
    """Passes a signal on, but for a while a wrong one.

    .. pydrake_system::

        name: SignalFault
        input_ports:
        - signal
        output_ports:
        - faulty_signal

    Both (n,). The state is the signal at the last step before the fault begins, which
    is what a frozen one keeps to.
    """

    def __init__(self, *, fault: Fault, size: int, period: float = 0.005) -> None:
        """Declares ports and state.

        Args:
            fault: What is wrong, and when.
            size: Of the signal.
            period: Between the steps that remember it, s.

        Raises:
            ValueError: If the fault has an element that the signal has not.
        """
        super().__init__()
        if any(k >= size for k in fault.elements):
            raise ValueError(
                f"elements: found {fault.elements}, allowed 0 to {size - 1} of "
                f"{fault.port}"
            )
        self._fault = fault
        self._signal = self.DeclareVectorInputPort("signal", size)
        held = self.DeclareDiscreteState(drake_vector(np.full(size, np.nan)))
        self._held = int(held)
        self.DeclareVectorOutputPort(
            "faulty_signal",
            size,
            self._calc,
            {
                self.time_ticket(),
                self._signal.ticket(),
                self.discrete_state_ticket(held),
            },
        )
        # Only what is frozen needs to be remembered, and evaluated for it.
        if fault.kind in ("frozen", "drift"):
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._remember)

    def _remember(self, context: Context, state: DiscreteValues) -> None:
        if not within(self._fault, context.get_time()):
            value = drake_vector(eval_vector(self._signal, context))
            state.set_value(self._held, value)

    def _calc(self, context: Context, output: BasicVector) -> None:
        held: Any = context.get_discrete_state(self._held).CopyToVector()
        value: FloatArray = eval_vector(self._signal, context)
        set_vector(output, faulty_signal(value, held, self._fault, context.get_time()))
