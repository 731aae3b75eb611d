"""A simulated force sensor at the nozzle, until there is contact to measure."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from bath_drake.systems._ports import drake_vector

_STREAM = 6


class ForceSensor(LeafSystem):
    """Measures nothing but its own noise: no contact is simulated.

    .. pydrake_system::

        name: ForceSensor
        output_ports:
        - wrench

    `wrench` (7) is when it was measured, s, the torque, N m, and the force, N.
    """

    def __init__(
        self,
        *,
        seed: int,
        period: float = 0.005,
        force_noise: float = 0.05,
        torque_noise: float = 0.005,
    ) -> None:
        """Declares port and state.

        Args:
            seed: Of the noise, not negative.
            period: Between measurements, s.
            force_noise: Standard deviation along each axis, N.
            torque_noise: Likewise, N m.

        Raises:
            ValueError: If a number is out of its range.
        """
        super().__init__()
        if seed < 0:
            raise ValueError(f"seed must be >= 0, got {seed}")
        for name, value in (
            ("period", period),
            ("force_noise", force_noise),
            ("torque_noise", torque_noise),
        ):
            if not 0.0 < value < float("inf"):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        self._seed, self._period = seed, period
        self._scale = np.repeat([torque_noise, force_noise], 3)
        state = self.DeclareDiscreteState(drake_vector(self._measured(0.0)))
        self.DeclareVectorOutputPort(
            "wrench", 7, self._calc, {self.discrete_state_ticket(state)}
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._measure)

    def _measured(self, t: float) -> np.ndarray:
        # Of time alone: the same run has the same noise, wherever it begins.
        rng = np.random.default_rng([self._seed, _STREAM, round(t / self._period)])
        return np.concatenate([[t], self._scale * rng.standard_normal(6)])

    def _measure(self, context: Context, state: DiscreteValues) -> None:
        state.set_value(drake_vector(self._measured(context.get_time())))

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(context.get_discrete_state_vector().CopyToVector())
