"""Where the nozzle is, from the arm's measured joint positions."""

from typing import Any

from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import LeafSystem

from bath_drake.systems._ports import drake_vector, eval_vector

NOZZLE_FRAME = "nozzle_tip"


class NozzleKinematics(LeafSystem):
    """Forward kinematics of the arm on its own model.

    .. pydrake_system::

        name: NozzleKinematics
        input_ports:
        - arm_state
        output_ports:
        - nozzle_pose

    `arm_state` (14) is q, v; `nozzle_pose` is X_WE (RigidTransform), the nozzle's
    tip with z along the jet. Stateless.
    """

    def __init__(self, *, plant: MultibodyPlant) -> None:
        """Declares the ports.

        Args:
            plant: The arm alone, finalised, seven positions (`make_control_plant`).

        Raises:
            ValueError: If the plant has other than seven positions.
        """
        super().__init__()
        if plant.num_positions() != 7:
            raise ValueError(
                f"plant must have 7 positions, the arm alone, got"
                f" {plant.num_positions()}"
            )
        self._plant = plant
        self._frame = plant.GetFrameByName(NOZZLE_FRAME)
        # A scratch pad, written before every use: it remembers nothing.
        self._scratch = plant.CreateDefaultContext()
        self._arm_state = self.DeclareVectorInputPort("arm_state", 14)
        self.DeclareAbstractOutputPort(
            "nozzle_pose",
            lambda: Value(RigidTransform()),
            self._calc_nozzle_pose,
            {self._arm_state.ticket()},
        )

    def _calc_nozzle_pose(self, context: Any, output: Any) -> None:
        q = eval_vector(self._arm_state, context)[:7]
        self._plant.SetPositions(self._scratch, drake_vector(q))
        output.set_value(self._frame.CalcPoseInWorld(self._scratch))
