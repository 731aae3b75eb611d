"""Makes the robot hold when it does not know enough, and counts why."""

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.safety.hold import LOST_TIME, MAX_FRAME_AGE, HoldReason, hold_reason
from bath_drake.systems._ports import drake_vector, eval_scalar, eval_value


class HoldSupervisor(LeafSystem):
    """Holds on a missing or stale frame, a lost body, an unsound world and the like.

    .. pydrake_system::

        name: HoldSupervisor
        input_ports:
        - body_observation
        - map_status
        - surface_status
        - ik_status
        - world_status
        output_ports:
        - hold
        - hold_reason
        - hold_counts

    `hold` is 0 or 1, `hold_reason` a `bath_drake.safety.hold.HoldReason`;
    `hold_counts` counts, per reason, how often a hold began, looking at `period`.
    """

    def __init__(
        self,
        *,
        max_frame_age: float = MAX_FRAME_AGE,
        lost_time: float = LOST_TIME,
        period: float = 0.01,
    ) -> None:
        """Declares the ports; raises ValueError unless all three are positive."""
        super().__init__()
        for name, value in (
            ("max_frame_age", max_frame_age),
            ("lost_time", lost_time),
            ("period", period),
        ):
            if not 0.0 < value < float("inf"):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        self._max_frame_age = max_frame_age
        self._lost_time = lost_time
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value[object]()
        )
        self._map = self.DeclareVectorInputPort("map_status", 1)
        self._surface = self.DeclareVectorInputPort("surface_status", 1)
        self._ik = self.DeclareVectorInputPort("ik_status", 1)
        self._world = self.DeclareVectorInputPort("world_status", 1)
        inputs = (self._observation, self._map, self._surface, self._ik, self._world)
        tickets = {self.input_port_ticket(port.get_index()) for port in inputs}
        tickets.add(self.time_ticket())
        self.DeclareVectorOutputPort("hold", 1, self._calc_hold, tickets)
        self.DeclareVectorOutputPort("hold_reason", 1, self._calc_reason, tickets)
        self._last = int(
            self.DeclareDiscreteState(drake_vector([float(HoldReason.NONE)]))
        )
        counts = self.DeclareDiscreteState(drake_vector(np.zeros(len(HoldReason))))
        self._counts = int(counts)
        self.DeclareStateOutputPort("hold_counts", counts)
        # Not at time zero: the first frame is being taken then.
        self.DeclarePeriodicDiscreteUpdateEvent(period, period, self._update)

    def _reason(self, context: Context) -> HoldReason:
        observation = eval_value(self._observation, context, BodyObservation)
        return hold_reason(
            stamp=observation.stamp,
            now=context.get_time(),
            body_found=observation.found,
            body_lost=observation.lost(self._lost_time),
            map_believed=eval_scalar(self._map, context) > 0.5,
            surface_found=eval_scalar(self._surface, context) > 0.5,
            joint_solution=eval_scalar(self._ik, context) < 0.5,
            world_sound=eval_scalar(self._world, context) > 0.5,
            max_frame_age=self._max_frame_age,
        )

    def _calc_hold(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, float(self._reason(context) is not HoldReason.NONE))

    def _calc_reason(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, float(self._reason(context)))

    def _update(self, context: Context, state: DiscreteValues) -> None:
        reason = self._reason(context)
        last = int(context.get_discrete_state(self._last).value()[0])
        if reason is not HoldReason.NONE and reason != last:
            counts = context.get_discrete_state(self._counts).CopyToVector()
            counts[reason] += 1.0
            state.set_value(self._counts, counts)
        state.set_value(self._last, drake_vector([float(reason)]))
