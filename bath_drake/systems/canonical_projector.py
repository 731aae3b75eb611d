"""From the seen body to the canonical map."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from bath_drake.perception.canonical import (
    MIN_POINTS,
    CanonicalMap,
    fit_canonical_map,
)
from bath_drake.perception.segmentation import UP_W, BodyObservation
from bath_drake.systems._ports import eval_value


def unknown_map() -> CanonicalMap:
    """Returns the map before any body was seen: the world's own axes, metres."""
    return CanonicalMap(np.eye(3), np.zeros(3), np.ones(2))


class CanonicalProjector(LeafSystem):
    """Fits the canonical map to the completed back.

    .. pydrake_system::

        name: CanonicalProjector
        input_ports:
        - body_observation
        output_ports:
        - canonical_map

    Stateless. While the body is lost the observation still carries the completed
    points of the last frame that showed it, so the map is the last good one. Before
    the first such frame it is `unknown_map`, which says nothing: whoever moves the
    robot holds it while the observation's `found` is False.
    """

    def __init__(self) -> None:
        """Declares the ports."""
        super().__init__()
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value(BodyObservation())
        )
        self.DeclareAbstractOutputPort(
            "canonical_map",
            lambda: Value(unknown_map()),
            self._calc_map,
            {self._observation.ticket()},
        )

    def _calc_map(self, context: Any, output: Any) -> None:
        observation = eval_value(self._observation, context, BodyObservation)
        if len(observation.completed_points_W) < MIN_POINTS:
            output.set_value(unknown_map())
            return
        output.set_value(
            fit_canonical_map(
                observation.completed_points_W,
                UP_W,
                observation.p_WC,
                observation.completed_areas,
            )
        )
