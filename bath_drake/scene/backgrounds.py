"""What else the camera sees: walls of other colours, clutter, a second person."""

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    GeometryInstance,
    IllustrationProperties,
    Mesh,
    PerceptionProperties,
    RenderLabel,
    Rgba,
    SceneGraph,
    Shape,
    SourceId,
)
from pydrake.math import RigidTransform, RotationMatrix

from bath_drake.patient.people import PARTS, load_person
from bath_drake.scene.config import SceneConfig
from bath_drake.scene.room import (
    PLAIN,
    ROOM_LABEL,
    RoomColours,
    add_stool,
    coloured,
)
from bath_drake.systems._ports import drake_vector
from bath_drake.systems._poses import at

# Labels of what stands about and of the second person in the label image.
CLUTTER_LABEL, SECOND_PERSON_LABEL = 210, 220

_COLOURS = {
    # Of skin's own hue: tan tiles, sand-coloured grout.
    "tan_wall": RoomColours(
        wall=Rgba(0.80, 0.62, 0.48),
        side_wall=Rgba(0.76, 0.58, 0.45),
        floor=Rgba(0.62, 0.47, 0.36),
        lines=Rgba(0.88, 0.76, 0.64),
        floor_lines=Rgba(0.50, 0.38, 0.30),
    ),
    "dark_wall": RoomColours(
        wall=Rgba(0.10, 0.11, 0.12),
        side_wall=Rgba(0.08, 0.09, 0.10),
        floor=Rgba(0.13, 0.12, 0.12),
        lines=Rgba(0.20, 0.20, 0.21),
        floor_lines=Rgba(0.07, 0.07, 0.07),
    ),
}

# m in W; a shower's wall before the person's knees, beyond the workspace box.
_NEAR_WALL_X = 1.42
_NEAR_WALL = (0.04, 1.6, 2.0)

# m in W, of the second person's frame: beside, within an arm's length.
_BESIDE = (0.12, 0.72)


# What stands and lies about: shape, place (m in W), red, green, blue, and a turn about
# x, rad. Towels, wood and clay have the hue of skin.
_CLUTTER: dict[str, tuple[Shape, tuple[float, ...], tuple[float, ...], float]] = {
    "shelf": (Box(0.3, 0.35, 0.9), (0.85, 0.78, 0.45), (0.62, 0.44, 0.28), 0.0),
    "towel": (Box(0.26, 0.3, 0.12), (0.85, 0.78, 0.96), (0.82, 0.63, 0.5), 0.0),
    "cloth": (Box(0.24, 0.26, 0.08), (0.85, 0.78, 1.06), (0.75, 0.2, 0.18), 0.0),
    "bench": (Box(0.4, 0.3, 0.04), (0.75, -0.68, 0.45), (0.58, 0.38, 0.24), 0.0),
    "legs": (Box(0.36, 0.26, 0.43), (0.75, -0.68, 0.215), (0.45, 0.3, 0.2), 0.0),
    "bottle": (Cylinder(0.035, 0.2), (0.7, -0.62, 0.57), (0.85, 0.55, 0.35), 0.0),
    "soap": (Cylinder(0.03, 0.15), (0.84, -0.7, 0.545), (0.15, 0.45, 0.3), 0.0),
    "sponge": (Ellipsoid(0.06, 0.04, 0.03), (0.62, -0.7, 0.5), (0.9, 0.7, 0.4), 0.0),
    "hose": (Capsule(0.012, 0.8), (0.5, 0.55, 0.45), (0.6, 0.6, 0.62), 0.25),
    "mat": (Cylinder(0.08, 0.6), (0.25, 0.6, 0.08), (0.7, 0.5, 0.4), np.pi / 2),
    "rag": (Box(0.4, 0.3, 0.02), (1.1, -0.5, 0.01), (0.86, 0.7, 0.58), 0.0),
    "bucket": (Cylinder(0.13, 0.26), (1.05, 0.5, 0.13), (0.85, 0.3, 0.2), 0.0),
}


def room_colours(background: str) -> RoomColours:
    """Returns the colours of walls and floor before such a background."""
    return _COLOURS.get(background, PLAIN)


def add_background(
    scene_graph: SceneGraph, source: SourceId, config: SceneConfig
) -> None:
    """Adds what `config.background` has beside the room itself, if anything.

    Nothing of it can be touched: it is there to be seen.

    Args:
        scene_graph: Gets the geometries, anchored.
        source: Owns them.
        config: Of the scene; its background is one of `config.BACKGROUNDS`.
    """
    if config.background in _COLOURS:
        colours = room_colours(config.background)
        wall = Box(*_NEAR_WALL)
        pose = at([_NEAR_WALL_X, 0.0, _NEAR_WALL[2] / 2.0])
        _anchor(scene_graph, source, wall, pose, "near_wall", colours.wall, ROOM_LABEL)
    elif config.background == "clutter":
        for name, (shape, place, rgb, turn) in _CLUTTER.items():
            pose = at(list(place), RotationMatrix.MakeXRotation(turn))
            colour = Rgba(*rgb)
            _anchor(scene_graph, source, shape, pose, name, colour, CLUTTER_LABEL)
    elif config.background == "second_person":
        _add_second_person(scene_graph, source, config)


def _anchor(
    scene_graph: SceneGraph,
    source: SourceId,
    shape: Shape,
    pose: RigidTransform,
    name: str,
    rgba: Rgba,
    label: int,
) -> None:
    instance = coloured(shape, pose, f"background_{name}", rgba, label)
    scene_graph.RegisterAnchoredGeometry(source, instance)


def _add_second_person(
    scene_graph: SceneGraph, source: SourceId, config: SceneConfig
) -> None:
    """Seats somebody else beside the person, on a stool of their own."""
    name = "m_avg" if config.person == "f_avg" else "f_avg"
    person = load_person(name)
    x, y, z = config.person_position
    place = [x + _BESIDE[0], y + _BESIDE[1], z]
    X_WM = at(place, RotationMatrix.MakeZRotation(config.person_yaw))
    add_stool(
        scene_graph,
        source,
        X_WM.multiply(drake_vector(person.seat)),
        name="second_stool",
    )
    for part in PARTS:
        path = person.part_path(part, for_camera=True)
        instance = GeometryInstance(X_WM, Mesh(path), f"second_{part}")
        instance.set_illustration_properties(IllustrationProperties())
        perception = PerceptionProperties()
        perception.AddProperty("label", "id", RenderLabel(SECOND_PERSON_LABEL))
        instance.set_perception_properties(perception)
        scene_graph.RegisterAnchoredGeometry(source, instance)
