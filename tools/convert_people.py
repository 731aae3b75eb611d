"""Makes `body_low.gltf` of a person folder: the body part for the camera, decimated.

The camera needs the limbs and the head only as something that may hide the
back, so their tens of thousands of triangles (eyes, teeth, fingers) only cost
rendering time. The border to back, hair and trunks stays exactly as it is.

    python tools/convert_people.py models/people/m_avg [...] [--triangles 2500]
"""

import argparse
from pathlib import Path

import numpy as np
import open3d as o3d
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from bath_drake.patient.gltf import Part, gltf_text, read_part

# Triangles this near to the border are kept as they are; the decimated rest
# begins under them, so that no gap can open between the two.
_KEPT_BAND_M = 0.03
_OVERLAP_FROM_M = 0.006
# Components below this size (eyes, teeth, lashes) lie inside the head, unless
# they share vertices with another part.
_SMALLEST_COMPONENT_M = 0.1

_OTHER_PARTS = ("back", "hair", "trunks")

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def _without_small_components(
    mesh: o3d.geometry.TriangleMesh, other_parts: Floats
) -> None:
    clusters, _, _ = mesh.cluster_connected_triangles()
    labels = np.asarray(clusters)
    vertices, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    small = np.zeros(len(triangles), dtype=bool)
    tree = cKDTree(other_parts)
    for label in np.unique(labels):
        own = vertices[np.unique(triangles[labels == label])]
        loose = tree.query(own)[0].min() > 1e-4
        if loose and np.linalg.norm(np.ptp(own, axis=0)) < _SMALLEST_COMPONENT_M:
            small |= labels == label
    mesh.remove_triangles_by_mask(small)
    mesh.remove_unreferenced_vertices()


def border_vertices(vertices: Floats, triangles: Ints) -> Floats:
    """Returns the vertices (n, 3) on edges that only one triangle has."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, counts = np.unique(edges, axis=0, return_counts=True)
    return vertices[np.unique(unique[counts == 1])]


def decimate(folder: Path, target: int) -> None:
    """Writes folder/body_low.gltf and prints what became of the border."""
    part = read_part(folder / "body.gltf")
    vertices, triangles = part.vertices, part.triangles
    mesh = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(triangles)
    )
    mesh.merge_close_vertices(1e-6)
    others = [read_part(folder / f"{name}.gltf").vertices for name in _OTHER_PARTS]
    _without_small_components(mesh, np.vstack(others))
    mesh.compute_vertex_normals()
    v, f = np.asarray(mesh.vertices), np.asarray(mesh.triangles).astype(np.int64)
    distance = cKDTree(border_vertices(v, f)).query(v)[0][f].min(axis=1)
    rest = o3d.geometry.TriangleMesh(mesh)
    rest.remove_triangles_by_mask(distance < _OVERLAP_FROM_M)
    rest.remove_unreferenced_vertices()
    kept = f[distance < _KEPT_BAND_M]
    low = rest.simplify_quadric_decimation(target, boundary_weight=10.0)
    low.remove_unreferenced_vertices()
    low.compute_vertex_normals()
    used, kept = np.unique(kept, return_inverse=True)
    v_low = np.vstack([v[used], np.asarray(low.vertices)])
    normals = np.vstack(
        [np.asarray(mesh.vertex_normals)[used], np.asarray(low.vertex_normals)]
    )
    f_low = np.vstack([kept.reshape(-1, 3), np.asarray(low.triangles) + len(used)])
    low_part = Part(v_low, f_low, part.rgba)
    (folder / "body_low.gltf").write_text(gltf_text(low_part, normals) + "\n")
    border = border_vertices(v, f)
    gap = cKDTree(v_low).query(border)[0].max()
    print(
        f"{folder.name}: {len(triangles)} -> {len(f_low)} triangles,"
        f" border moved by {1e3 * gap:.3f} mm at most"
    )


def main() -> None:
    """Parses the arguments and converts every folder named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--triangles", type=int, default=4000)
    options = parser.parse_args()
    for folder in options.folders:
        decimate(folder, options.triangles)


if __name__ == "__main__":
    main()
