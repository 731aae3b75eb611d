"""Makes `body_low.gltf` of a person folder: the body part for the camera, decimated.

The camera needs the limbs and the head only as something that may hide the
back, so their tens of thousands of triangles (eyes, teeth, fingers) only cost
rendering time. The border to back, hair and trunks stays exactly as it is.

    python tools/convert_people.py models/people/m_avg [...] [--triangles 2500]
"""

import argparse
import base64
import json
from pathlib import Path

import numpy as np
import open3d as o3d
from numpy.typing import NDArray
from scipy.spatial import cKDTree

# glTF has y up, the meshes z up.
_Z_UP_FROM_Y_UP = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
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


def read_gltf(path: Path) -> tuple[Floats, Ints, list[float]]:
    """Returns vertices (n, 3) m with z up, triangles (m, 3), colour RGBA."""
    gltf = json.loads(path.read_text())
    buffers = []
    for buffer in gltf["buffers"]:
        buffers.append(base64.b64decode(buffer["uri"].split(",", 1)[1]))

    def read(index: int, dtype: str, width: int) -> NDArray[np.generic]:
        accessor = gltf["accessors"][index]
        view = gltf["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        raw = np.frombuffer(
            buffers[view["buffer"]], dtype, accessor["count"] * width, start
        )
        return raw.reshape(-1, width)

    primitive = gltf["meshes"][0]["primitives"][0]
    vertices = read(primitive["attributes"]["POSITION"], "<f4", 3).astype(float)
    triangles = read(primitive["indices"], "<u4", 1).reshape(-1, 3).astype(np.int64)
    material = gltf["materials"][0]["pbrMetallicRoughness"]
    return vertices @ _Z_UP_FROM_Y_UP.T, triangles, material["baseColorFactor"]


def write_gltf(
    path: Path, vertices: Floats, normals: Floats, triangles: Ints, rgba: list[float]
) -> None:
    """Writes one flat-material mesh, everything inside the one file."""
    arrays = [
        triangles.astype("<u4").ravel(),
        (vertices @ _Z_UP_FROM_Y_UP).astype("<f4"),
        (normals @ _Z_UP_FROM_Y_UP).astype("<f4"),
    ]
    views, offset = [], 0
    for array in arrays:
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": array.nbytes})
        offset += array.nbytes
    data = base64.b64encode(b"".join(array.tobytes() for array in arrays)).decode()
    gltf = {
        "asset": {"version": "2.0", "generator": "bath_drake tools/convert_people.py"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [
            {
                "primitives": [
                    {
                        "attributes": {"POSITION": 1, "NORMAL": 2},
                        "indices": 0,
                        "material": 0,
                    }
                ]
            }
        ],
        "materials": [
            {
                "pbrMetallicRoughness": {
                    "baseColorFactor": rgba,
                    "metallicFactor": 0.0,
                    "roughnessFactor": 0.85,
                }
            }
        ],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5125,
                "type": "SCALAR",
                "count": int(triangles.size),
            },
            {
                "bufferView": 1,
                "componentType": 5126,
                "type": "VEC3",
                "count": len(vertices),
                "min": arrays[1].min(axis=0).tolist(),
                "max": arrays[1].max(axis=0).tolist(),
            },
            {
                "bufferView": 2,
                "componentType": 5126,
                "type": "VEC3",
                "count": len(vertices),
            },
        ],
        "bufferViews": views,
        "buffers": [
            {
                "byteLength": offset,
                "uri": f"data:application/octet-stream;base64,{data}",
            }
        ],
    }
    path.write_text(json.dumps(gltf, separators=(",", ":")) + "\n")


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
    vertices, triangles, rgba = read_gltf(folder / "body.gltf")
    mesh = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(triangles)
    )
    mesh.merge_close_vertices(1e-6)
    others = [read_gltf(folder / f"{part}.gltf")[0] for part in _OTHER_PARTS]
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
    write_gltf(folder / "body_low.gltf", v_low, normals, f_low, rgba)
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
