"""How near the arm's links come to person, stool and pedestal, where it is going."""

from typing import Any

from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, LeafSystem

from bath_drake.safety.arm_chain import ArmChain
from bath_drake.safety.obstacle_distance import obstacle_distance_ahead
from bath_drake.safety.obstacles import Boxes
from bath_drake.safety.self_distance import LOOKAHEAD
from bath_drake.systems._ports import eval_value, eval_vector, set_vector


class ObstacleDistance(LeafSystem):
    """Tells the least distance of the arm's links from what they must keep off.

    .. pydrake_system::

        name: ObstacleDistance
        input_ports:
        - joint_command
        - obstacles
        output_ports:
        - obstacle_distance

    `joint_command` (14) is q (rad), v (rad/s): a command or a state; `obstacles` are
    `bath_drake.safety.obstacles.Boxes` in the arm's base frame; `obstacle_distance`
    (1), m, is what the guards take: the least from q on to where the arm comes to at v
    in `lookahead` seconds, which covers braking; NaN where q or v is. Stateless.
    """

    def __init__(self, *, arm: ArmChain, lookahead: float = LOOKAHEAD) -> None:
        """Declares the ports; raises ValueError unless lookahead is finite and >= 0."""
        super().__init__()
        if not 0.0 <= lookahead < float("inf"):
            raise ValueError(f"lookahead must be >= 0 and finite, got {lookahead}")
        self._arm, self._lookahead = arm, lookahead
        self._command = self.DeclareVectorInputPort("joint_command", 14)
        self._obstacles = self.DeclareAbstractInputPort("obstacles", Value(Boxes()))
        self.DeclareVectorOutputPort(
            "obstacle_distance",
            1,
            self._calc_distance,
            {self._command.ticket(), self._obstacles.ticket()},
        )

    def _calc_distance(self, context: Any, output: BasicVector) -> None:
        command = eval_vector(self._command, context)
        distance = obstacle_distance_ahead(
            command[:7],
            command[7:],
            self._arm,
            eval_value(self._obstacles, context, Boxes),
            self._lookahead,
        )
        set_vector(output, [distance])
