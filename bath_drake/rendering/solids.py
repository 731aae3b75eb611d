"""Simple solids as meshes of few triangles."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from bath_drake.notation import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Shape:
    """A mesh with a normal at every vertex.

    Attributes:
        vertices: (n, 3) m.
        normals: (n, 3) unit, outward.
        triangles: (m, 3) vertex indices, counter-clockwise from outside.
    """

    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray

    def __add__(self, other: "Shape") -> "Shape":
        """Both in one mesh."""
        return Shape(
            np.vstack([self.vertices, other.vertices]),
            np.vstack([self.normals, other.normals]),
            np.vstack([self.triangles, other.triangles + len(self.vertices)]),
        )


def ellipsoid(
    centre: Any, semi_axes: Any, *, around: int = 16, rings: int = 9
) -> Shape:
    """An ellipsoid along the axes.

    Args:
        centre: (3,) m.
        semi_axes: (3,) m.
        around: Vertices of a ring.
        rings: Of vertices from pole to pole, odd.
    """
    sphere, triangles = _sphere(around, rings)
    axes = np.asarray(semi_axes, dtype=np.float64)
    normals = sphere / axes
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Shape(np.asarray(centre) + sphere * axes, normals, triangles)


def capsule(
    start: Any, end: Any, radius: float, *, around: int = 16, rings: int = 9
) -> Shape:
    """A cylinder with round ends about the points start and end (3,), m."""
    start, end = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    sphere, triangles = _sphere(around, rings)
    z = (end - start) / np.linalg.norm(end - start)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    normals = sphere @ np.array([x, np.cross(z, x), z])
    # The sphere pulled apart at its equator's ring.
    ends = np.where(sphere[:, 2:] > 0.0, end, start)
    return Shape(ends + radius * normals, normals, triangles)


def cylinder(radius: float, length: float, *, around: int = 48) -> Shape:
    """A cylinder about z, its middle at the origin, m."""
    turn = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    outward = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(around)])
    half = np.array([0.0, 0.0, 0.5 * length])
    rims = [radius * outward - half, radius * outward + half]
    k = np.arange(around)
    after = (k + 1) % around
    side = np.vstack(
        [
            np.column_stack([k, after, after + around]),
            np.column_stack([k, after + around, k + around]),
        ]
    )
    solid = Shape(np.vstack(rims), np.vstack([outward, outward]), side)
    for sign, rim in ((-1.0, rims[0]), (1.0, rims[1])):
        fan = np.column_stack([np.full(around, around), k, after][:: int(sign)])
        normals = np.tile([0.0, 0.0, sign], (around + 1, 1))
        solid += Shape(np.vstack([rim, sign * half]), normals, fan)
    return solid


def box(size: Any) -> Shape:
    """A box (3,) along the axes, its middle at the origin, m."""
    low = -0.5 * np.asarray(size, dtype=np.float64)
    solid = None
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1.0, 1.0):
            corners = np.tile(low, (4, 1))
            corners[:, axis] *= -sign
            corners[[1, 2], u] *= -1.0
            corners[[2, 3], v] *= -1.0
            square = np.array([[0, 1, 2], [0, 2, 3]])[:, :: int(sign)]
            normal = np.zeros((4, 3))
            normal[:, axis] = sign
            face = Shape(corners, normal, square)
            solid = face if solid is None else solid + face
    assert solid is not None
    return solid


def faceted(vertices: FloatArray, triangles: IntArray) -> Shape:
    """A mesh whose every triangle is flat and has its own three vertices.

    Args:
        vertices: (n, 3) m.
        triangles: (m, 3) indices, counter-clockwise from outside.
    """
    corners = np.asarray(vertices, dtype=np.float64)[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(across, axis=1, keepdims=True)
    flat = across / np.maximum(length, 1e-300)
    own = np.arange(3 * len(triangles)).reshape(-1, 3)
    return Shape(corners.reshape(-1, 3), np.repeat(flat, 3, axis=0), own)


def is_solid(shape: Shape) -> bool:
    """Returns whether a mesh is closed and its triangles counter-clockwise outside."""
    places, corners = np.unique(shape.vertices.round(9), axis=0, return_inverse=True)
    triangles = corners.reshape(-1)[shape.triangles]
    a, b, c = triangles.T
    there = np.concatenate([a, b, c]) * len(places) + np.concatenate([b, c, a])
    back = np.concatenate([b, c, a]) * len(places) + np.concatenate([a, b, c])
    p, q, r = (places[k] for k in (a, b, c))
    volume = (np.cross(p, q) * r).sum()
    # Each edge once in either direction.
    return bool(volume > 0.0 and np.array_equal(np.sort(there), np.sort(back)))


def subdivided(shape: Shape, longest: float) -> Shape:
    """Returns the same mesh, no edge longer than `longest`, m, which is positive."""
    while True:
        corners = shape.vertices[shape.triangles]
        edges = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
        if edges.max(initial=0.0) <= longest:
            return shape
        normals = shape.normals[shape.triangles]
        middles, between = (
            0.5 * (of + np.roll(of, -1, axis=1)) for of in (corners, normals)
        )
        length = np.linalg.norm(between, axis=2, keepdims=True)
        between = between / np.maximum(length, 1e-300)
        n = len(corners)
        a, b, c, ab, bc, ca = np.arange(6 * n).reshape(n, 6).T
        shape = Shape(
            np.concatenate([corners, middles], axis=1).reshape(-1, 3),
            np.concatenate([normals, between], axis=1).reshape(-1, 3),
            np.concatenate(
                [
                    np.column_stack(t)
                    for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
                ]
            ),
        )


def _sphere(around: int, rings: int) -> tuple[FloatArray, IntArray]:
    """Vertices and triangles of a unit sphere, poles on z, the equator doubled."""
    half = np.linspace(0.0, np.pi / 2, rings // 2 + 1)
    # Rings just above and below the equator, so that a capsule has a cylinder.
    polar = np.r_[half[:-1], np.pi / 2 - 1e-9, np.pi / 2 + 1e-9, np.pi - half[-2::-1]]
    turn = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    p, a = np.meshgrid(polar, turn, indexing="ij")
    vertices = np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)], -1)
    k, rows = np.arange(around), np.arange(len(polar) - 1)[:, None] * around
    here, right = rows + k, rows + (k + 1) % around
    lower = np.stack([here, here + around, right + around], -1)
    upper = np.stack([here, right + around, right], -1)
    triangles = np.vstack([lower.reshape(-1, 3), upper.reshape(-1, 3)])
    return vertices.reshape(-1, 3), triangles.astype(np.int64)
