"""The carer of a filmed demonstration, as shapes the camera sees."""

import numpy as np
from pydrake.geometry import (
    FrameId,
    GeometryFrame,
    Rgba,
    SceneGraph,
    SourceId,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder

from bath_drake.carer.arm import PARTS, CarerArm
from bath_drake.carer.config import CarerConfig
from bath_drake.carer.shapes import limbs
from bath_drake.carer.skin_path import SkinPath
from bath_drake.patient.skin import TrueSkin
from bath_drake.scene.config import SceneConfig
from bath_drake.scene.room import coloured, obj_mesh
from bath_drake.scene.studio import Studio, true_person_pose
from bath_drake.systems._ports import drake_vector
from bath_drake.systems.carer_motion import CarerMotion

# Labels of the marker and of the carer in the label image.
MARKER_LABEL, CARER_LABEL = 120, 121

_STICK = Rgba(0.25, 0.25, 0.28)


def carer_arm(config: SceneConfig, skin: TrueSkin, path: SkinPath) -> CarerArm:
    """Stands the carer beside a person.

    Args:
        config: Of the scene; has a carer.
        skin: Of the person.
        path: Of the marker on the skin.
    """
    carer = config.carer
    if carer is None:
        raise ValueError("the scene has no carer")
    X_WM = true_person_pose(config, skin.person, 0.0)
    R_WM = X_WM.rotation().matrix()
    right, _, outward = (R_WM @ skin.canonical_map.R_WP).T
    aside = right if carer.side == "right" else -right
    level = aside * [1.0, 1.0, 0.0]
    return CarerArm(
        path=path,
        marker_radius=carer.marker_radius,
        middle_W=np.array(X_WM.multiply(drake_vector(skin.canonical_map.p_WP))),
        aside_W=level / np.linalg.norm(level),
        outward_W=outward,
        swing=carer.swing,
        swing_period=carer.swing_period,
    )


def add_carer(
    builder: DiagramBuilder, studio: Studio, config: CarerConfig, arm: CarerArm
) -> CarerMotion:
    """Adds the carer's shapes to the scene, and the system `carer_motion`."""
    scene_graph = studio.scene_graph
    source = scene_graph.RegisterSource("carer")
    frames: dict[str, FrameId] = {}
    for part in PARTS:
        frames[part] = scene_graph.RegisterFrame(source, GeometryFrame(part))
    _add_shapes(scene_graph, source, frames, config)
    motion = CarerMotion(frame_ids=frames, arm=arm)
    builder.AddNamedSystem("carer_motion", motion)
    builder.Connect(
        studio.patient_motion.GetOutputPort("body_pose"),
        motion.GetInputPort("body_pose"),
    )
    builder.Connect(
        motion.GetOutputPort("geometry_pose"), scene_graph.get_source_pose_port(source)
    )
    return motion


def _add_shapes(
    scene_graph: SceneGraph,
    source: SourceId,
    frames: dict[str, FrameId],
    config: CarerConfig,
) -> None:
    colours = {
        "skin": Rgba(*config.skin_colour),
        "sleeve": Rgba(*config.sleeve_colour),
        "stick": _STICK,
    }
    ball = Sphere(config.marker_radius)
    colour = Rgba(*config.marker_colour)
    instance = coloured(ball, RigidTransform(), "marker_ball", colour, MARKER_LABEL)
    scene_graph.RegisterGeometry(source, frames["marker"], instance)
    for part, shapes in limbs(config.marker_radius).items():
        for kind, shape in shapes.items():
            name = f"{part}_{kind}"
            mesh = obj_mesh(name, shape.vertices, shape.normals, shape.triangles)
            instance = coloured(
                mesh, RigidTransform(), name, colours[kind], CARER_LABEL
            )
            scene_graph.RegisterGeometry(source, frames[part], instance)
