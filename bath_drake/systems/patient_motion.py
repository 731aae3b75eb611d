"""The seated person's motion as a Drake system."""

from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import FrameId, FramePoseVector
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from bath_drake.notation import FloatArray
from bath_drake.patient.motion import MotionConfig, check_motion, person_pose
from bath_drake.systems._ports import set_vector
from bath_drake.systems._poses import at, rotation_from


class PatientMotion(LeafSystem):
    """Moves the person's mesh: breath, slow twist, slow lean.

    .. pydrake_system::

        name: PatientMotion
        output_ports:
        - geometry_pose
        - body_pose

    `geometry_pose` (FramePoseVector) goes to the SceneGraph; `body_pose` (7) is
    X_WM as quaternion w x y z and origin, m: the truth, for logs alone. Stateless,
    a function of time.
    """

    def __init__(
        self,
        *,
        frame_id: FrameId,
        motion: MotionConfig,
        person_position: FloatArray,
        person_yaw: float,
        hips: FloatArray,
        breath_direction: FloatArray,
    ) -> None:
        """Declares the ports.

        Args:
            frame_id: The person's frame in the SceneGraph.
            motion: Amplitudes and periods; ValueError if out of range.
            person_position: (3,) origin of M at rest in W, m.
            person_yaw: Rotation of M at rest about W's z axis, rad.
            hips: (3,) middle of the hip line in M, m.
            breath_direction: (3,) along which the breath moves the body, in M;
                normalised; ValueError if it has no direction.
        """
        super().__init__()
        check_motion(motion)
        self._frame_id = frame_id
        self._motion = motion
        self._rest = (_finite("person_position", person_position), float(person_yaw))
        if not np.isfinite(person_yaw):
            raise ValueError(f"person_yaw must be finite, got {person_yaw}")
        breath = _finite("breath_direction", breath_direction)
        length = float(np.linalg.norm(breath))
        if length < 1e-9:
            raise ValueError("breath_direction must not be zero")
        self._body = (_finite("hips", hips), breath / length)
        self.DeclareAbstractOutputPort(
            "geometry_pose",
            lambda: Value(FramePoseVector()),
            self._calc_geometry_pose,
            {self.time_ticket()},
        )
        self.DeclareVectorOutputPort(
            "body_pose", 7, self._calc_body_pose, {self.time_ticket()}
        )

    def _pose(self, context: Context) -> RigidTransform:
        R, p = person_pose(context.get_time(), self._motion, *self._rest, *self._body)
        return at(p, rotation_from(R))

    def _calc_geometry_pose(self, context: Any, output: Any) -> None:
        poses = FramePoseVector()
        poses.set_value(self._frame_id, self._pose(context))
        output.set_value(poses)

    def _calc_body_pose(self, context: Context, output: BasicVector) -> None:
        X_WM = self._pose(context)
        quaternion = X_WM.rotation().ToQuaternion().wxyz()
        set_vector(output, np.concatenate([quaternion, X_WM.translation()]))


def _finite(name: str, values: FloatArray) -> FloatArray:
    vector = np.array(values, dtype=np.float64)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise ValueError(f"{name} must be 3 finite numbers, got {vector.tolist()}")
    return vector
