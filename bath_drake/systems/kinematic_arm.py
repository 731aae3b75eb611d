"""An arm that is exactly where it is told to be."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from bath_drake.systems._ports import eval_vector, set_vector


class KinematicArm(LeafSystem):
    """Stands where the arm's plant does: no masses, no motors, no delay.

    .. pydrake_system::

        name: KinematicArm
        input_ports:
        - arm_desired_state
        output_ports:
        - arm_state
        - arm_position

    `arm_desired_state` and `arm_state` (14) are q, v and the same; `arm_position` (7)
    is q alone, for those who draw it. Stateless.

    Attributes:
        model: What the arm's picture is posed by, where it is drawn; Drake's system
            that does so keeps but a pointer to it.
    """

    model: MultibodyPlant | None = None

    def __init__(self) -> None:
        """Declares the ports."""
        super().__init__()
        self._desired = self.DeclareVectorInputPort("arm_desired_state", 14)
        told = {self._desired.ticket()}
        self.DeclareVectorOutputPort("arm_state", 14, self._calc_state, told)
        self.DeclareVectorOutputPort("arm_position", 7, self._calc_position, told)

    def _calc_state(self, context: Context, output: BasicVector) -> None:
        set_vector(output, eval_vector(self._desired, context))

    def _calc_position(self, context: Context, output: BasicVector) -> None:
        set_vector(output, eval_vector(self._desired, context)[:7])
