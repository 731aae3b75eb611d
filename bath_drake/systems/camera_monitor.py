"""Watches whether the camera shows the arm where its joints say it is."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
    State,
)
from pydrake.systems.sensors import ImageDepth32F

from bath_drake.notation import FloatArray
from bath_drake.perception.arm_sight import ArmSight, arm_core, rim_width, seen_through
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.camera import PinholeCamera
from bath_drake.safety.arm_chain import ArmChain
from bath_drake.safety.self_distance import capsule_ends
from bath_drake.systems._depth_sample import STRIDE, DepthSample, sampled
from bath_drake.systems._ports import drake_vector, eval_value, eval_vector, set_vector
from bath_drake.systems.canonical_projector import FRAME_DELAY_S


class CameraMonitor(LeafSystem):
    """Tells a camera that is not where it is believed to be by the arm in its image.

    .. pydrake_system::

        name: CameraMonitor
        input_ports:
        - depth_image
        - arm_position
        - body_observation
        output_ports:
        - camera_status

    `arm_position` (7) is of the frame, rad; of `body_observation` only the robot's
    silhouette and the stamp are asked. `camera_status` (1) is the share of the arm's
    pixels that show what is behind it, `bath_drake.perception.arm_sight.ArmSight`,
    which is the state beside some pixels of the frame and the joints' positions then.
    """

    def __init__(
        self,
        *,
        camera: PinholeCamera,
        X_WC: RigidTransform,
        arm: ArmChain,
        X_WB: RigidTransform,
        period: float,
    ) -> None:
        """Declares ports and state.

        Args:
            camera: Whose images they are.
            X_WC: Its pose, as it is believed to be.
            arm: What it sees.
            X_WB: Pose of the arm's base.
            period: Of the camera, s.

        Raises:
            ValueError: If the period is not positive and finite.
        """
        super().__init__()
        if not 0.0 < period < float("inf"):
            raise ValueError(f"period must be positive and finite, got {period}")
        self._R_WC: FloatArray = np.array(X_WC.rotation().matrix())
        self._p_WC: FloatArray = np.array(X_WC.translation())
        self._rays = np.ascontiguousarray(camera.rays[::STRIDE, ::STRIDE])
        self._focal = max(camera.fx, camera.fy)
        self._arm = arm
        self._R_WB: FloatArray = np.array(X_WB.rotation().matrix())
        self._p_WB: FloatArray = np.array(X_WB.translation())
        self._depth = self.DeclareAbstractInputPort(
            "depth_image", Value(ImageDepth32F(camera.width, camera.height))
        )
        self._q = self.DeclareVectorInputPort("arm_position", 7)
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value(BodyObservation())
        )
        self._sample = self.DeclareAbstractState(Value[object](DepthSample()))
        self._taken_at = self.DeclareDiscreteState(7)
        self._state = self.DeclareAbstractState(Value[object](ArmSight()))
        self.DeclareVectorOutputPort(
            "camera_status", 1, self._calc, {self.abstract_state_ticket(self._state)}
        )
        # With the frame itself: a millisecond later the camera would render anew.
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._take)
        # After the silhouette of the same frame.
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, FRAME_DELAY_S, self._check)

    def _take(self, context: Context, state: State) -> EventStatus:
        sample = sampled(self._depth, context)
        state.get_mutable_abstract_state(int(self._sample)).set_value(sample)
        q = drake_vector(eval_vector(self._q, context))
        state.get_mutable_discrete_state().set_value(int(self._taken_at), q)
        return EventStatus.Succeeded()

    def _check(self, context: Context, state: State) -> EventStatus:
        observation = eval_value(self._observation, context, BodyObservation)
        sight: ArmSight = self._last(context, self._state)
        sample: DepthSample = self._last(context, self._sample)
        q = np.array(context.get_discrete_state(int(self._taken_at)).value())
        stamp = observation.stamp
        if not np.isfinite(stamp) or (sight.frames and stamp <= sight.frames[-1][0]):
            return EventStatus.DidNothing()
        mask = observation.robot_mask
        rim = rim_width(sample.depth, mask[::STRIDE, ::STRIDE], self._focal)
        core = arm_core(mask, rim)[::STRIDE, ::STRIDE]
        share = seen_through(
            sample.depth,
            self._rays,
            core,
            self._R_WC,
            self._p_WC,
            self._capsules_in_world(q),
        )
        after = sight.next(stamp, share)
        state.get_mutable_abstract_state(int(self._state)).set_value(after)
        return EventStatus.Succeeded()

    def _capsules_in_world(self, q: FloatArray) -> FloatArray:
        ends = capsule_ends(q, self._arm) @ self._R_WB.T + self._p_WB
        return np.column_stack([ends.reshape(-1, 6), self._arm.capsules[:, 7]])

    def _last(self, context: Any, index: Any) -> Any:
        return context.get_abstract_state(int(index)).get_value()

    def _calc(self, context: Any, output: BasicVector) -> None:
        set_vector(output, [self._last(context, self._state).share])
