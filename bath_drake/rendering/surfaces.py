"""Coloured meshes, one by one and all in arrays."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from typing import Self

import numpy as np

from bath_drake.notation import BoolArray, FloatArray, IntArray
from bath_drake.rendering.normals import vertex_normals
from bath_drake.rendering.solids import Shape


@dataclass(frozen=True, eq=False)
class Surface:
    """A mesh of one colour.

    Attributes:
        shape: In the surface's own frame G, m.
        rgb: (3,) 0 to 1.
        label: In the label image.
        roughness: Of its gloss, more than 0 to 1.
        one_sided: Whether nobody sees it from behind: of a solid, or of a skin.

    Raises:
        ValueError: If any of that is out of range.
    """

    shape: Shape
    rgb: FloatArray
    label: int
    roughness: float = 0.5
    one_sided: bool = False

    def __post_init__(self) -> None:
        """Checks shape and look."""
        shape, rgb = self.shape, np.asarray(self.rgb)
        n = len(shape.vertices)
        if shape.vertices.shape != (n, 3) or shape.normals.shape != (n, 3):
            raise ValueError(
                f"vertices and normals must be (n, 3), got {shape.vertices.shape} and "
                f"{shape.normals.shape}"
            )
        if not (np.isfinite(shape.vertices).all() and np.isfinite(shape.normals).all()):
            raise ValueError("vertices and normals must be finite")
        low, high = shape.triangles.min(initial=0), shape.triangles.max(initial=-1)
        if low < 0 or high >= n:
            raise ValueError(f"triangles must be 0 to {n - 1}, got {low} to {high}")
        if rgb.shape != (3,) or not ((rgb >= 0.0) & (rgb <= 1.0)).all():
            raise ValueError(f"rgb must be three of 0 to 1, got {rgb}")
        if not 0.0 < self.roughness <= 1.0:
            raise ValueError(f"roughness must be in (0, 1], got {self.roughness}")


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Many surfaces in one array of each kind.

    Attributes:
        vertices: (n, 3) m, each in its own surface's frame.
        normals: (n, 3) unit, likewise.
        triangles: (m, 3) vertex indices.
        one_sided: (m,) of each triangle's surface.
        owner: (n,) index of each vertex's surface.
        starts: (k + 1,) index of each surface's first vertex, and n.
        rgb: (k, 3) 0 to 1.
        labels: (k,) in the label image.
        roughness: (k,) 0 to 1.
        shapes: (k,) as they were given.
    """

    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray
    one_sided: BoolArray
    owner: IntArray
    starts: IntArray
    rgb: FloatArray
    labels: IntArray
    roughness: FloatArray
    shapes: tuple[Shape, ...]

    @classmethod
    def of(cls, surfaces: Sequence[Surface]) -> Self:
        """Packs surfaces, in their order."""
        shapes = tuple(surface.shape for surface in surfaces)
        no_index: IntArray = np.empty((0, 3), dtype=np.int64)
        whole = reduce(add, shapes, Shape(np.empty((0, 3)), np.empty((0, 3)), no_index))
        counts = [len(shape.vertices) for shape in shapes]
        return cls(
            vertices=whole.vertices,
            normals=whole.normals,
            triangles=whole.triangles,
            one_sided=np.repeat(
                np.array([s.one_sided for s in surfaces], dtype=np.bool_),
                [len(shape.triangles) for shape in shapes],
            ),
            owner=np.repeat(np.arange(len(shapes)), counts),
            starts=np.cumsum([0, *counts]),
            rgb=np.array([s.rgb for s in surfaces], dtype=np.float64).reshape(-1, 3),
            labels=np.array([s.label for s in surfaces], dtype=np.int64),
            roughness=np.array([s.roughness for s in surfaces], dtype=np.float64),
            shapes=shapes,
        )

    def bent(self, vertices: Mapping[int, FloatArray]) -> Self:
        """Returns the same surfaces, some with other vertices.

        Args:
            vertices: (n, 3) m, by the surface's index.

        Raises:
            ValueError: If there are more or fewer than there were; names the surface.
        """
        points, normals = self.vertices.copy(), self.normals.copy()
        for index, given in vertices.items():
            shape = self.shapes[index]
            if given.shape != shape.vertices.shape:
                raise ValueError(
                    f"surface {index}: found vertices {given.shape}, allowed "
                    f"{shape.vertices.shape}"
                )
            part = slice(self.starts[index], self.starts[index + 1])
            points[part] = given
            normals[part] = vertex_normals(given, shape.triangles, True)
        return replace(self, vertices=points, normals=normals)
