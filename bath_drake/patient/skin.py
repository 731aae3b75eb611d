"""The true skin: distances, normals and places on it.

For the scene and the verification alone. Nothing in the loop may import this
module: what the robot knows of the person comes from the camera.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import open3d as o3d
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from bath_drake.notation import BoolArray, FloatArray, IntArray
from bath_drake.patient.people import LABEL_BACK, Person
from bath_drake.perception.canonical import CanonicalMap, fit_canonical_map
from bath_drake.rendering.normals import vertex_normals

# Higher above the back's plane than any skin of it, m.
_ABOVE_M = 0.5


def _tensor(array: Any, kind: Any = np.float32) -> Any:
    core: Any = o3d.core  # its stubs know nothing of numpy
    return core.Tensor(np.ascontiguousarray(array, dtype=kind))


@dataclass(frozen=True, eq=False)
class TrueSkin:
    """Queries on a person's true mesh; all points and normals in frame M, metres.

    Attributes:
        person: Whose mesh it is.
        bent: (n, 3) where its vertices are while the person bends; None for at rest.
        triangles: (m, 3) those that are looked at; None for all.
    """

    person: Person
    bent: FloatArray | None = None
    triangles: IntArray | None = None

    @property
    def vertices(self) -> FloatArray:
        """The mesh's (n, 3) as they are, bent or at rest, m."""
        return self._mesh[0]

    @property
    def _mesh(self) -> tuple[FloatArray, IntArray]:
        person = self.person
        vertices = person.vertices if self.bent is None else self.bent
        return vertices, person.triangles if self.triangles is None else self.triangles

    @cached_property
    def _scene(self) -> Any:
        scene: Any = o3d.t.geometry.RaycastingScene()
        vertices, triangles = self._mesh
        scene.add_triangles(_tensor(vertices), _tensor(triangles, np.uint32))
        return scene

    @cached_property
    def _vertex_normals(self) -> FloatArray:
        # Area-weighted, so that a facet's size does not bend the normal.
        return np.asarray(vertex_normals(*self._mesh, True))

    def _normals_at(self, triangles: IntArray, uvs: FloatArray) -> FloatArray:
        corners, weights = self._corners(triangles, uvs)
        normals = (self._vertex_normals[corners] * weights[:, :, None]).sum(axis=1)
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        return np.asarray(normals / np.maximum(lengths, 1e-12))

    def nearest(self, p_MQ: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Finds the skin nearest to points (n, 3).

        Returns:
            Distances (n,), the nearest points (n, 3) and the smooth outward
            normals there (n, 3).
        """
        found = self._scene.compute_closest_points(_tensor(p_MQ))
        points = found["points"].numpy().astype(np.float64)
        normals = self._normals_at(
            found["primitive_ids"].numpy(), found["primitive_uvs"].numpy()
        )
        return np.linalg.norm(p_MQ - points, axis=1), points, normals

    def hit(
        self, p_MQ: FloatArray, direction_M: FloatArray
    ) -> tuple[FloatArray, BoolArray]:
        """Follows rays (n, 3) to the skin: points (n, 3), and whether they meet it."""
        distance = self._cast(p_MQ, direction_M)["t_hit"].numpy()
        met = np.isfinite(distance)
        reach = np.where(met, distance, 0.0)[:, None]
        return p_MQ + reach * direction_M, met

    def _cast(self, p_MQ: FloatArray, direction_M: FloatArray) -> Any:
        rays = _tensor(np.concatenate([p_MQ, direction_M], axis=1))
        return self._scene.cast_rays(rays)

    def struck(
        self, p_MQ: FloatArray, direction_M: FloatArray
    ) -> tuple[IntArray, FloatArray, BoolArray]:
        """Follows rays (n, 3) to the skin, as matter that may move.

        Returns:
            Vertices (n, 3) and weights (n, 3) as of `bind`, and whether there is any
            skin, (n,); where there is none, the first two say nothing.
        """
        found = self._cast(p_MQ, direction_M)
        met = np.isfinite(found["t_hit"].numpy())
        chosen = np.where(met, found["primitive_ids"].numpy(), 0).astype(np.int64)
        return *self._corners(chosen, found["primitive_uvs"].numpy()), met

    def _corners(self, triangles: IntArray, uvs: Any) -> tuple[IntArray, FloatArray]:
        uvs = uvs.astype(np.float64)
        weights = np.column_stack([1.0 - uvs.sum(axis=1), uvs])
        return self._mesh[1][triangles], weights

    def on_back(self, p_MQ: FloatArray) -> BoolArray:
        """Whether points (n, 3) lie nearest to triangles of the back: (n,)."""
        found = self._scene.compute_closest_points(_tensor(p_MQ))
        triangles = self._mesh[1][found["primitive_ids"].numpy()]
        return np.asarray((self.person.labels[triangles] == LABEL_BACK).any(axis=1))

    def bind(self, p_MQ: FloatArray) -> tuple[IntArray, FloatArray]:
        """Finds what skin points (n, 3) are nearest to, as matter that may move.

        Returns:
            (n, 3) indices of the mesh's vertices, and (n, 3) their weights, rows of
            sum 1: the nearest points are the vertices' weighted means.
        """
        found = self._scene.compute_closest_points(_tensor(p_MQ))
        return self._corners(
            found["primitive_ids"].numpy(), found["primitive_uvs"].numpy()
        )

    def under(self, p_N: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Finds the skin under true canonical points (n, 2), seen along the normal.

        Returns:
            Points (n, 3) on the skin, and whether there is skin at all, (n,).
        """
        outward = self.canonical_map.normal_W
        above = self.canonical_map.world_from_canonical(p_N) + _ABOVE_M * outward
        return self.hit(above, np.broadcast_to(-outward, above.shape))

    @cached_property
    def canonical_map(self) -> CanonicalMap:
        """The canonical map of the labelled back at rest, in M for W."""
        v, f = self.person.vertices, self.person.triangles
        facets = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
        on_back = _largest_piece(f, (self.person.labels[f] == LABEL_BACK).all(axis=1))
        return fit_canonical_map(
            v[f[on_back]].mean(axis=1),
            up_W=np.array([0.0, 0.0, 1.0]),
            eye_W=v.mean(axis=0) + np.array([0.0, 10.0, 0.0]),
            weights=np.linalg.norm(facets[on_back], axis=1),
        )


def _largest_piece(triangles: IntArray, chosen: BoolArray) -> BoolArray:
    """Of the chosen triangles, those of the piece with the most of them."""
    f = triangles[chosen]
    count = int(triangles.max()) + 1
    edges = np.concatenate([f[:, [0, 1]], f[:, [1, 2]]])
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), (count, count))
    _, piece = connected_components(graph, directed=False)
    largest = np.bincount(piece[f[:, 0]]).argmax()
    return np.asarray(chosen & (piece[triangles[:, 0]] == largest))
