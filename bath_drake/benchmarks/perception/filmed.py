"""People as the camera films them, with what is true of every frame."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import SceneGraph
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from bath_drake.notation import BoolArray, ByteArray, FloatArray
from bath_drake.patient.bending import BendingSkin
from bath_drake.patient.motion import MotionConfig, trunk_bend
from bath_drake.patient.people import Person, load_person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.washed_skin import triangles_around_back
from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.config import PerceptionConfig, segmentation
from bath_drake.perception.depth_noise import noisy_depth
from bath_drake.perception.observation import observe_body
from bath_drake.perception.segmenter import Segmenter
from bath_drake.scene.camera import add_camera
from bath_drake.scene.config import SceneConfig
from bath_drake.scene.studio import (
    PERSON_LABELS,
    WOUND_LABEL,
    add_studio,
    true_person_pose,
)

STILL = MotionConfig(breath_amplitude=0.0, twist_amplitude=0.0, lean_amplitude=0.0)
# The whole person breathes, twists and leans; the spine does not bend.
MOVING = MotionConfig()
# As far as the issue that asks for it says: twist 12, flexion 8, side bend 5 degrees.
BENDING = replace(
    STILL,
    breath_amplitude=0.004,
    spine_twist_amplitude=float(np.deg2rad(12.0)),
    flexion_amplitude=float(np.deg2rad(8.0)),
    side_bend_amplitude=float(np.deg2rad(5.0)),
    chest_amplitude=0.006,
)


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame of a camera with noise, and the truth of that instant.

    Attributes:
        t: s.
        colour: (H, W, 4).
        depth: (H, W), m, with a Kinect v2's noise.
        back: (H, W) pixels that show the back, wounds included.
        skin: The person's skin as it was, in M; of the trunk alone.
        R_WM: (3, 3) where the person was.
        p_WM: (3,) m.
    """

    t: float
    colour: ByteArray
    depth: NDArray[np.float32]
    back: BoolArray
    skin: TrueSkin
    R_WM: FloatArray
    p_WM: FloatArray

    def in_world(self, p_M: FloatArray) -> FloatArray:
        """Returns points (n, 3) of M in W, m."""
        return np.asarray(p_M @ self.R_WM.T + self.p_WM)

    def in_person(self, p_W: FloatArray) -> FloatArray:
        """Returns points (n, 3) of W in M, m."""
        return np.asarray((p_W - self.p_WM) @ self.R_WM)


@dataclass(frozen=True, eq=False)
class Filmed:
    """A person before the camera; no arm, no carer.

    Attributes:
        scene: What was built.
        person: Who sits there.
        bending: How the skin's vertices move.
        camera: Its projection.
    """

    scene: SceneConfig
    person: Person
    bending: BendingSkin
    camera: PinholeCamera

    def frames(self, times: FloatArray, seed: int = 0) -> Iterator[Frame]:
        """Films the person at rising times, s, multiples of the frame's period."""
        builder, scene_graph = DiagramBuilder(), SceneGraph()
        builder.AddNamedSystem("scene_graph", scene_graph)
        studio = add_studio(builder, scene_graph, self.scene, self.person)
        camera = add_camera(
            builder, scene_graph, self.scene.camera, studio.skin_by_geometry()
        )
        diagram = builder.Build()
        simulator = Simulator(diagram)
        simulator.Initialize()
        view = camera.GetMyContextFromRoot(simulator.get_context())
        around = triangles_around_back(self.person)
        for k, t in enumerate(times):
            simulator.AdvanceTo(float(t))
            label: Any = camera.label_image_output_port().Eval(view)
            depth: Any = camera.depth_image_32F_output_port().Eval(view)
            colour: Any = camera.color_image_output_port().Eval(view)
            X_WM = true_person_pose(self.scene, self.person, float(t))
            bent = self.bending.points(trunk_bend(float(t), self.scene.motion))
            yield Frame(
                t=float(t),
                colour=colour.data.copy(),
                depth=noisy_depth(depth.data[..., 0], self.camera, seed=seed, frame=k),
                back=np.isin(label.data[..., 0], (PERSON_LABELS["back"], WOUND_LABEL)),
                skin=TrueSkin(self.person, bent, around),
                R_WM=np.array(X_WM.rotation().matrix()),
                p_WM=np.array(X_WM.translation()),
            )


def filmed(name: str, motion: MotionConfig, background: str = "plain") -> Filmed:
    """Returns a shipped person who moves like that, before the default camera."""
    scene = SceneConfig(person=name, motion=motion, background=background)
    person = load_person(name)
    return Filmed(scene, person, bending_skin(person), scene.camera.pinhole())


def observed(
    film: Filmed,
    frame: Frame,
    previous: BodyObservation | None,
    segmenter: Segmenter | None = None,
) -> BodyObservation:
    """Returns what perception makes of a frame, there being no robot."""
    return observe_body(
        frame.colour,
        frame.depth.astype(np.float64),
        np.zeros(frame.depth.shape, dtype=bool),
        camera=film.camera,
        R_WC=film.scene.camera.rotation(),
        p_WC=np.array(film.scene.camera.eye),
        config=segmentation(PerceptionConfig()),
        stamp=frame.t,
        previous=previous,
        segmenter=segmenter,
    )
