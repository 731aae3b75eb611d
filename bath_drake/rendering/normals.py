"""Normals of a triangle mesh at its vertices, compiled."""

import numpy as np
from numba import njit

from bath_drake.notation import FloatArray, IntArray


@njit(cache=True)
def vertex_normals(
    vertices: FloatArray, triangles: IntArray, by_area: bool
) -> FloatArray:
    """Returns unit normals (n, 3), the means of those of the triangles around.

    Args:
        vertices: (n, 3) m.
        triangles: (m, 3) indices, counter-clockwise from outside.
        by_area: Whether large triangles count for more.

    Returns:
        Zero at vertices of no triangle, and where the triangles' normals cancel.
    """
    normals = np.zeros_like(vertices)
    facet = np.empty(3)
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            facet[k] = (vertices[b, i] - vertices[a, i]) * (
                vertices[c, j] - vertices[a, j]
            ) - (vertices[b, j] - vertices[a, j]) * (vertices[c, i] - vertices[a, i])
        scale = 1.0
        if not by_area:
            scale = 1.0 / max(np.sqrt((facet * facet).sum()), 1e-15)
        for corner in (a, b, c):
            for k in range(3):
                normals[corner, k] += scale * facet[k]
    for n in range(len(normals)):
        length = np.sqrt((normals[n] * normals[n]).sum())
        normals[n] /= max(length, 1e-12)
    return normals
