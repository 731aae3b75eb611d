"""The filmed carer's motion as a Drake system."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import Value
from pydrake.geometry import FrameId, FramePoseVector
from pydrake.math import RotationMatrix
from pydrake.systems.framework import LeafSystem

from bath_drake.carer.arm import PARTS, CarerArm
from bath_drake.systems._ports import eval_vector
from bath_drake.systems._poses import at, rotation_from


class CarerMotion(LeafSystem):
    """Moves the carer's marker, hand and arm over the moving person.

    .. pydrake_system::

        name: CarerMotion
        input_ports:
        - body_pose
        output_ports:
        - geometry_pose

    `body_pose` (7) is the person's true X_WM, quaternion w x y z and origin, m;
    `geometry_pose` (FramePoseVector) goes to the SceneGraph. Stateless.
    """

    def __init__(self, *, frame_ids: Mapping[str, FrameId], arm: CarerArm) -> None:
        """Declares the ports.

        Args:
            frame_ids: The SceneGraph's frame of each of the carer's parts.
            arm: How they move.

        Raises:
            ValueError: If a part has no frame.
        """
        super().__init__()
        missing = [part for part in PARTS if part not in frame_ids]
        if missing:
            raise ValueError(f"frame_ids must name every part, missing: {missing}")
        self._frame_ids = dict(frame_ids)
        self._arm = arm
        self._body_pose = self.DeclareVectorInputPort("body_pose", 7)
        self.DeclareAbstractOutputPort(
            "geometry_pose",
            lambda: Value(FramePoseVector()),
            self._calc_geometry_pose,
            {self.time_ticket(), self._body_pose.ticket()},
        )

    def _calc_geometry_pose(self, context: Any, output: Any) -> None:
        pose = eval_vector(self._body_pose, context)
        quaternion = Quaternion(wxyz=pose[:4] / np.linalg.norm(pose[:4]))
        R_WM = np.array(RotationMatrix(quaternion).matrix())
        parts = self._arm.poses(context.get_time(), (R_WM, pose[4:]))
        poses = FramePoseVector()
        for part, (R, p) in parts.items():
            poses.set_value(self._frame_ids[part], at(p, rotation_from(R)))
        output.set_value(poses)
