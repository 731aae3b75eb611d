"""The reference point in canonical space: integrated, but on a leash."""

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from bath_drake.control.reference import next_reference
from bath_drake.notation import FloatArray
from bath_drake.systems._ports import drake_vector, eval_vector
from bath_drake.systems._standstill import stands_still


class CanonicalReference(LeafSystem):
    """Integrates the canonical velocity into the point the nozzle aims at.

    .. pydrake_system::

        name: CanonicalReference
        input_ports:
        - canonical_position
        - canonical_velocity
        - phase (optional)
        - hold (optional)
        output_ports:
        - canonical_reference

    Points in canonical space N, shape (2,). `canonical_position` is the measured
    one, `canonical_velocity` that of the field at the reference; see
    `bath_drake.control.reference`. The reference stands still while `hold` is above
    one half or `phase` is not WASH; unconnected, neither is so.
    """

    def __init__(
        self,
        *,
        start: FloatArray,
        period: float = 0.01,
        leash: float = 0.08,
        pull: float = 0.5,
    ) -> None:
        """Declares the state with `start`, shape (2,), as its default.

        Raises:
            ValueError: If `start` is not finite or a number is not positive.
        """
        super().__init__()
        start = np.asarray(start, dtype=np.float64)
        if start.shape != (2,) or not np.isfinite(start).all():
            raise ValueError(f"start must be two finite numbers, got {start}")
        for name, value in (("period", period), ("leash", leash), ("pull", pull)):
            if not 0.0 < value < float("inf"):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        self._period = period
        self._leash = leash
        self._pull = pull
        self._p_NQ = self.DeclareVectorInputPort("canonical_position", 2)
        self._v_NQ = self.DeclareVectorInputPort("canonical_velocity", 2)
        self._phase = self.DeclareVectorInputPort("phase", 1)
        self._hold = self.DeclareVectorInputPort("hold", 1)
        state = self.DeclareDiscreteState(drake_vector(start))
        self.DeclareStateOutputPort("canonical_reference", state)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def set_start(self, context: Context, start: FloatArray) -> None:
        """Puts the reference, shape (2,), into this system's own `context`."""
        context.SetDiscreteState(drake_vector(start))

    def _update(self, context: Context, state: DiscreteValues) -> None:
        if stands_still(self._phase, self._hold, context):
            return
        reference = next_reference(
            drake_vector(context.get_discrete_state_vector().CopyToVector()),
            eval_vector(self._p_NQ, context),
            eval_vector(self._v_NQ, context),
            dt=self._period,
            leash=self._leash,
            pull=self._pull,
        )
        state.set_value(drake_vector(reference))
