"""The link to the arm: when it last answered, and whether it does as it is told."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from bath_drake.systems._ports import eval_vector, set_vector


class ArmLink(LeafSystem):
    """Stands for the connection to the robot.

    .. pydrake_system::

        name: ArmLink
        input_ports:
        - arm_state
        - checked_command
        output_ports:
        - robot_stamp
        - loop_seconds
        - following_error

    The simulated arm answers at once and its ticks take no time: `robot_stamp` (1) is
    the state's own time, s, NaN where that is no number, and `loop_seconds` (1) is 0.
    `following_error` (1), rad, is the most that a joint of `arm_state` (14) is off
    `checked_command` (14), both q, v. A real arm's driver stands in this place.
    """

    def __init__(self) -> None:
        """Declares the ports."""
        super().__init__()
        self._state = self.DeclareVectorInputPort("arm_state", 14)
        self.DeclareVectorOutputPort(
            "robot_stamp", 1, self._calc_stamp, {self.time_ticket()}
        )
        self.DeclareVectorOutputPort(
            "loop_seconds", 1, self._calc_seconds, {self.nothing_ticket()}
        )
        self._command = self.DeclareVectorInputPort("checked_command", 14)
        self.DeclareVectorOutputPort(
            "following_error",
            1,
            self._calc_error,
            {self._state.ticket(), self._command.ticket()},
        )

    def _calc_stamp(self, context: Context, output: BasicVector) -> None:
        known = all(value == value for value in eval_vector(self._state, context))
        output.SetAtIndex(0, context.get_time() if known else float("nan"))

    def _calc_seconds(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, 0.0)

    def _calc_error(self, context: Context, output: BasicVector) -> None:
        told, is_at = (eval_vector(p, context) for p in (self._command, self._state))
        set_vector(output, [np.abs(is_at[:7] - told[:7]).max()])
