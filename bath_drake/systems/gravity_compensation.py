"""What carries the arm's own weight, in a plant that holds more than the arm."""

from typing import Any

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, LeafSystem

from bath_drake.systems._ports import drake_vector, eval_vector, set_vector


class GravityCompensation(LeafSystem):
    """Tells the joints' torques that gravity asks for.

    .. pydrake_system::

        name: GravityCompensation
        input_ports:
        - arm_state
        output_ports:
        - generalized_force

    `arm_state` (14) is q, v; `generalized_force` (7), N m. As Drake's InverseDynamics
    does, but with a model of its own: that one keeps but a pointer to its. Stateless.
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
                f"plant must have 7 positions, got {plant.num_positions()}"
            )
        self._plant = plant
        # A scratch pad, written before every use: it remembers nothing.
        self._scratch = plant.CreateDefaultContext()
        self._state = self.DeclareVectorInputPort("arm_state", 14)
        self.DeclareVectorOutputPort(
            "generalized_force", 7, self._calc_force, {self._state.ticket()}
        )

    def _calc_force(self, context: Any, output: BasicVector) -> None:
        q = eval_vector(self._state, context)[:7]
        self._plant.SetPositions(self._scratch, drake_vector(q))
        gravity = self._plant.CalcGravityGeneralizedForces(self._scratch)
        set_vector(output, -np.asarray(gravity))
