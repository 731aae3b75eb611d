"""How near links of the arm come to each other where it is about to go."""

from typing import Any

from pydrake.systems.framework import BasicVector, LeafSystem

from bath_drake.safety.arm_chain import ArmChain
from bath_drake.safety.self_distance import LOOKAHEAD, self_distance_ahead
from bath_drake.systems._ports import eval_vector, set_vector


class SelfDistance(LeafSystem):
    """Tells the least distance of links that must not touch.

    .. pydrake_system::

        name: SelfDistance
        input_ports:
        - joint_command
        output_ports:
        - self_distance

    `joint_command` (14) is q (rad), v (rad/s): a command or a state. `self_distance`
    (1), m, is what the guards take: the least from q on to where the arm comes to at
    v in `lookahead` seconds, which covers braking; NaN where q or v is. Stateless.
    """

    def __init__(self, *, arm: ArmChain, lookahead: float = LOOKAHEAD) -> None:
        """Declares the ports; raises ValueError unless lookahead is finite and >= 0."""
        super().__init__()
        if not 0.0 <= lookahead < float("inf"):
            raise ValueError(f"lookahead must be >= 0 and finite, got {lookahead}")
        self._arm, self._lookahead = arm, lookahead
        self._command = self.DeclareVectorInputPort("joint_command", 14)
        self.DeclareVectorOutputPort(
            "self_distance", 1, self._calc_self_distance, {self._command.ticket()}
        )

    def _calc_self_distance(self, context: Any, output: BasicVector) -> None:
        command = eval_vector(self._command, context)
        distance = self_distance_ahead(
            command[:7], command[7:], self._arm, self._lookahead
        )
        set_vector(output, [distance])
