"""Watches how fast the body moves, and whether somebody else comes near it."""

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
from bath_drake.perception.body_check import (
    BodyCheck,
    check_body,
    filled_voxels,
    measured_points,
)
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.systems._depth_sample import STRIDE, DepthSample, sampled
from bath_drake.systems._ports import eval_value, eval_vector, set_vector
from bath_drake.systems.canonical_projector import FRAME_DELAY_S


class BodyMonitor(LeafSystem):
    """Says of the body what a guard must know.

    .. pydrake_system::

        name: BodyMonitor
        input_ports:
        - depth_image
        - body_observation
        - canonical_map
        - map_status
        output_ports:
        - body_status

    `body_status` (2) is the speed of the back's fastest corner, m/s, and how many
    bodies are in the workspace box: 1, and one more for each that came in since. The
    state is a `bath_drake.perception.body_check.BodyCheck` and some of the pixels of
    the frame it is about.
    """

    def __init__(
        self,
        *,
        camera: PinholeCamera,
        X_WC: RigidTransform,
        low_W: FloatArray,
        high_W: FloatArray,
        period: float,
    ) -> None:
        """Declares ports and state.

        Args:
            camera: Whose images they are.
            X_WC: Its pose.
            low_W: (3,) lower corner of the workspace box, m.
            high_W: (3,) its upper corner.
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
        # m^2 of a pixel that faces the camera at depth 1.
        self._pixel = STRIDE**2 / (camera.fx * camera.fy)
        self._box = np.array(low_W, dtype=np.float64), np.array(high_W, dtype=float)
        self._depth = self.DeclareAbstractInputPort(
            "depth_image", Value(ImageDepth32F(camera.width, camera.height))
        )
        self._observation = self.DeclareAbstractInputPort(
            "body_observation", Value(BodyObservation())
        )
        self._map = self.DeclareAbstractInputPort("canonical_map", Value[object]())
        self._believed = self.DeclareVectorInputPort("map_status", 1)
        self._sample = self.DeclareAbstractState(Value[object](DepthSample()))
        self._state = self.DeclareAbstractState(Value[object](BodyCheck()))
        self.DeclareVectorOutputPort(
            "body_status", 2, self._calc, {self.abstract_state_ticket(self._state)}
        )
        # With the frame itself: a millisecond later the camera would render anew.
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._take)
        # After the map of the same frame.
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            period, 2.0 * FRAME_DELAY_S, self._check
        )

    def _last(self, context: Any) -> BodyCheck:
        state: Any = context.get_abstract_state(int(self._state))
        check: BodyCheck = state.get_value()
        return check

    def _take(self, context: Context, state: State) -> EventStatus:
        sample = sampled(self._depth, context)
        state.get_mutable_abstract_state(int(self._sample)).set_value(sample)
        return EventStatus.Succeeded()

    def _check(self, context: Context, state: State) -> EventStatus:
        observation = eval_value(self._observation, context, BodyObservation)
        last = self._last(context)
        if last.stamps and not observation.stamp > last.stamps[-1]:
            return EventStatus.DidNothing()
        found = None
        if observation.found and eval_vector(self._believed, context)[0] > 0.5:
            found = eval_value(self._map, context, CanonicalMap)
        held: Any = context.get_abstract_state(int(self._sample))
        points, areas = measured_points(
            held.get_value().depth,
            self._rays,
            (self._R_WC, self._p_WC),
            observation.robot_mask[::STRIDE, ::STRIDE],
            self._pixel,
        )
        back = observation.points_W[:: STRIDE**2]
        check = check_body(
            last,
            observation.stamp,
            found,
            observation.area,
            filled_voxels(points, areas, *self._box),
            filled_voxels(back, np.ones(len(back)), *self._box),
        )
        state.get_mutable_abstract_state(int(self._state)).set_value(check)
        return EventStatus.Succeeded()

    def _calc(self, context: Any, output: BasicVector) -> None:
        check = self._last(context)
        set_vector(output, [check.speed, 1.0 + check.others])
