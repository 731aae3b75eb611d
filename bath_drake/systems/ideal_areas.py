"""The true areas to keep off, as soon as there is a frame."""

from typing import Any

from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from bath_drake.field.obstacles import ObstacleSet
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.systems._ports import eval_value


class IdealAreas(LeafSystem):
    """Stands where `RestrictedAreaDetector` does, and knows wounds and given areas.

    .. pydrake_system::

        name: IdealAreas
        input_ports:
        - body_observation
        output_ports:
        - sensed_obstacles

    N moves with the body, and the areas are on it: they are the same in every frame,
    and none before the first. Stateless.
    """

    def __init__(self, *, areas: ObstacleSet) -> None:
        """Declares the ports.

        Args:
            areas: In N, their margins included.
        """
        super().__init__()
        self._areas = areas
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value(BodyObservation())
        )
        self.DeclareAbstractOutputPort(
            "sensed_obstacles",
            lambda: Value(ObstacleSet()),
            self._calc_areas,
            {self._observation.ticket()},
        )

    def _calc_areas(self, context: Any, output: Any) -> None:
        observation = eval_value(self._observation, context, BodyObservation)
        output.set_value(self._areas if observation.found else ObstacleSet())
