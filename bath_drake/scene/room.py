"""The shower room and its furniture: shapes to look at, nothing to collide with."""

from dataclasses import dataclass

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import (
    Box,
    Cylinder,
    GeometryInstance,
    IllustrationProperties,
    InMemoryMesh,
    Mesh,
    PerceptionProperties,
    RenderLabel,
    Rgba,
    SceneGraph,
    Shape,
    SourceId,
)
from pydrake.math import RigidTransform, RotationMatrix

from bath_drake.notation import FloatArray, IntArray
from bath_drake.scene.config import ArmConfig, CameraConfig
from bath_drake.systems._poses import at

# Labels of the room; the arm's bodies take the low numbers, people 100 and up.
ROOM_LABEL, STOOL_LABEL, PEDESTAL_LABEL = 200, 201, 202

# The room, metres in W: it is open towards -x and -y, where one looks in.
_FRONT_X, _BACK_X = 2.2, -1.6
_LEFT_Y, _RIGHT_Y = 1.5, -1.5
_HEIGHT = 2.4
_THICKNESS = 0.05
_TILE, _GROUT = 0.3, 0.008

_STOOL = Rgba(0.93, 0.95, 0.96)
_STEEL = Rgba(0.55, 0.58, 0.62)
_DARK = Rgba(0.22, 0.24, 0.28)

STOOL_RADIUS, _STOOL_SEAT = 0.17, 0.035
PEDESTAL_SIDE = 0.24


@dataclass(frozen=True)
class RoomColours:
    """Of tiles and grout."""

    wall: Rgba
    side_wall: Rgba
    floor: Rgba
    lines: Rgba
    floor_lines: Rgba


PLAIN = RoomColours(
    wall=Rgba(0.93, 0.97, 0.98),
    side_wall=Rgba(0.88, 0.95, 0.97),
    floor=Rgba(0.66, 0.75, 0.80),
    lines=Rgba(0.70, 0.80, 0.84),
    floor_lines=Rgba(0.48, 0.57, 0.62),
)


def obj_mesh(
    name: str, vertices: FloatArray, normals: FloatArray, triangles: IntArray
) -> Mesh:
    """Returns a Drake mesh held in memory as an OBJ file.

    Args:
        name: For error messages, one line.
        vertices: (n, 3) m.
        normals: (n, 3) unit.
        triangles: (m, 3) indices from 0, counter-clockwise from outside.
    """
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices]
    lines += [f"vn {x:.4f} {y:.4f} {z:.4f}" for x, y, z in normals]
    lines += [f"f {a}//{a} {b}//{b} {c}//{c}" for a, b, c in triangles + 1]
    file = MemoryFile("\n".join(lines) + "\n", ".obj", name)
    return Mesh(InMemoryMesh(mesh_file=file), 1.0)


def coloured(
    shape: Shape,
    pose: RigidTransform,
    name: str,
    rgba: Rgba,
    label: int,
    *,
    for_camera: bool = True,
    for_display: bool = True,
) -> GeometryInstance:
    """Returns a geometry with the visual roles asked for."""
    instance = GeometryInstance(pose, shape, name)
    if for_display:
        illustration = IllustrationProperties()
        illustration.AddProperty("phong", "diffuse", rgba)
        instance.set_illustration_properties(illustration)
    if for_camera:
        perception = PerceptionProperties()
        perception.AddProperty("phong", "diffuse", rgba)
        perception.AddProperty("label", "id", RenderLabel(label))
        instance.set_perception_properties(perception)
    return instance


def add_room(
    scene_graph: SceneGraph, source: SourceId, colours: RoomColours = PLAIN
) -> None:
    """Adds floor, front wall and side wall with their tiles."""
    length, width = _FRONT_X - _BACK_X, _LEFT_Y - _RIGHT_Y
    middle_x, middle_y = (_FRONT_X + _BACK_X) / 2.0, (_LEFT_Y + _RIGHT_Y) / 2.0
    turn = RotationMatrix
    # Each plane: z of its own frame points into the room.
    floor = at([middle_x, middle_y, 0.0])
    front = at([_FRONT_X, middle_y, _HEIGHT / 2.0], turn.MakeYRotation(-np.pi / 2))
    side = at([middle_x, _LEFT_Y, _HEIGHT / 2.0], turn.MakeXRotation(np.pi / 2))
    planes = (
        ("floor", floor, length, width, colours.floor, colours.floor_lines),
        ("front_wall", front, _HEIGHT, width, colours.wall, colours.lines),
        ("side_wall", side, length, _HEIGHT, colours.side_wall, colours.lines),
    )
    for name, X_WF, along, across, colour, lines in planes:
        slab = X_WF @ at([0.0, 0.0, -_THICKNESS / 2.0])
        box = Box(along, across, _THICKNESS)
        # The camera never sees a slab's other five faces, but each pixel of them
        # would be shaded first: three milliseconds a frame without a GPU.
        face = obj_mesh(f"{name}_face", *_face(along, across))
        grout = obj_mesh(f"{name}_grout", *_grout(along, across))
        for instance in (
            coloured(box, slab, name, colour, ROOM_LABEL, for_camera=False),
            coloured(face, X_WF, f"{name}_face", colour, ROOM_LABEL, for_display=False),
            coloured(grout, X_WF, f"{name}_grout", lines, ROOM_LABEL),
        ):
            scene_graph.RegisterAnchoredGeometry(source, instance)


def _face(along: float, across: float) -> tuple[FloatArray, FloatArray, IntArray]:
    """A rectangle around the origin, its normal along z."""
    x, y = along / 2.0, across / 2.0
    vertices = np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])
    normals = np.tile(np.array([0.0, 0.0, 1.0]), (4, 1))
    return vertices, normals, np.array([[0, 1, 2], [0, 2, 3]])


def _grout(along: float, across: float) -> tuple[FloatArray, FloatArray, IntArray]:
    """The lines between the tiles of a plane, just above it."""
    vertices: list[list[float]] = []
    for span, other, swap in ((along, across, False), (across, along, True)):
        for offset in np.arange(-span / 2.0 + _TILE, span / 2.0 - 1e-6, _TILE):
            u0, u1 = offset - _GROUT / 2.0, offset + _GROUT / 2.0
            v0, v1 = -other / 2.0, other / 2.0
            corners = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)]
            if swap:
                corners = [(v, u) for u, v in reversed(corners)]
            vertices += [[u, v, 0.002] for u, v in corners]
    first = 4 * np.arange(len(vertices) // 4)[:, None]
    halves = np.array([[0, 1, 2], [0, 2, 3]])
    triangles = np.vstack([first + half for half in halves]).astype(np.int64)
    normals = np.tile(np.array([0.0, 0.0, 1.0]), (len(vertices), 1))
    return np.array(vertices), normals, triangles


def add_stool(
    scene_graph: SceneGraph,
    source: SourceId,
    seat_W: FloatArray,
    *,
    name: str = "stool",
) -> None:
    """Adds a round stool whose seat's top touches the point `seat_W` (3,), m."""
    x, y, top = (float(value) for value in seat_W)
    seat = Cylinder(STOOL_RADIUS, _STOOL_SEAT)
    leg_length = top - _STOOL_SEAT
    parts = [
        (f"{name}_seat", seat, [x, y, top - _STOOL_SEAT / 2.0], _STOOL),
        (
            f"{name}_column",
            Cylinder(0.03, leg_length),
            [x, y, leg_length / 2.0],
            _STEEL,
        ),
        (f"{name}_foot", Cylinder(0.16, 0.02), [x, y, 0.01], _STEEL),
    ]
    for part, shape, position, colour in parts:
        scene_graph.RegisterAnchoredGeometry(
            source,
            coloured(shape, at(position), part, colour, STOOL_LABEL),
        )


def add_pedestal(scene_graph: SceneGraph, source: SourceId, arm: ArmConfig) -> None:
    """Adds the pedestal under the arm's base."""
    x, y, height = (float(value) for value in arm.base_position)
    if height <= 0.0:
        return
    turn = RotationMatrix.MakeZRotation(arm.base_yaw)
    block = Box(PEDESTAL_SIDE, PEDESTAL_SIDE, height)
    pose = at([x, y, height / 2.0], turn)
    scene_graph.RegisterAnchoredGeometry(
        source, coloured(block, pose, "pedestal", _STEEL, PEDESTAL_LABEL)
    )


def add_camera_stand(
    scene_graph: SceneGraph, source: SourceId, camera: CameraConfig
) -> None:
    """Adds the camera's housing on a post, for display alone: it never sees itself."""
    eye, R_WC = np.array(camera.eye), camera.rotation()
    X_WC = at(eye, RotationMatrix(R_WC))
    backward = -R_WC[:, 2] * [1.0, 1.0, 0.0]
    foot = eye + 0.25 * backward / np.linalg.norm(backward)
    height = float(eye[2])
    beam = (foot - eye)[:2]
    turn = RotationMatrix.MakeZRotation(float(np.arctan2(beam[1], beam[0])))
    parts = [
        ("camera", Box(0.25, 0.066, 0.05), X_WC @ at([0.0, 0.0, -0.03])),
        (
            "camera_post",
            Cylinder(0.02, height),
            at([foot[0], foot[1], height / 2.0]),
        ),
        (
            "camera_bracket",
            Box(0.25, 0.03, 0.03),
            at([*((eye + foot)[:2] / 2.0), height - 0.015], turn),
        ),
    ]
    for name, shape, pose in parts:
        scene_graph.RegisterAnchoredGeometry(
            source, coloured(shape, pose, name, _DARK, ROOM_LABEL, for_camera=False)
        )
