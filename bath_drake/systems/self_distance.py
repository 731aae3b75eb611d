"""How near links of the arm come to each other where it is about to go."""

from typing import Any

from pydrake.systems.framework import BasicVector, LeafSystem

from bath_drake.safety.self_distance import LOOKAHEAD, TOOLS, self_distance_ahead
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

    def __init__(self, *, lookahead: float = LOOKAHEAD, tool: str = "nozzle") -> None:
        """Declares the ports.

        Args:
            lookahead: For how long the arm goes on at v, s.
            tool: On the arm, one of `bath_drake.safety.self_distance.TOOLS`.

        Raises:
            ValueError: Unless lookahead is finite and >= 0 and there is such a tool.
        """
        super().__init__()
        if tool not in TOOLS:
            raise ValueError(f"tool must be one of {', '.join(TOOLS)}, got {tool!r}")
        if not 0.0 <= lookahead < float("inf"):
            raise ValueError(f"lookahead must be >= 0 and finite, got {lookahead}")
        self._lookahead, self._tool = lookahead, tool
        self._command = self.DeclareVectorInputPort("joint_command", 14)
        self.DeclareVectorOutputPort(
            "self_distance", 1, self._calc_self_distance, {self._command.ticket()}
        )

    def _calc_self_distance(self, context: Any, output: BasicVector) -> None:
        command = eval_vector(self._command, context)
        distance = self_distance_ahead(
            command[:7], command[7:], self._lookahead, self._tool
        )
        set_vector(output, [distance])
