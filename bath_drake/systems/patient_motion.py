"""The seated person's motion as a Drake system."""

from collections.abc import Mapping
from functools import lru_cache, partial
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import (
    FrameId,
    FramePoseVector,
    GeometryConfigurationVector,
    GeometryId,
)
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
    State,
)

from bath_drake.notation import FloatArray
from bath_drake.patient.bending import BendingSkin
from bath_drake.patient.motion import (
    MotionConfig,
    check_motion,
    person_pose,
    trunk_bend,
)
from bath_drake.patient.segment_motion import SegmentedSkin, segment_positions
from bath_drake.systems._ports import set_vector
from bath_drake.systems._poses import at, rotation_from

# The skin is made ready this long before the frame that shows it: updates of one
# instant all see the state before it.
AHEAD_S = 0.001


class PatientMotion(LeafSystem):
    """Moves the person's mesh: breath, slow twist, slow lean, and the spine's bending.

    .. pydrake_system::

        name: PatientMotion
        output_ports:
        - geometry_pose
        - body_pose
        - trunk_bend
        - skin_configuration (only of a person that bends)
        - skin_segments (only of one that can be touched)

    `geometry_pose` (FramePoseVector) goes to the SceneGraph; `body_pose` (7) is
    X_WM as quaternion w x y z and origin, m: the truth, for logs and for perception
    that is ideal by decree; so is `trunk_bend` (4), the trunk's shape: flexion, side
    bend and twist, rad, and the chest's swell, m. All three are functions of time.
    `skin_configuration` (GeometryConfigurationVector, m, W) is the skin at the last
    frame; it is state, for whoever asks the SceneGraph anything would have it computed
    anew at every step otherwise. `skin_segments` (12 n) are positions and velocities of
    `bath_drake.patient.segment_motion`, as of one step of the plant later: what a joint
    is told to come to by the end of it.
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
        skin: Mapping[GeometryId, BendingSkin] | None = None,
        frame_period: float = 1.0 / 30.0,
        segments: SegmentedSkin | None = None,
        segment_step: float = 0.002,
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
            skin: How the vertices of each deformable geometry move; None or none
                of a person that does not bend.
            frame_period: Of the camera that sees the skin, s; more than `AHEAD_S`.
            segments: The skin that can be touched; None where nothing touches it.
            segment_step: Of the plant that they are in, s.
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
        self.DeclareVectorOutputPort(
            "trunk_bend", 4, self._calc_bend, {self.time_ticket()}
        )
        if segments is not None:
            if not 0.0 < segment_step < float("inf"):
                raise ValueError(
                    f"segment_step must be positive and finite, got {segment_step}"
                )
            self._segment_step = segment_step
            # A function of time alone, asked for twice at each.
            self._at = lru_cache(maxsize=4)(partial(self._segments_at, segments))
            self.DeclareVectorOutputPort(
                "skin_segments",
                12 * len(segments.segments),
                self._calc_segments,
                {self.time_ticket()},
            )
        self._skin = dict(skin or {})
        if self._skin:
            if not AHEAD_S < frame_period < float("inf"):
                raise ValueError(
                    f"frame_period must be more than {AHEAD_S}, got {frame_period}"
                )
            state = self.DeclareAbstractState(Value(self._configuration(0.0)))
            self.DeclareStateOutputPort("skin_configuration", state)
            self.DeclarePeriodicUnrestrictedUpdateEvent(
                frame_period, frame_period - AHEAD_S, self._bend
            )

    def _pose(self, t: float) -> RigidTransform:
        R, p = person_pose(t, self._motion, *self._rest, *self._body)
        return at(p, rotation_from(R))

    def _configuration(self, t: float) -> GeometryConfigurationVector:
        configuration = GeometryConfigurationVector()
        X_WM, bend = self._pose(t), trunk_bend(t, self._motion)
        R_WM, p_WM = X_WM.rotation().matrix(), X_WM.translation()
        for geometry, skin in self._skin.items():
            points: Any = (skin.points(bend) @ R_WM.T + p_WM).ravel()
            configuration.set_value(geometry, points)
        return configuration

    def _bend(self, context: Context, state: State) -> EventStatus:
        configuration: Any = state.get_mutable_abstract_state(0)
        configuration.set_value(self._configuration(context.get_time() + AHEAD_S))
        return EventStatus.Succeeded()

    def _calc_geometry_pose(self, context: Any, output: Any) -> None:
        poses = FramePoseVector()
        poses.set_value(self._frame_id, self._pose(context.get_time()))
        output.set_value(poses)

    def _calc_body_pose(self, context: Context, output: BasicVector) -> None:
        X_WM = self._pose(context.get_time())
        quaternion = X_WM.rotation().ToQuaternion().wxyz()
        set_vector(output, np.concatenate([quaternion, X_WM.translation()]))

    def _calc_bend(self, context: Context, output: BasicVector) -> None:
        bend = trunk_bend(context.get_time(), self._motion)
        set_vector(output, [bend.flexion, bend.side_bend, bend.twist, bend.swell])

    def _calc_segments(self, context: Context, output: BasicVector) -> None:
        now, step = context.get_time(), self._segment_step
        # Rounded, so that the end of one step is the beginning of the next: 1 ns.
        before, after = (self._at(round(t, 9)) for t in (now, now + step))
        set_vector(output, np.concatenate([after, (after - before) / step]))

    def _segments_at(self, segments: SegmentedSkin, t: float) -> FloatArray:
        start, person = (
            person_pose(at_time, self._motion, *self._rest, *self._body)
            for at_time in (0.0, t)
        )
        return segment_positions(segments, self._motion, t, start=start, person=person)


def _finite(name: str, values: FloatArray) -> FloatArray:
    vector = np.array(values, dtype=np.float64)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise ValueError(f"{name} must be 3 finite numbers, got {vector.tolist()}")
    return vector
