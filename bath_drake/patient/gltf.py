"""One part of a person as a glTF file: a single mesh of a single colour."""

import base64
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.errors import ScenarioError
from bath_drake.files import read_bytes
from bath_drake.notation import FloatArray, IntArray

# A person is within so much of their own origin, m.
FURTHEST_M = 10.0

_MAX_BYTES = 64 * 1024 * 1024
# Of glTF's component types, those that positions and indices have in such a file.
_TYPES = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC3": 3}
# What would put the mesh elsewhere than its vertices say.
_MOVING = {
    "matrix": np.eye(4).ravel().tolist(),
    "translation": [0.0, 0.0, 0.0],
    "rotation": [0.0, 0.0, 0.0, 1.0],
    "scale": [1.0, 1.0, 1.0],
}


@dataclass(frozen=True, eq=False)
class Part:
    """A coloured mesh in frame M.

    Attributes:
        vertices: (n, 3) m, z up (glTF files have y up).
        triangles: (m, 3) indices, counter-clockwise from outside.
        rgba: (4,) its colour, 0 to 1.
    """

    vertices: FloatArray
    triangles: IntArray
    rgba: FloatArray


def read_part(path: Path) -> Part:
    """Reads a part whose buffers lie within the file.

    Raises:
        ScenarioError: If the file is missing, damaged or more than such a mesh.
    """
    data = read_bytes(path, limit=_MAX_BYTES, error=ScenarioError)
    try:
        part = _part(json.loads(data))
    except (ArithmeticError, LookupError, TypeError, ValueError, RecursionError) as e:
        raise ScenarioError(
            f"{path}: not a glTF mesh with its buffers inside ({e!r:.80})"
        ) from e
    n = len(part.vertices)
    if not np.isfinite(part.vertices).all():
        raise ScenarioError(f"{path}: a vertex is not finite")
    furthest = float(np.abs(part.vertices).max(initial=0.0))
    if furthest > FURTHEST_M:
        raise ScenarioError(
            f"{path}: a vertex is {furthest:.3g} m off, allowed {FURTHEST_M:g}"
        )
    if not n or not len(part.triangles) or part.triangles.max() >= n:
        raise ScenarioError(f"{path}: indices: allowed 0 to {n - 1}, at least three")
    if part.rgba.shape != (4,) or not ((part.rgba >= 0) & (part.rgba <= 1)).all():
        raise ScenarioError(f"{path}: baseColorFactor: allowed four numbers 0 to 1")
    return part


def _part(gltf: dict[str, Any]) -> Part:
    for node in gltf.get("nodes", []):
        for name, nothing in _MOVING.items():
            if node.get(name, nothing) != nothing:
                raise ValueError(f"found a {name} at a node, allowed none")
    (mesh,) = gltf["meshes"]
    (primitive,) = mesh["primitives"]
    material = gltf["materials"][primitive["material"]]["pbrMetallicRoughness"]
    # A NaN that signals warns as it is cast; whether all is finite is asked later.
    with np.errstate(invalid="ignore"):
        positions = _array(gltf, primitive["attributes"]["POSITION"], "f").astype(float)
    x, y, z = positions.T
    return Part(
        vertices=np.column_stack([x, -z, y]),
        triangles=_array(gltf, primitive["indices"], "u")
        .astype(np.int64)
        .reshape(-1, 3),
        rgba=np.array(material["baseColorFactor"], dtype=np.float64),
    )


def _array(gltf: dict[str, Any], index: int, kinds: str) -> np.ndarray[Any, Any]:
    accessor = gltf["accessors"][index]
    view = gltf["bufferViews"][accessor["bufferView"]]
    uri = gltf["buffers"][view["buffer"]]["uri"]
    data = base64.b64decode(uri.split("base64,", 1)[1], validate=True)
    width = _WIDTHS[accessor["type"]]
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    kind = np.dtype(_TYPES[accessor["componentType"]])
    if kind.kind not in kinds:
        allowed = {"f": "float32", "u": "unsigned integers"}[kinds]
        raise ValueError(f"found {kind.name}, allowed {allowed}")
    flat = np.frombuffer(data, kind, accessor["count"] * width, start)
    return flat.reshape(-1, width) if width > 1 else flat


def gltf_text(part: Part, normals: FloatArray) -> str:
    """Returns a part as a glTF file, everything inside the one file.

    Args:
        part: What to write.
        normals: (n, 3) unit, in M, of its vertices.
    """
    arrays = [
        part.triangles.astype("<u4").ravel(),
        _y_up(part.vertices).astype("<f4"),
        _y_up(normals).astype("<f4"),
    ]
    views, offset = [], 0
    for array in arrays:
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": array.nbytes})
        offset += array.nbytes
    data = base64.b64encode(b"".join(array.tobytes() for array in arrays)).decode()
    count = len(part.vertices)
    box = {"min": arrays[1].min(axis=0).tolist(), "max": arrays[1].max(axis=0).tolist()}
    primitive = {
        "attributes": {"POSITION": 1, "NORMAL": 2},
        "indices": 0,
        "material": 0,
    }
    gltf = {
        "asset": {"version": "2.0", "generator": "bath_drake"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "materials": [
            {
                "pbrMetallicRoughness": {
                    "baseColorFactor": np.asarray(part.rgba).tolist(),
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
                "count": int(part.triangles.size),
            },
            {"bufferView": 1, "componentType": 5126, "type": "VEC3", "count": count}
            | box,
            {"bufferView": 2, "componentType": 5126, "type": "VEC3", "count": count},
        ],
        "bufferViews": views,
        "buffers": [
            {
                "byteLength": offset,
                "uri": f"data:application/octet-stream;base64,{data}",
            }
        ],
    }
    return json.dumps(gltf, separators=(",", ":"))


def _y_up(vectors: FloatArray) -> FloatArray:
    x, y, z = np.asarray(vectors).T
    return np.column_stack([x, z, -y])
