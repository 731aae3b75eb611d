"""What a SceneGraph shows to cameras, as surfaces for our own rasteriser."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryId,
    Mesh,
    Rgba,
    Role,
    SceneGraphInspector,
    Sphere,
)
from pydrake.geometry import Shape as DrakeShape
from pydrake.math import RigidTransform

from bath_drake.errors import ScenarioError
from bath_drake.files import read_bytes
from bath_drake.patient.gltf import read_part
from bath_drake.patient.skin_parts import SkinPart
from bath_drake.rendering.normals import vertex_normals
from bath_drake.rendering.obj import obj_shape
from bath_drake.rendering.solids import (
    Shape,
    box,
    capsule,
    cylinder,
    ellipsoid,
    faceted,
    is_solid,
)
from bath_drake.rendering.surfaces import Surface

# Of spheres and round ends: as round as a pixel tells.
_ROUND = {"around": 32, "rings": 17}
# As Drake takes what has no roughness of its own, and as our people's files say.
_ROUGHNESS, _GLTF_ROUGHNESS = 0.5, 0.85
_MAX_BYTES = 64 * 1024 * 1024
# Of a geometry without a label, as in Drake.
_UNLABELLED = 32764
# Of a geometry without a colour, as in Drake.
_COLOUR = Rgba(0.9, 0.7, 0.2)
_ALLOWED = (
    "allowed a box, cylinder, sphere, ellipsoid, capsule, convex or .obj of one phong/"
    "diffuse colour; Drake's renderer draws more: scene.camera.renderer: vtk"
)


@dataclass(frozen=True, eq=False)
class Drawing:
    """A scene's surfaces.

    Attributes:
        still: Those that are anchored, in W.
        moving: The others, each in its own geometry's frame.
        geometries: Theirs, in the same order.
        bending: Which of them bend, by index.
    """

    still: tuple[Surface, ...]
    moving: tuple[Surface, ...]
    geometries: tuple[GeometryId, ...]
    bending: frozenset[int]


def drawing(
    inspector: SceneGraphInspector,
    skin: Mapping[GeometryId, SkinPart] | None = None,
) -> Drawing:
    """Returns what a camera sees of a scene.

    Args:
        inspector: Of the scene, complete.
        skin: The parts that bend, by their geometries.

    Raises:
        ScenarioError: If a geometry has no one colour, or a shape that only Drake's
            own renderer draws; names it.
    """
    skin = skin or {}
    still: list[Surface] = []
    moving: dict[GeometryId, Surface] = {}
    for geometry in inspector.GetAllGeometryIds(Role.kPerception):
        label = _property(inspector, geometry, "label", "id")
        shown = int(label) if label is not None else _UNLABELLED
        if geometry in skin:
            part = skin[geometry]
            points = part.shell.moments.sum(axis=1)[: len(part.shell) // 2]
            normals = vertex_normals(points, part.triangles, True)
            shape = Shape(points, normals, part.triangles)
            moving[geometry] = Surface(shape, part.rgba[:3], shown, one_sided=True)
            continue
        surface = _surface(inspector, geometry, shown)
        if inspector.GetFrameId(geometry) == inspector.world_frame_id():
            X_WG = inspector.GetPoseInFrame(geometry)
            still.append(replace(surface, shape=_posed(surface.shape, X_WG)))
        else:
            moving[geometry] = surface
    bending = frozenset(k for k, geometry in enumerate(moving) if geometry in skin)
    return Drawing(tuple(still), tuple(moving.values()), tuple(moving), bending)


def _surface(
    inspector: SceneGraphInspector, geometry: GeometryId, label: int
) -> Surface:
    """A rigid geometry, in its own frame."""
    name, shape = inspector.GetName(geometry), inspector.GetShape(geometry)
    rgba = _property(inspector, geometry, "phong", "diffuse")
    if isinstance(shape, Mesh) and shape.extension() == ".gltf":
        if shape.source().is_in_memory():
            raise ScenarioError(f"{name}: found a glTF in memory, {_ALLOWED}")
        try:
            part = read_part(Path(shape.source().path()))
        except ScenarioError as error:
            raise ScenarioError(f"{name}: {error}; {_ALLOWED}") from error
        normals = vertex_normals(part.vertices, part.triangles, True)
        mesh = Shape(part.vertices * shape.scale3(), normals, part.triangles)
        # Such a part alone is open, but the others close the body.
        return Surface(mesh, part.rgba[:3], label, _GLTF_ROUGHNESS, one_sided=True)
    if _property(inspector, geometry, "phong", "diffuse_map") is not None:
        raise ScenarioError(f"{name}: found a diffuse_map, {_ALLOWED}")
    if rgba is None and isinstance(shape, Mesh) and "mtllib" in _text(shape):
        raise ScenarioError(f"{name}: found materials in a file, {_ALLOWED}")
    rgba = _COLOUR if rgba is None else rgba
    colour = np.array([rgba.r(), rgba.g(), rgba.b()])
    solid = _rigid_shape(name, shape)
    return Surface(solid, colour, label, _ROUGHNESS, one_sided=is_solid(solid))


def _rigid_shape(name: str, shape: DrakeShape) -> Shape:
    if isinstance(shape, Mesh) and shape.extension() == ".obj":
        try:
            mesh = obj_shape(_text(shape))
        except ValueError as error:
            raise ScenarioError(f"{name}: {error}") from error
        scale = np.asarray(shape.scale3())
        normals = mesh.normals / scale
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return Shape(mesh.vertices * scale, normals, mesh.triangles)
    if isinstance(shape, Convex):
        return _hull(shape)
    if isinstance(shape, Box):
        return box(shape.size())
    if isinstance(shape, Cylinder):
        return cylinder(shape.radius(), shape.length())
    if isinstance(shape, Sphere):
        return ellipsoid(np.zeros(3), np.full(3, shape.radius()), **_ROUND)
    if isinstance(shape, Ellipsoid):
        return ellipsoid(np.zeros(3), [shape.a(), shape.b(), shape.c()], **_ROUND)
    if isinstance(shape, Capsule):
        end = np.array([0.0, 0.0, 0.5 * shape.length()])
        return capsule(-end, end, shape.radius(), **_ROUND)
    raise ScenarioError(f"{name}: found a {type(shape).__name__}, {_ALLOWED}")


def _hull(convex: Convex) -> Shape:
    hull = convex.GetConvexHull()
    points = np.array([hull.vertex(k) for k in range(hull.num_vertices())])
    fans = []
    for k in range(hull.num_faces()):
        face = hull.element(k)
        corners = [face.vertex(i) for i in range(face.num_vertices())]
        fans += [[corners[0], *corners[i : i + 2]] for i in range(1, len(corners) - 1)]
    return faceted(points, np.array(fans, dtype=np.int64))


def _text(mesh: Mesh) -> str:
    source = mesh.source()
    if source.is_in_memory():
        contents: bytes = source.in_memory().mesh_file.contents()
    else:
        contents = read_bytes(
            Path(source.path()), limit=_MAX_BYTES, error=ScenarioError
        )
    # What is not text has no face either.
    return contents.decode(errors="replace")


def _posed(shape: Shape, X_WG: RigidTransform) -> Shape:
    R, p = X_WG.rotation().matrix(), X_WG.translation()
    return Shape(shape.vertices @ R.T + p, shape.normals @ R.T, shape.triangles)


def _property(
    inspector: SceneGraphInspector, geometry: GeometryId, group: str, name: str
) -> Any:
    properties = inspector.GetPerceptionProperties(geometry)
    if properties is None or not properties.HasProperty(group, name):
        return None
    return properties.GetProperty(group, name)
