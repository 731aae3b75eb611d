"""A person whose skin bends, as SceneGraph geometries that our own system moves."""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import (
    GeometryId,
    GeometryInstance,
    PerceptionProperties,
    RenderLabel,
    Rgba,
    SceneGraph,
    SourceId,
)
from pydrake.math import RigidTransform

from bath_drake.notation import FloatArray, IntArray
from bath_drake.patient.bending import BendingSkin
from bath_drake.patient.gltf import read_part
from bath_drake.patient.people import PARTS, Person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin import TrueSkin
from bath_drake.scene.skin_shell import foldable, shell_mesh, with_inside

# Of SceneGraph's deformable geometries, m; a mesh of one's own has its own.
_RESOLUTION_HINT_M = 1.0


@dataclass(frozen=True, eq=False)
class SkinPart:
    """One coloured part of a bending skin.

    Attributes:
        name: As in `bath_drake.patient.people.PARTS`, or `wound`.
        geometry: Its SceneGraph geometry.
        shell: How its vertices move: the outside's, then those just below.
        triangles: (m, 3) of the outside.
        rgba: (4,) 0 to 1.
    """

    name: str
    geometry: GeometryId
    shell: BendingSkin
    triangles: IntArray
    rgba: FloatArray


def add_bending_person(
    scene_graph: SceneGraph, source: SourceId, person: Person, labels: dict[str, int]
) -> list[SkinPart]:
    """Adds a person's parts, seen by the camera alone, and says how they move.

    Meshcat is not among those who see them: Drake's visualizer draws such bodies only
    in its newest versions, so `bath_drake.systems.skin_view` does.

    Args:
        scene_graph: Gets them.
        source: Owns them; its configuration port is to be fed.
        person: Has a rig.
        labels: Of the parts, in the label image.

    Raises:
        ScenarioError: If a part or the rig is damaged.
    """
    skin, bending = TrueSkin(person), bending_skin(person)
    parts = []
    for name in PARTS:
        part = read_part(person.part_path(name, for_camera=True))
        vertices, triangles = foldable(part.vertices, part.triangles)
        parts.append(
            add_skin_part(
                scene_graph,
                source,
                follow(bending, skin, with_inside(vertices, triangles)),
                triangles,
                name=name,
                rgba=part.rgba,
                label=labels[name],
            )
        )
    return parts


def follow(bending: BendingSkin, skin: TrueSkin, p_M: FloatArray) -> BendingSkin:
    """Returns how points (n, 3) on or near a skin at rest move with it."""
    return bending.follower(*skin.bind(p_M)).resting_at(p_M)


def add_skin_part(
    scene_graph: SceneGraph,
    source: SourceId,
    shell: BendingSkin,
    triangles: IntArray,
    *,
    name: str,
    rgba: FloatArray,
    label: int,
) -> SkinPart:
    """Adds one part; arguments as in `SkinPart`, `label` in the label image."""
    mesh = shell_mesh(shell.moments.sum(axis=1), triangles, name)
    instance = GeometryInstance(RigidTransform(), mesh, name)
    perception = PerceptionProperties()
    perception.AddProperty("label", "id", RenderLabel(label))
    perception.AddProperty("phong", "diffuse", Rgba(*np.asarray(rgba)))
    instance.set_perception_properties(perception)
    geometry = scene_graph.RegisterDeformableGeometry(
        source, scene_graph.world_frame_id(), instance, _RESOLUTION_HINT_M
    )
    return SkinPart(name, geometry, shell, triangles, np.asarray(rgba))
