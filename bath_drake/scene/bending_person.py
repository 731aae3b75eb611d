"""A person whose skin bends, as SceneGraph geometries that our own system moves."""

from collections.abc import Iterable, Mapping

from pydrake.common import MemoryFile
from pydrake.geometry import (
    GeometryId,
    GeometryInstance,
    InMemoryMesh,
    Mesh,
    PerceptionProperties,
    RenderLabel,
    Rgba,
    SceneGraph,
    SourceId,
)
from pydrake.math import RigidTransform

from bath_drake.notation import FloatArray, IntArray
from bath_drake.patient.shell import shell_tetrahedra
from bath_drake.patient.skin_parts import SkinPart

# Of SceneGraph's deformable geometries, m; a mesh of one's own has its own.
_RESOLUTION_HINT_M = 1.0


def add_bending_parts(
    scene_graph: SceneGraph,
    source: SourceId,
    parts: Iterable[SkinPart],
    labels: Mapping[str, int],
) -> dict[str, GeometryId]:
    """Adds parts of a skin that the camera sees; returns their geometries by name.

    Meshcat is not among those who see them: Drake's visualizer draws such bodies only
    in its newest versions, so `bath_drake.systems.skin_view` does.

    Args:
        scene_graph: Gets them, in W.
        source: Owns them; its configuration port is to be fed.
        parts: Of one person.
        labels: Of the parts, in the label image.
    """
    geometries = {}
    for part in parts:
        mesh = shell_mesh(part.shell.moments.sum(axis=1), part.triangles, part.name)
        instance = GeometryInstance(RigidTransform(), mesh, part.name)
        perception = PerceptionProperties()
        perception.AddProperty("label", "id", RenderLabel(labels[part.name]))
        perception.AddProperty("phong", "diffuse", Rgba(*part.rgba))
        instance.set_perception_properties(perception)
        geometries[part.name] = scene_graph.RegisterDeformableGeometry(
            source, scene_graph.world_frame_id(), instance, _RESOLUTION_HINT_M
        )
    return geometries


def shell_mesh(shell: FloatArray, triangles: IntArray, name: str) -> Mesh:
    """Returns the shell of a skin as a mesh in memory.

    Args:
        shell: (2 n, 3) m, as of `bath_drake.patient.shell.with_inside`; its vertices
            are the mesh's.
        triangles: (m, 3) indices of the first n, as of `foldable`.
        name: For error messages.
    """
    return vtk_mesh(shell, shell_tetrahedra(triangles, len(shell) // 2), name)


def vtk_mesh(points: FloatArray, tetrahedra: IntArray, name: str) -> Mesh:
    """Returns tetrahedra (m, 4), indices of points (n, 3) in m, as a mesh in memory."""
    lines = ["# vtk DataFile Version 3.0", "skin", "ASCII", "DATASET UNSTRUCTURED_GRID"]
    lines.append(f"POINTS {len(points)} double")
    lines += [f"{x:.9g} {y:.9g} {z:.9g}" for x, y, z in points]
    lines.append(f"CELLS {len(tetrahedra)} {5 * len(tetrahedra)}")
    lines += [f"4 {a} {b} {c} {d}" for a, b, c, d in tetrahedra]
    lines.append(f"CELL_TYPES {len(tetrahedra)}")
    lines += ["10"] * len(tetrahedra)
    file = MemoryFile("\n".join(lines) + "\n", ".vtk", name)
    return Mesh(InMemoryMesh(mesh_file=file), 1.0)
