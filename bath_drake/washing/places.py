"""Places all over the true skin of a back, each of which stands for some area.

A mesh's triangles are wider than a jet: they are cut into equal small ones, whose
middles are the places. They are matter: while the person bends they go along.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bath_drake.notation import FloatArray, IntArray
from bath_drake.patient.people import LABEL_BACK
from bath_drake.patient.skin import TrueSkin

# Skin turned further away from behind than this (as a cosine) is no back to be washed.
_LEAST_COSINE = 0.2


@dataclass(frozen=True, eq=False)
class SkinPlaces:
    """n places on m triangles of a mesh.

    Attributes:
        triangles: (m, 3) vertices of the mesh.
        owner: (n,) the triangle that each place is on.
        weights: (n, 3) of that triangle's corners; rows of sum 1.
        areas: (n,) what each stands for, of the skin at rest, m^2.
        plane: (n, 2) at rest, in the plane of the true canonical map, m.
        p_N: (n, 2) the same in true canonical coordinates.
    """

    triangles: IntArray
    owner: IntArray
    weights: FloatArray
    areas: FloatArray
    plane: FloatArray
    p_N: FloatArray

    def __len__(self) -> int:
        """How many places there are."""
        return len(self.owner)

    def at(self, vertices: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where they are, and the outward normals there (of no unit length).

        Args:
            vertices: (v, 3) those of the mesh now, at rest or bent, in M, m.

        Returns:
            Points (n, 3), m, and normals (n, 3), those of the triangles.
        """
        corners = vertices[self.triangles]
        sides = corners[:, 1:] - corners[:, :1]
        normals = np.cross(sides[:, 0], sides[:, 1])
        points = np.einsum("nk,nkj->nj", self.weights, corners[self.owner])
        return points, normals[self.owner]

    @cached_property
    def area(self) -> float:
        """Of all places together, m^2."""
        return float(self.areas.sum())


def back_places(skin: TrueSkin, pitch: float) -> SkinPlaces:
    """Covers the back of a person with places.

    Args:
        skin: Of the person at rest.
        pitch: About the places' distance, m: each stands for at most its square.

    Raises:
        ValueError: Unless the pitch is positive.
    """
    if not pitch > 0.0:
        raise ValueError(f"pitch must be positive, got {pitch}")
    person = skin.person
    corners = person.vertices[person.triangles]
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(facets, axis=1)
    cosine = facets @ skin.canonical_map.normal_W
    back = (person.labels[person.triangles] == LABEL_BACK).any(axis=1)
    triangles = person.triangles[back & (cosine > _LEAST_COSINE * doubled)]
    corners = person.vertices[triangles]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(sides, axis=1)
    owner, weights, areas = [], [], []
    # Each place stands for at most a square of the pitch.
    cuts = np.maximum(np.ceil(np.sqrt(area) / pitch), 1.0).astype(int)
    for count in np.unique(cuts):
        of_one = _middles(int(count))
        chosen = np.flatnonzero(cuts == count)
        owner.append(np.repeat(chosen, len(of_one)))
        weights.append(np.tile(of_one, (len(chosen), 1)))
        areas.append(np.repeat(area[chosen] / len(of_one), len(of_one)))
    on, shares = np.concatenate(owner), np.concatenate(weights)
    points = np.einsum("nk,nkj->nj", shares, corners[on])
    plane = skin.canonical_map.plane_from_world(points)[:, :2]
    return SkinPlaces(
        triangles=triangles,
        owner=on,
        weights=shares,
        areas=np.concatenate(areas),
        plane=plane,
        p_N=plane / skin.canonical_map.half_extents,
    )


def _middles(count: int) -> FloatArray:
    """Barycentric middles (count^2, 3) of a triangle cut into equal small ones."""
    i, j = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    up = np.stack([i, j], axis=-1)[i + j <= count - 1] + 1.0 / 3.0
    down = np.stack([i, j], axis=-1)[i + j <= count - 2] + 2.0 / 3.0
    two = np.concatenate([up, down]) / count
    return np.column_stack([1.0 - two.sum(axis=1), two])
