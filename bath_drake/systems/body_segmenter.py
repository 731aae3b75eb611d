"""From the camera's images to what is known of the body, once a frame."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, EventStatus, LeafSystem, State
from pydrake.systems.sensors import ImageDepth32F, ImageRgba8U

from bath_drake.notation import FloatArray
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.observation import observe_body
from bath_drake.perception.segmentation import SegmentationConfig
from bath_drake.perception.segmenter import Segmenter
from bath_drake.perception.self_filter import RobotGeometry, robot_silhouette
from bath_drake.systems._ports import eval_scalar, eval_value, eval_vector


class BodySegmenter(LeafSystem):
    """Finds the visible back in each frame of the depth camera.

    .. pydrake_system::

        name: BodySegmenter
        input_ports:
        - colour_image
        - depth_image
        - arm_position (where there is a robot)
        - frame_stamp (optional)
        output_ports:
        - body_observation

    A frame is taken every `period` seconds and only then are the images evaluated,
    that is, rendered. An unconnected `frame_stamp` means that they are of this very
    moment; otherwise it is when they were taken, s, and a frame that is no later than
    the last one is no new frame: nothing changes. The state is the last
    `BodyObservation`; it carries what the next frame needs (the largest area and the
    whole back seen so far, and the completed points of the last frame with a body in
    it). Before the first frame its stamp is -inf and `found` is False.
    """

    def __init__(
        self,
        *,
        camera: PinholeCamera,
        X_WC: RigidTransform,
        robot: RobotGeometry | None,
        config: SegmentationConfig,
        period: float,
        dilation_px: int = 2,
        segmenter: Segmenter | None = None,
    ) -> None:
        """Declares ports and state; raises ValueError unless period > 0.

        Args:
            camera: Whose images they are.
            X_WC: Its pose.
            robot: What may hide the back; None where there is no robot.
            config: What to take for a back.
            period: Between looks, s.
            dilation_px: The robot's silhouette is grown by this many pixels.
            segmenter: What tells skin from the rest; None for its colour.
        """
        super().__init__()
        if not (np.isfinite(period) and period > 0.0):
            raise ValueError(f"period must be positive, got {period}")
        if not dilation_px >= 0:
            raise ValueError(f"dilation_px must be >= 0, got {dilation_px}")
        self._camera = camera
        self._R_WC: FloatArray = np.array(X_WC.rotation().matrix())
        self._p_WC: FloatArray = np.array(X_WC.translation())
        self._robot = robot
        self._config = config
        self._dilation_px = dilation_px
        self._segmenter = segmenter
        size = camera.width, camera.height
        self._colour = self.DeclareAbstractInputPort(
            "colour_image", Value(ImageRgba8U(*size))
        )
        self._depth = self.DeclareAbstractInputPort(
            "depth_image", Value(ImageDepth32F(*size))
        )
        self._q = (
            None if robot is None else self.DeclareVectorInputPort("arm_position", 7)
        )
        self._stamp = self.DeclareVectorInputPort("frame_stamp", 1)
        self._observation = self.DeclareAbstractState(Value(BodyObservation()))
        self.DeclareStateOutputPort("body_observation", self._observation)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._observe)

    def _hulls_in_world(self, context: Context) -> Sequence[FloatArray]:
        if self._robot is None or self._q is None:
            return ()
        return self._robot.hulls_in_world(eval_vector(self._q, context))

    def _observe(self, context: Context, state: State) -> EventStatus:
        last: Any = context.get_abstract_state(int(self._observation))
        stamp = context.get_time()
        if self._stamp.HasValue(context):
            stamp = eval_scalar(self._stamp, context)
        if not stamp > last.get_value().stamp:
            return EventStatus.DidNothing()
        colour: Any = eval_value(self._colour, context, ImageRgba8U)
        depth: Any = eval_value(self._depth, context, ImageDepth32F)
        robot_mask = robot_silhouette(
            self._hulls_in_world(context),
            self._camera,
            self._R_WC,
            self._p_WC,
            self._dilation_px,
        )
        observation = observe_body(
            colour.data,
            depth.data[..., 0],
            robot_mask,
            camera=self._camera,
            R_WC=self._R_WC,
            p_WC=self._p_WC,
            config=self._config,
            stamp=stamp,
            previous=last.get_value(),
            segmenter=self._segmenter,
        )
        state.get_mutable_abstract_state(int(self._observation)).set_value(observation)
        return EventStatus.Succeeded()
