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
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ax, ay, az = vertices[a, 0], vertices[a, 1], vertices[a, 2]
        ux, uy, uz = vertices[b, 0] - ax, vertices[b, 1] - ay, vertices[b, 2] - az
        vx, vy, vz = vertices[c, 0] - ax, vertices[c, 1] - ay, vertices[c, 2] - az
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        if not by_area:
            scale = 1.0 / max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-15)
            nx, ny, nz = scale * nx, scale * ny, scale * nz
        for corner in (a, b, c):
            normals[corner, 0] += nx
            normals[corner, 1] += ny
            normals[corner, 2] += nz
    for n in range(len(normals)):
        nx, ny, nz = normals[n, 0], normals[n, 1], normals[n, 2]
        length = max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-12)
        normals[n, 0], normals[n, 1], normals[n, 2] = (
            nx / length,
            ny / length,
            nz / length,
        )
    return normals
