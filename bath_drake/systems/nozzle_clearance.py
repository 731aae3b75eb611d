"""How far the nozzle is off the skin that is seen."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, LeafSystem

from bath_drake.perception.surface import SurfacePatch, height_over
from bath_drake.systems._ports import eval_value, set_vector


class NozzleClearance(LeafSystem):
    """Tells how far the nozzle's tip is off the skin, along its normal.

    .. pydrake_system::

        name: NozzleClearance
        input_ports:
        - surface_patch
        - nozzle_pose
        output_ports:
        - nozzle_clearance

    `nozzle_clearance` (1), m, is that of `bath_drake.perception.surface.height_over`:
    infinite where the patch is not valid or does not lie under the nozzle. Stateless.
    """

    def __init__(self) -> None:
        """Declares the ports."""
        super().__init__()
        self._patch = self.DeclareAbstractInputPort("surface_patch", Value[object]())
        self._X_WE = self.DeclareAbstractInputPort(
            "nozzle_pose", Value(RigidTransform())
        )
        self.DeclareVectorOutputPort(
            "nozzle_clearance",
            1,
            self._calc_clearance,
            {self._patch.ticket(), self._X_WE.ticket()},
        )

    def _calc_clearance(self, context: Any, output: BasicVector) -> None:
        patch = eval_value(self._patch, context, SurfacePatch)
        p_WE = np.asarray(eval_value(self._X_WE, context, RigidTransform).translation())
        set_vector(output, [height_over(patch, p_WE)])
