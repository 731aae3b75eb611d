"""The back as it truly is, once a frame: perception without a camera."""

from typing import Any, Protocol

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import Value
from pydrake.math import RotationMatrix
from pydrake.systems.framework import Context, EventStatus, LeafSystem, State

from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import FloatArray
from bath_drake.patient.motion import Bend
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.systems._ports import drake_vector, eval_vector


class Sight(Protocol):
    """Who knows the true back; see `bath_drake.patient.true_back`."""

    rim: Workspace | None
    areas: ObstacleSet

    def observe(
        self, R_WM: FloatArray, p_WM: FloatArray, bend: Bend, stamp: float
    ) -> BodyObservation:
        """Returns what perfect perception says."""
        ...


class IdealSegmenter(LeafSystem):
    """Stands where `BodySegmenter` does, and tells the truth.

    .. pydrake_system::

        name: IdealSegmenter
        input_ports:
        - body_pose
        - trunk_bend
        output_ports:
        - body_observation

    `body_pose` (7) is X_WM, `trunk_bend` (4) the trunk's shape, both as of
    `PatientMotion`. The state is the last `BodyObservation`; it is made anew every
    `period` seconds and carries the true map, `tracked_map`. Before the first its stamp
    is -inf and `found` is False.
    """

    def __init__(self, *, sight: Sight, period: float) -> None:
        """Declares ports and state; raises ValueError unless period > 0.

        Args:
            sight: Knows the true back.
            period: Between looks, s; the camera's.
        """
        super().__init__()
        if not (np.isfinite(period) and period > 0.0):
            raise ValueError(f"period must be positive, got {period}")
        self._sight = sight
        self._pose = self.DeclareVectorInputPort("body_pose", 7)
        self._bend = self.DeclareVectorInputPort("trunk_bend", 4)
        self._observation = self.DeclareAbstractState(Value(BodyObservation()))
        self.DeclareStateOutputPort("body_observation", self._observation)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._observe)

    def _observe(self, context: Context, state: State) -> EventStatus:
        pose = eval_vector(self._pose, context)
        flexion, side_bend, twist, swell = eval_vector(self._bend, context).tolist()
        quaternion = Quaternion(drake_vector(pose[:4] / np.linalg.norm(pose[:4])))
        observation = self._sight.observe(
            np.array(RotationMatrix(quaternion).matrix()),
            np.array(pose[4:]),
            Bend(flexion=flexion, side_bend=side_bend, twist=twist, swell=swell),
            context.get_time(),
        )
        held: Any = state.get_mutable_abstract_state(int(self._observation))
        held.set_value(observation)
        return EventStatus.Succeeded()
