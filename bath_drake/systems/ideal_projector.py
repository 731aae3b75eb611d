"""The true canonical map, as an `IdealSegmenter` tells it."""

from typing import Any

from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from bath_drake.field.obstacles import Workspace
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.body_rim import SeenRim
from bath_drake.perception.recalled_skin import RecalledSkin
from bath_drake.systems._ports import eval_value, set_vector
from bath_drake.systems.canonical_projector import unknown_map


class IdealProjector(LeafSystem):
    """Stands where `CanonicalProjector` does, and believes every frame.

    .. pydrake_system::

        name: IdealProjector
        input_ports:
        - body_observation
        output_ports:
        - canonical_map
        - map_status
        - rejected_frames
        - recalled_skin
        - body_rim

    The map is the observation's `tracked_map`, of the same frame. Nothing is hidden, so
    `recalled_skin` is empty; `map_status` is 1 and `rejected_frames` 0. Before the
    first frame the map is `unknown_map` and `body_rim` knows none. Stateless.
    """

    def __init__(self, *, rim: Workspace | None) -> None:
        """Declares the ports.

        Args:
            rim: Of the true back, in N; None where there is none.
        """
        super().__init__()
        self._rim = rim
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value(BodyObservation())
        )
        seen = {self._observation.ticket()}
        never = {self.nothing_ticket()}
        self.DeclareAbstractOutputPort(
            "canonical_map", lambda: Value(unknown_map()), self._calc_map, seen
        )
        self.DeclareVectorOutputPort("map_status", 1, _calc_believed, never)
        self.DeclareVectorOutputPort("rejected_frames", 1, _calc_none, never)
        self.DeclareAbstractOutputPort(
            "recalled_skin", lambda: Value(RecalledSkin()), _calc_recalled, never
        )
        self.DeclareAbstractOutputPort(
            "body_rim", lambda: Value(SeenRim()), self._calc_rim, seen
        )

    def _calc_map(self, context: Any, output: Any) -> None:
        observation = eval_value(self._observation, context, BodyObservation)
        output.set_value(observation.tracked_map or unknown_map())

    def _calc_rim(self, context: Any, output: Any) -> None:
        observation = eval_value(self._observation, context, BodyObservation)
        output.set_value(SeenRim(self._rim) if observation.found else SeenRim())


def _calc_believed(context: Context, output: BasicVector) -> None:
    set_vector(output, [1.0])


def _calc_none(context: Context, output: BasicVector) -> None:
    set_vector(output, [0.0])


def _calc_recalled(context: Any, output: Any) -> None:
    output.set_value(RecalledSkin())
