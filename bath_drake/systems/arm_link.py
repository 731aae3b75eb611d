"""The link to the arm: when it last answered, and what a control tick took."""

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from bath_drake.systems._ports import eval_vector


class ArmLink(LeafSystem):
    """Stands for the connection to the robot.

    .. pydrake_system::

        name: ArmLink
        input_ports:
        - arm_state
        output_ports:
        - robot_stamp
        - loop_seconds

    The simulated arm answers at once and its ticks take no time: `robot_stamp` (1) is
    the state's own time, s, NaN where that is no number, and `loop_seconds` (1) is 0.
    A real arm's driver stands in this place.
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

    def _calc_stamp(self, context: Context, output: BasicVector) -> None:
        known = all(value == value for value in eval_vector(self._state, context))
        output.SetAtIndex(0, context.get_time() if known else float("nan"))

    def _calc_seconds(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, 0.0)
