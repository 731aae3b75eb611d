"""How near the arm's links come to each other where they are told to go."""

from typing import Protocol

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from bath_drake.notation import FloatArray
from bath_drake.systems._ports import drake_vector, eval_vector


class Links(Protocol):
    """The arm's links."""

    def least_distance(self, q: FloatArray) -> float:
        """Returns the least distance of two links at positions q (7,), m."""
        ...


class SelfDistance(LeafSystem):
    """Looks ahead for links that come too near to each other.

    .. pydrake_system::

        name: SelfDistance
        input_ports:
        - joint_command
        output_ports:
        - self_distance

    `joint_command` (14) is q, v. `self_distance` (1), m, is the least of any two links
    that must not touch, at q or at q + v `ahead`, whichever is less; NaN if the command
    is no number. It is state, renewed every `period`.
    """

    def __init__(
        self, *, links: Links, ahead: float = 0.14, period: float = 0.02
    ) -> None:
        """Declares port and state.

        Args:
            links: The arm's.
            ahead: How far it looks, s; the default is what the fastest of the slow
                joints takes to brake, 1.31 rad/s at 10 rad/s^2.
            period: Between looks, s.

        Raises:
            ValueError: If a number is not positive and finite.
        """
        super().__init__()
        for name, value in (("ahead", ahead), ("period", period)):
            if not 0.0 < value < float("inf"):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        self._links, self._ahead = links, ahead
        self._command = self.DeclareVectorInputPort("joint_command", 14)
        # Before the first look nothing is known, and NaN would lock the guard.
        state = self.DeclareDiscreteState(drake_vector([0.0]))
        self.DeclareVectorOutputPort(
            "self_distance", 1, self._calc, {self.discrete_state_ticket(state)}
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._look)

    def _look(self, context: Context, state: DiscreteValues) -> None:
        q, v = np.split(eval_vector(self._command, context), 2)
        least = np.nan
        if np.isfinite(q).all() and np.isfinite(v).all():
            places = (q, q + self._ahead * v)
            least = min(self._links.least_distance(place) for place in places)
        state.set_value(drake_vector([least]))

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(context.get_discrete_state_vector().CopyToVector())
