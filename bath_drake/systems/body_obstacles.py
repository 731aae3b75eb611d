"""What the arm's links must keep off, from what is seen of the person."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from bath_drake.notation import FloatArray
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.safety.obstacles import Boxes, person_boxes
from bath_drake.systems._ports import eval_value
from bath_drake.systems.canonical_projector import unknown_map


class BodyObstacles(LeafSystem):
    """Lays the person's boxes out from the back's, and adds those of fixed things.

    .. pydrake_system::

        name: BodyObstacles
        input_ports:
        - canonical_map
        output_ports:
        - obstacles

    `obstacles` are `bath_drake.safety.obstacles.Boxes` in the arm's base frame B. While
    the map is the unknown one, before any body was seen, they are the fixed things
    alone; afterwards the person is where it was seen last. Stateless.
    """

    def __init__(self, *, X_WB: FloatArray, fixed: Boxes) -> None:
        """Declares the ports.

        Args:
            X_WB: (4, 4) pose of the arm's base.
            fixed: What stands still, in B.

        Raises:
            ValueError: If X_WB is no finite matrix (4, 4).
        """
        super().__init__()
        if np.shape(X_WB) != (4, 4) or not np.isfinite(X_WB).all():
            raise ValueError(f"X_WB must be finite and (4, 4), got {X_WB}")
        self._X_WB, self._fixed = np.array(X_WB), fixed
        self._unknown = unknown_map()
        self._map = self.DeclareAbstractInputPort("canonical_map", Value(unknown_map()))
        self.DeclareAbstractOutputPort(
            "obstacles",
            lambda: Value(Boxes()),
            self._calc_obstacles,
            {self._map.ticket()},
        )

    def _calc_obstacles(self, context: Any, output: Any) -> None:
        seen = eval_value(self._map, context, CanonicalMap)
        if np.array_equal(seen.half_extents, self._unknown.half_extents):
            output.set_value(self._fixed)
            return
        person = person_boxes(seen.R_WP, seen.p_WP, seen.half_extents)
        output.set_value(person.seen_from(self._X_WB) + self._fixed)
