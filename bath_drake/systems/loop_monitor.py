"""Ends a run: at the goal, on time-out or on a violated bound."""

from dataclasses import replace

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, EventStatus, LeafSystem

from bath_drake.control.approach import Phase
from bath_drake.field.navigation import NavigationField
from bath_drake.safety.outcome import LoopBounds, LoopOutcome, judge_loop
from bath_drake.systems._ports import drake_vector, eval_scalar, eval_value, eval_vector


class LoopMonitor(LeafSystem):
    """Watches the loop and asks the simulator to stop, saying why.

    .. pydrake_system::

        name: LoopMonitor
        input_ports:
        - canonical_position
        - navigation_field
        - final_stage
        - phase
        - nozzle_clearance

    The numeric parameter is when the run began and how long it may take, s: zero and
    what the bounds say, unless it is set.

    The goal is that of `navigation_field` while `final_stage` is above one half; until
    then there are others to come, and passing by is not arriving. The message of
    the termination is the name of a `bath_drake.safety.outcome.LoopOutcome`.
    """

    def __init__(self, *, bounds: LoopBounds, period: float = 0.02) -> None:
        """Declares ports and event; raises ValueError unless period > 0."""
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._bounds = bounds
        self._p_NQ = self.DeclareVectorInputPort("canonical_position", 2)
        self._field = self.DeclareAbstractInputPort("navigation_field", Value[object]())
        self._final = self.DeclareVectorInputPort("final_stage", 1)
        self._phase = self.DeclareVectorInputPort("phase", 1)
        self._clearance = self.DeclareVectorInputPort("nozzle_clearance", 1)
        span = BasicVector(drake_vector([0.0, bounds.duration]))
        self._span = int(self.DeclareNumericParameter(span))
        # Not at time zero: the first frame has not been taken yet then.
        self.DeclarePeriodicPublishEvent(period, period, self._judge)

    def set_span(self, context: Context, begin: float, duration: float) -> None:
        """Puts a run's begin and longest duration, s, into this system's `context`."""
        parameter = context.get_mutable_numeric_parameter(self._span)
        parameter.SetFromVector(drake_vector([begin, duration]))

    def outcome(self, context: Context) -> LoopOutcome:
        """Judges this system's own `context`."""
        field = eval_value(self._field, context, NavigationField)
        away = np.linalg.norm(eval_vector(self._p_NQ, context) - field.goal)
        begin, duration = context.get_numeric_parameter(self._span).value().tolist()
        final = eval_scalar(self._final, context) > 0.5
        return judge_loop(
            time=context.get_time() - begin,
            washing=int(eval_vector(self._phase, context)[0]) == Phase.WASH,
            goal_distance=float(away) if final else np.inf,
            clearance=eval_scalar(self._clearance, context),
            bounds=replace(self._bounds, duration=duration),
        )

    def _judge(self, context: Context) -> EventStatus:
        outcome = self.outcome(context)
        if outcome is LoopOutcome.RUNNING:
            return EventStatus.Succeeded()
        return EventStatus.ReachedTermination(self, outcome.name)
