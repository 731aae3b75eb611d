"""A simulated force sensor at the nozzle: the contact's wrench, bias and noise."""

from functools import lru_cache

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from bath_drake.notation import FloatArray
from bath_drake.systems._ports import drake_vector, eval_vector

_STREAM = 6
# Measurements whose noise is drawn at once: a generator takes longer than its numbers.
_BLOCK = 256


class ForceSensor(LeafSystem):
    """Measures the wrench on the tool, a constant bias and noise.

    .. pydrake_system::

        name: ForceSensor
        input_ports:
        - contact_wrench (optional)
        output_ports:
        - wrench

    `contact_wrench` (6) is the true one, at E's origin, in E: torque, N m, and force,
    N; unconnected, nothing touches. `wrench` (7) is when it was measured, s, and the
    same as measured. The bias is what is left of one that was taken off before; it is
    drawn once, from the seed.
    """

    def __init__(
        self,
        *,
        seed: int,
        period: float = 0.005,
        force_noise: float = 0.05,
        torque_noise: float = 0.005,
        force_bias: float = 0.0,
    ) -> None:
        """Declares port and state.

        Args:
            seed: Of the noise, not negative.
            period: Between measurements, s.
            force_noise: Standard deviation along each axis, N.
            torque_noise: Likewise, N m.
            force_bias: Standard deviation of the bias along each axis, N.

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
        if not 0.0 <= force_bias < float("inf"):
            raise ValueError(f"force_bias must be finite and >= 0, got {force_bias}")
        self._seed, self._period = seed, period
        drawn = np.random.default_rng([seed, _STREAM]).standard_normal(3)
        self._bias = np.concatenate([np.zeros(3), force_bias * drawn])
        self._contact = self.DeclareVectorInputPort("contact_wrench", 6)
        self._block = lru_cache(maxsize=2)(self._drawn)
        self._scale = np.repeat([torque_noise, force_noise], 3)
        state = self.DeclareDiscreteState(
            drake_vector(self._measured(0.0, np.zeros(6)))
        )
        self.DeclareVectorOutputPort(
            "wrench", 7, self._calc, {self.discrete_state_ticket(state)}
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._measure)

    def _measured(self, t: float, wrench: FloatArray) -> FloatArray:
        block, k = divmod(round(t / self._period), _BLOCK)
        noise = self._scale * self._block(block)[k]
        return np.concatenate([[t], wrench + self._bias + noise])

    def _drawn(self, block: int) -> FloatArray:
        """Numbers (_BLOCK, 6) of a block of measurements, standard normal."""
        # Of time alone: the same run has the same noise, wherever it begins.
        rng = np.random.default_rng([self._seed, _STREAM, block])
        return rng.standard_normal((_BLOCK, 6))

    def _measure(self, context: Context, state: DiscreteValues) -> None:
        wrench = np.zeros(6)
        if self._contact.HasValue(context):
            wrench = eval_vector(self._contact, context)
        state.set_value(drake_vector(self._measured(context.get_time(), wrench)))

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(context.get_discrete_state_vector().CopyToVector())
