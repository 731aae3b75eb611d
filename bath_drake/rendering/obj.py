"""Meshes of Wavefront's OBJ files: vertices, normals and faces."""

import numpy as np

from bath_drake.notation import FloatArray, IntArray
from bath_drake.rendering.solids import Shape, faceted


def obj_shape(text: str) -> Shape:
    """Returns the mesh of an OBJ file's text, with its normals or flat without.

    Every corner has its own vertex; a face of more than three corners is a fan.
    Colours, textures, groups and curves are passed over.

    Raises:
        ValueError: If there is no face, a number is none, or an index is out of range;
            names the line.
    """
    points: list[list[float]] = []
    normals: list[list[float]] = []
    corners: list[tuple[int, int]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        kind, _, rest = line.strip().partition(" ")
        try:
            if kind in ("v", "vn"):
                values = [float(word) for word in rest.split()[:3]]
                if len(values) != 3 or not np.isfinite(values).all():
                    raise ValueError("allowed three finite numbers")
                (points if kind == "v" else normals).append(values)
            elif kind == "f":
                face = [
                    _corner(word, len(points), len(normals)) for word in rest.split()
                ]
                if len(face) < 3:
                    raise ValueError("allowed three corners or more")
                for k in range(1, len(face) - 1):
                    corners += [face[0], face[k], face[k + 1]]
        except ValueError as error:
            raise ValueError(f"line {number}: found {line[:60]!r}, {error}") from error
    if not corners:
        raise ValueError("found no face, allowed one or more")
    indices: IntArray = np.array(corners, dtype=np.int64)
    vertices = np.array(points)[indices[:, 0]]
    own = np.arange(len(indices)).reshape(-1, 3)
    if (indices[:, 1] < 0).any():
        return faceted(vertices, own)
    given: FloatArray = np.array(normals)[indices[:, 1]]
    length = np.linalg.norm(given, axis=1, keepdims=True)
    return Shape(vertices, given / np.maximum(length, 1e-300), own)


def _corner(word: str, points: int, normals: int) -> tuple[int, int]:
    """Indices from 0 of a corner's vertex and normal; the latter -1 without one."""
    parts = word.split("/")
    vertex = _index(parts[0], points)
    if len(parts) < 3 or not parts[2]:
        return vertex, -1
    return vertex, _index(parts[2], normals)


def _index(word: str, count: int) -> int:
    index = int(word)
    # Negative ones count from the newest.
    index = index - 1 if index > 0 else count + index
    if not 0 <= index < count:
        raise ValueError(f"index {word}: allowed 1 to {count}")
    return index
