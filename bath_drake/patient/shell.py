"""A thin shell of tetrahedra on a skin of triangles.

SceneGraph's deformable geometries are tetrahedral meshes whose reference volumes are
positive; so every triangle becomes a prism of three tetrahedra, a fraction of a
millimetre thick.
"""

import numpy as np

from bath_drake.notation import BoolArray, FloatArray, IntArray
from bath_drake.rendering.normals import vertex_normals

# Thin, for it is not skin one can feel; thick enough for single precision.
THICKNESS_M = 3e-4

# Single precision tells no thinner tetrahedron from a flat one.
_LEAST_VOLUME_M3 = 1e-18


def foldable(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """Returns a skin that a shell of positive volumes can be laid on.

    Where the skin is folded so sharply that no direction at a vertex is inside of all
    its triangles, the folded ones get vertices of their own, in the same places.

    Args:
        vertices: (n, 3) m.
        triangles: (m, 3) indices, counter-clockwise from outside.
    """
    points = np.array(vertices, dtype=np.float64)
    faces = np.array(triangles, dtype=np.int64)
    alone = np.zeros(len(faces), dtype=bool)
    while True:
        used, packed = np.unique(faces, return_inverse=True)
        points, faces = points[used], packed.reshape(-1, 3).astype(np.int64)
        tetrahedra = shell_tetrahedra(faces, len(points))
        held = volumes(with_inside(points, faces), tetrahedra).reshape(3, -1)
        folded: BoolArray = np.asarray(held.min(axis=0) <= _LEAST_VOLUME_M3)
        if not folded.any():
            return points, faces
        # A triangle on its own that has no volume has no area: nobody sees it.
        seen = ~(folded & alone)
        faces, alone, folded = faces[seen], alone[seen], folded[seen]
        corners = faces[folded].ravel()
        own = len(points) + np.arange(len(corners))
        faces[folded] = own.reshape(-1, 3)
        points = np.concatenate([points, points[corners]])
        alone |= folded


def with_inside(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Returns a skin's vertices (n, 3) and those of its inside, (2 n, 3), m."""
    # By facets, not by their areas: a large one must not turn a fold inside out.
    normals = vertex_normals(vertices, triangles, False)
    return np.concatenate([vertices, vertices - THICKNESS_M * normals])


def shell_tetrahedra(triangles: IntArray, count: int) -> IntArray:
    """Returns the (3 m, 4) tetrahedra between a skin and its inside.

    Args:
        triangles: (m, 3) indices into `count` vertices; inside, `count` is added.
        count: Of the skin's vertices.
    """
    # The lowest index first: then neighbours cut their common wall the same way.
    first = triangles.argmin(axis=1)
    row = np.arange(len(triangles))
    a, b, c = (triangles[row, (first + k) % 3] for k in range(3))
    A, B, C = a + count, b + count, c + count
    rising = (b < c)[:, None]
    top = np.where(rising, np.stack([a, c, b, C], 1), np.stack([a, c, b, B], 1))
    middle = np.where(rising, np.stack([a, C, b, B], 1), np.stack([a, B, C, c], 1))
    bottom = np.stack([a, B, A, C], axis=1)
    return np.concatenate([top, middle, bottom])


def volumes(points: FloatArray, tetrahedra: IntArray) -> FloatArray:
    """Returns the signed volumes (m,) of tetrahedra (m, 4), m^3."""
    a, b, c, d = (points[tetrahedra[:, k]] for k in range(4))
    return np.asarray((np.cross(b - a, c - a) * (d - a)).sum(axis=1) / 6.0)
