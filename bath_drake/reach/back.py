"""A person's true back in the extreme poses of its motion: what is to be reached."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bath_drake.control.pose_tracking import TrackingConfig
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.notation import BoolArray, FloatArray
from bath_drake.patient.motion import MotionConfig, person_pose, trunk_bend
from bath_drake.patient.people import Person
from bath_drake.patient.true_back import TrueBack
from bath_drake.perception.canonical import CanonicalMap
from bath_drake.perception.surface import fit_path
from bath_drake.reach.follow import Poses
from bath_drake.reach.kinematics import ArmModel
from bath_drake.safety.obstacles import Boxes, person_boxes
from bath_drake.scene.config import SceneConfig
from bath_drake.scene.obstacles import pedestal_obstacle, stool_obstacle
from bath_drake.scene.studio import true_wound

# Of the patch that the nozzle is squared to, m; the loop's own.
_PATCH_RADIUS = 0.03
_HALF_TURN = np.pi / 2.0


@dataclass(frozen=True, eq=False)
class PosedBack:
    """The back at one pose of the person.

    Attributes:
        points_W: (n, 3) places all over the skin, m.
        canonical_map: Where the back is.
        boxes_W: The person's, laid out from the back as the loop does, and the stool's.
    """

    points_W: FloatArray
    canonical_map: CanonicalMap
    boxes_W: Boxes

    def boxes(self, arm: ArmModel) -> Boxes:
        """Returns what the links of an arm keep off, its pedestal too, in its B."""
        return self.boxes_W.seen_from(arm.X_WB) + pedestal_obstacle(arm.X_WB[2, 3])

    def skin(self, p_N: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Finds the skin at canonical points (n, 2), as the loop's fit does.

        Returns:
            Points (n, 3) and outward normals (n, 3) in W, m, and whether there is skin
            enough to tell, (n,).
        """
        patches = fit_path(self.points_W, self.canonical_map, p_N, _PATCH_RADIUS)
        return (
            np.array([patch.p_WS for patch in patches]),
            np.array([patch.normal_W for patch in patches]),
            np.array([patch.valid for patch in patches]),
        )


@dataclass(frozen=True, eq=False)
class Back:
    """A person's back at rest and in the corners of its motion.

    Attributes:
        poses: The first is that of rest.
        areas: What is to be kept off, in N.
    """

    poses: tuple[PosedBack, ...]
    areas: ObstacleSet

    @cached_property
    def half_extents(self) -> FloatArray:
        """Half the back's box, (2,), m."""
        return self.poses[0].canonical_map.half_extents


def true_back(
    scene: SceneConfig,
    person: Person,
    *,
    given: Sequence[Sequence[Sequence[float]]] = (),
    margin: float = 0.0,
) -> Back:
    """Returns the back of a scene's person in all poses that are looked at.

    Args:
        scene: Where the person is, and how it moves.
        person: The one that `scene.person` names.
        given: Polygons in N that the carer wants kept off.
        margin: Kept around them and the wound, m.

    Raises:
        ScenarioError: If the person is to bend and has no sound rig.
        ValueError: If the wound does not lie on the back.
    """
    camera = scene.camera
    back = TrueBack(
        person,
        bends=scene.motion.bends,
        wound=true_wound(scene, person),
        given=given,
        margin=margin,
        camera=camera.pinhole(),
        R_WC=camera.rotation(),
        p_WC=np.array(camera.eye),
    )
    still = MotionConfig(breath_amplitude=0.0, twist_amplitude=0.0, lean_amplitude=0.0)
    return Back(
        tuple(
            _posed(back, scene, person, motion)
            for motion in (still, *extreme_motions(scene.motion))
        ),
        back.areas,
    )


def extreme_motions(motion: MotionConfig) -> list[MotionConfig]:
    """Returns motions that begin, at time 0, where the given one is at its ends.

    Twist and lean to either side, both at once; of a spine that bends its own twist and
    flexion with them, and each with its side bend to the left and to the right. The
    breath is left out, a departure as well.
    """
    found = []
    sides = (1.0, -1.0) if motion.side_bend_amplitude > 0.0 else (1.0,)
    twists = (1.0, -1.0) if _twists(motion) else (1.0,)
    leans = (1.0, -1.0) if _leans(motion) else (1.0,)
    for twist, lean, side in itertools.product(twists, leans, sides):
        found.append(
            replace(
                motion,
                ramp=0.0,
                twist_phase=twist * _HALF_TURN,
                spine_twist_phase=twist * _HALF_TURN,
                lean_phase=lean * _HALF_TURN,
                flexion_phase=lean * _HALF_TURN,
                side_bend_phase=side * _HALF_TURN,
                departure=None,
            )
        )
    still = len(found) == 1 and not (_twists(motion) or _leans(motion))
    return [] if still else found


def nozzle_poses(
    points_W: FloatArray, normals_W: FloatArray, standoff: float, speed: float
) -> Poses:
    """Returns the nozzle's poses along skin points, square to it.

    Args:
        points_W: (n, 3) m.
        normals_W: (n, 3) outward unit normals.
        standoff: Of the tip from the skin, m.
        speed: Along the skin, m/s; the first pose takes no time. Where the tip or the
            jet would be faster than the pose tracking has it, it is slower.
    """
    tracking, tips = TrackingConfig(), points_W + standoff * normals_W
    steps = np.linalg.norm(np.diff(points_W, axis=0, prepend=points_W[:1]), axis=1)
    shifts = np.linalg.norm(np.diff(tips, axis=0, prepend=tips[:1]), axis=1)
    chords = np.linalg.norm(np.diff(normals_W, axis=0, prepend=normals_W[:1]), axis=1)
    turns = 2.0 * np.arcsin(np.minimum(chords / 2.0, 1.0))
    seconds = np.maximum(
        steps / speed,
        np.maximum(shifts / tracking.speed, turns / tracking.angular_speed),
    )
    return Poses(tips, -normals_W, seconds)


def _twists(motion: MotionConfig) -> bool:
    return max(motion.twist_amplitude, motion.spine_twist_amplitude) > 0.0


def _leans(motion: MotionConfig) -> bool:
    return max(motion.lean_amplitude, motion.flexion_amplitude) > 0.0


def _posed(
    back: TrueBack, scene: SceneConfig, person: Person, motion: MotionConfig
) -> PosedBack:
    R_WM, p_WM = person_pose(
        0.0,
        motion,
        np.array(scene.person_position),
        scene.person_yaw,
        person.hips,
        person.back_normal,
    )
    seen = back.observe(R_WM, p_WM, trunk_bend(0.0, motion), 0.0)
    tracked_map = seen.tracked_map
    assert tracked_map is not None
    boxes_W = person_boxes(tracked_map.R_WP, tracked_map.p_WP, tracked_map.half_extents)
    return PosedBack(
        seen.points_W, tracked_map, boxes_W + stool_obstacle(scene, person)
    )
