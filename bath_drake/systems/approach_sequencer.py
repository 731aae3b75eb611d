"""Reach, descend, wash: the stand-off distance over time."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from bath_drake.control.approach import (
    Approach,
    ApproachLimits,
    Phase,
    held,
    next_approach,
)
from bath_drake.systems._ports import drake_vector, eval_scalar, eval_value


class ApproachSequencer(LeafSystem):
    """Brings the nozzle in front of the start, then down along the normal.

    .. pydrake_system::

        name: ApproachSequencer
        input_ports:
        - nozzle_pose
        - desired_nozzle_pose
        - hold (optional)
        output_ports:
        - phase
        - standoff

    `phase` is a `bath_drake.control.approach.Phase`; `standoff` is in metres.
    Nothing advances while `hold` is above one half; then it goes on from rest.
    """

    def __init__(self, *, limits: ApproachLimits, period: float = 0.01) -> None:
        """Declares the state; raises ValueError unless period > 0."""
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._limits = limits
        self._period = period
        pose = Value(RigidTransform())
        self._X_WE = self.DeclareAbstractInputPort("nozzle_pose", pose)
        self._X_WE_desired = self.DeclareAbstractInputPort("desired_nozzle_pose", pose)
        self._hold = self.DeclareVectorInputPort("hold", 1)
        start = Approach.far(limits)
        phase = self.DeclareDiscreteState(drake_vector([float(start.phase)]))
        standoff = self.DeclareDiscreteState(drake_vector([start.standoff]))
        way = self.DeclareDiscreteState(drake_vector([start.begun, start.seconds]))
        self.DeclareStateOutputPort("phase", phase)
        self.DeclareStateOutputPort("standoff", standoff)
        self._indices = (int(phase), int(standoff), int(way))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, state: DiscreteValues) -> None:
        now = self._now(context)
        if self._hold.HasValue(context) and eval_scalar(self._hold, context) > 0.5:
            self._set(state, held(now))
            return
        X_WE = eval_value(self._X_WE, context, RigidTransform)
        X_WE_desired = eval_value(self._X_WE_desired, context, RigidTransform)
        offset = np.subtract(X_WE.translation(), X_WE_desired.translation())
        error = float(np.linalg.norm(offset))
        self._set(state, next_approach(now, error, self._period, self._limits))

    def _now(self, context: Context) -> Approach:
        (phase,), (standoff,), (begun, seconds) = (
            context.get_discrete_state(k).value().tolist() for k in self._indices
        )
        return Approach(
            phase=Phase(int(phase)), standoff=standoff, begun=begun, seconds=seconds
        )

    def _set(self, state: DiscreteValues, now: Approach) -> None:
        for k, row in zip(
            self._indices,
            ([float(now.phase)], [now.standoff], [now.begun, now.seconds]),
            strict=True,
        ):
            state.set_value(k, drake_vector(row))
