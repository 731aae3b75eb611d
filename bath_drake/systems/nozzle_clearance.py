"""How far the nozzle is off the skin that is seen."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, LeafSystem

from bath_drake.notation import FloatArray
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.height_field import CELL
from bath_drake.perception.recalled_skin import RecalledSkin
from bath_drake.perception.skin_distance import skin_distance
from bath_drake.perception.surface import SurfacePatch, height_over
from bath_drake.systems._ports import eval_value, set_vector


class NozzleClearance(LeafSystem):
    """Tells how far the nozzle's tip is off the skin.

    .. pydrake_system::

        name: NozzleClearance
        input_ports:
        - surface_patch
        - nozzle_pose
        - body_observation (optional)
        - recalled_skin (optional)
        output_ports:
        - nozzle_clearance

    `nozzle_clearance` (1), m, is that of `bath_drake.perception.surface.height_over`:
    along the normal, over the patch under the nozzle. Where the patch is not valid or
    the nozzle has been left beside it, it is the distance from whatever skin the frame
    shows or recalls, `bath_drake.perception.skin_distance`; infinite where there is
    none near. Stateless.
    """

    def __init__(self) -> None:
        """Declares the ports."""
        super().__init__()
        self._patch = self.DeclareAbstractInputPort("surface_patch", Value[object]())
        self._X_WE = self.DeclareAbstractInputPort(
            "nozzle_pose", Value(RigidTransform())
        )
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value(BodyObservation())
        )
        self._recalled = self.DeclareAbstractInputPort(
            "recalled_skin", Value(RecalledSkin())
        )
        inputs = (self._patch, self._X_WE, self._observation, self._recalled)
        self.DeclareVectorOutputPort(
            "nozzle_clearance",
            1,
            self._calc_clearance,
            {port.ticket() for port in inputs},
        )

    def _calc_clearance(self, context: Any, output: BasicVector) -> None:
        patch = eval_value(self._patch, context, SurfacePatch)
        p_WE = np.asarray(eval_value(self._X_WE, context, RigidTransform).translation())
        clearance = height_over(patch, p_WE)
        if clearance == np.inf:
            clearance = self._beside(context, p_WE)
        set_vector(output, [clearance])

    def _beside(self, context: Any, p_WE: FloatArray) -> float:
        """How far the nozzle is from any skin that is known."""
        distance = np.inf
        if self._observation.HasValue(context):
            seen = eval_value(self._observation, context, BodyObservation)
            distance = skin_distance(seen.points_W, seen.point_areas, p_WE)
        if self._recalled.HasValue(context):
            points_W = eval_value(self._recalled, context, RecalledSkin).points_W
            areas = np.full(len(points_W), CELL**2)
            distance = min(distance, skin_distance(points_W, areas, p_WE))
        return distance
