"""From the seen body to the canonical map."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
    State,
)

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import (
    MIN_POINTS,
    CanonicalMap,
    fit_canonical_map,
)
from bath_drake.perception.jump_gate import GateState, JumpGate, Verdict
from bath_drake.perception.map_filter import MapFilter, SmoothMap
from bath_drake.perception.segmentation import UP_W
from bath_drake.systems._ports import eval_value, set_vector

# After the segmenter's frame, so that it is this very frame that is looked at:
# updates of one instant all see the state before it.
FRAME_DELAY_S = 0.001


def unknown_map() -> CanonicalMap:
    """Returns the map before any body was seen: the world's own axes, metres."""
    return CanonicalMap(np.eye(3), np.zeros(3), np.ones(2))


class CanonicalProjector(LeafSystem):
    """Fits the canonical map to the completed back of each frame and smooths it.

    .. pydrake_system::

        name: CanonicalProjector
        input_ports:
        - body_observation
        output_ports:
        - canonical_map
        - map_status
        - rejected_frames

    The state is the smoothed map, the stamp of the last frame it judged and what the
    gate remembers. While the body is lost the map stays as it is. Before the first
    frame that shows it, it is `unknown_map`, which says nothing: whoever moves the
    robot holds it then. A frame whose map jumps further than a body can is not
    believed: `map_status` is 0 until one is again, and 1 otherwise;
    `rejected_frames` counts them.
    """

    def __init__(
        self,
        *,
        period: float,
        smoothing: MapFilter | None = None,
        gate: JumpGate | None = None,
    ) -> None:
        """Declares ports and state.

        Args:
            period: Of the camera, s.
            smoothing: How frames are smoothed; None for the default.
            gate: What jumps are refused; None for the default.

        Raises:
            ValueError: If the period is not positive and finite.
        """
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._filter = MapFilter() if smoothing is None else smoothing
        self._gate = JumpGate() if gate is None else gate
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value(BodyObservation())
        )
        self._map = self.DeclareAbstractState(Value(unknown_map()))
        self._smooth = self.DeclareAbstractState(Value(SmoothMap(unknown_map())))
        self._memory = self.DeclareAbstractState(Value(GateState()))
        self._stamp = self.DeclareAbstractState(Value[object](-np.inf))
        self.DeclareStateOutputPort("canonical_map", self._map)
        memory = {self.abstract_state_ticket(self._memory)}
        self.DeclareVectorOutputPort("map_status", 1, self._calc_status, memory)
        self.DeclareVectorOutputPort("rejected_frames", 1, self._calc_count, memory)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, FRAME_DELAY_S, self._look)

    def _look(self, context: Context, state: State) -> EventStatus:
        observation = eval_value(self._observation, context, BodyObservation)
        new = observation.stamp > self._kept(context, self._stamp)
        enough = len(observation.completed_points_W) >= MIN_POINTS
        if not (observation.found and enough and new):
            return EventStatus.DidNothing()
        # A frame is judged once, whatever becomes of it.
        _keep(state, self._stamp, observation.stamp)
        seen = fit_canonical_map(
            observation.completed_points_W,
            UP_W,
            observation.p_WC,
            observation.completed_areas,
        )
        before: GateState = self._kept(context, self._memory)
        memory, verdict = self._gate.next(before, seen, observation.stamp)
        _keep(state, self._memory, memory)
        if verdict is Verdict.REJECTED:
            return EventStatus.Succeeded()
        if verdict is Verdict.RELOCKED:
            smooth = self._filter.start(seen)
        else:
            elapsed = observation.stamp - before.accepted_at
            smooth = self._filter.next(self._kept(context, self._smooth), seen, elapsed)
        _keep(state, self._smooth, smooth)
        _keep(state, self._map, smooth.canonical_map)
        return EventStatus.Succeeded()

    def _calc_status(self, context: Context, output: BasicVector) -> None:
        memory: GateState = self._kept(context, self._memory)
        set_vector(output, [float(memory.rival is None)])

    def _calc_count(self, context: Context, output: BasicVector) -> None:
        memory: GateState = self._kept(context, self._memory)
        set_vector(output, [float(memory.rejected)])

    @staticmethod
    def _kept(context: Context, index: Any) -> Any:
        held: Any = context.get_abstract_state(int(index))
        return held.get_value()


def _keep(state: State, index: Any, value: object) -> None:
    state.get_mutable_abstract_state(int(index)).set_value(value)
