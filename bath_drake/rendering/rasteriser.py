"""Colour, depth and labels of a scene of coloured surfaces."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add

import numpy as np
from numpy.typing import NDArray

from bath_drake.notation import ByteArray, FloatArray
from bath_drake.perception.camera import PinholeCamera
from bath_drake.rendering._kernels import colour_in, find_nearest, place
from bath_drake.rendering.normals import vertex_normals
from bath_drake.rendering.solids import Shape, subdivided

# Light is worked out at vertices: what stands still gets as many as it takes, m.
_LONGEST_EDGE_M = 0.15
# Of the display that colours are made for.
_GAMMA = 2.2
_SHADES = np.rint(255.0 * np.linspace(0.0, 1.0, 1025) ** (2.0 / _GAMMA)).astype(
    np.uint8
)
# As Drake labels what is no geometry.
NOTHING = 32766


@dataclass(frozen=True, eq=False)
class Surface:
    """A mesh of one colour.

    Attributes:
        shape: In the surface's own frame G, m.
        rgb: (3,) 0 to 1.
        label: In the label image.
        roughness: Of its gloss, 0 to 1.
    """

    shape: Shape
    rgb: FloatArray
    label: int
    roughness: float = 0.5


@dataclass(frozen=True)
class Light:
    """One from far away, white.

    Attributes:
        direction: (3,) in which it shines; any length.
        intensity: Of the light.
        of_camera: Whether its direction is in the camera's frame C, not in W.
    """

    direction: tuple[float, float, float]
    intensity: float
    of_camera: bool = False


@dataclass(frozen=True, eq=False)
class Picture:
    """What a camera sees.

    Attributes:
        colour: (H, W, 4) red, green, blue, opacity.
        depth: (H, W) m along the optical axis; 0 where it is too near to be told, inf
            where it is too far or there is nothing.
        label: (H, W) of the surfaces; `NOTHING` where there is none.
    """

    colour: ByteArray
    depth: NDArray[np.float32]
    label: NDArray[np.int16]


class Rasteriser:
    """Draws surfaces before one camera that stands still.

    Of what stands still too, the picture is made once.
    """

    def __init__(
        self,
        *,
        camera: PinholeCamera,
        X_WC: FloatArray,
        clipping: tuple[float, float],
        depth_range: tuple[float, float] = (0.0, np.inf),
        lights: Sequence[Light],
        background: FloatArray,
        still: Sequence[Surface] = (),
        moving: Sequence[Surface] = (),
    ) -> None:
        """Draws what stands still.

        Args:
            camera: Without distortion.
            X_WC: (4, 4) its pose.
            clipping: Depths between which anything is seen, m, both positive.
            depth_range: The nearest and farthest depth that is told, m.
            lights: Of the scene.
            background: (3,) colour where there is nothing, 0 to 1.
            still: Surfaces in W.
            moving: Surfaces whose poses come with each picture.

        Raises:
            ValueError: If a clipping depth, a surface or the pose is out of range.
        """
        near, far = clipping
        if not 0.0 < near < far < np.inf:
            raise ValueError(f"clipping must be 0 < near < far, got {clipping}")
        if X_WC.shape != (4, 4) or not np.isfinite(X_WC).all():
            raise ValueError(f"X_WC must be a finite (4, 4) pose, got {X_WC!r:.80}")
        self._near, self._told = near, depth_range
        self._X_CW: FloatArray = np.linalg.inv(X_WC).astype(np.float64)
        self._lens = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
        self._lights_C = _lights_in_camera(lights, self._X_CW[:3, :3])
        self._moving = _Drawn(moving)
        self._behind = Picture(
            np.empty((*camera.shape, 4), dtype=np.uint8),
            np.full(camera.shape, np.inf, dtype=np.float32),
            np.full(camera.shape, NOTHING, dtype=np.int16),
        )
        self._behind.colour[:] = [*np.rint(255.0 * np.asarray(background)), 255]
        self._inverse_depth = np.full(camera.shape, 1.0 / far)
        # Written before every use: they remember nothing.
        self._scratch = np.empty(camera.shape)
        self._faces = np.empty(camera.shape, dtype=np.int32)
        fine = [
            Surface(subdivided(s.shape, _LONGEST_EDGE_M), s.rgb, s.label, s.roughness)
            for s in still
        ]
        standing = _Drawn(fine)
        poses = np.broadcast_to(np.eye(4)[:3], (len(fine), 3, 4))
        self._draw(standing, poses, self._inverse_depth, self._behind)

    def picture(
        self, X_WG: FloatArray, bent: Mapping[int, FloatArray] | None = None
    ) -> Picture:
        """Returns what the camera sees now.

        Args:
            X_WG: (k, 3, 4) poses of the moving surfaces.
            bent: By a moving surface's index, its vertices (n, 3) now, in its frame:
                of one that bends.
        """
        drawn = self._moving.bent(bent) if bent else self._moving
        picture = Picture(
            self._behind.colour.copy(),
            self._behind.depth.copy(),
            self._behind.label.copy(),
        )
        np.copyto(self._scratch, self._inverse_depth)
        self._draw(drawn, X_WG, self._scratch, picture)
        return picture

    def _draw(
        self,
        drawn: "_Drawn",
        X_WG: FloatArray,
        inverse_depth: FloatArray,
        picture: Picture,
    ) -> None:
        if not len(drawn.triangles):
            return
        X_CG = self._X_CW[:3, :3] @ X_WG
        X_CG[:, :, 3] += self._X_CW[:3, 3]
        points_C = np.empty_like(drawn.vertices)
        pixels, lit = np.empty((2, len(drawn.owner), 2))
        place(
            drawn.vertices,
            drawn.normals,
            drawn.owner,
            X_CG,
            drawn.roughness,
            self._lights_C,
            self._lens,
            points_C,
            pixels,
            lit,
        )
        faces = self._faces
        faces.fill(-1)
        find_nearest(
            points_C,
            pixels,
            drawn.triangles,
            self._lens,
            self._near,
            inverse_depth,
            faces,
        )
        colour_in(
            points_C,
            lit,
            drawn.triangles,
            drawn.owner,
            drawn.rgb,
            drawn.labels,
            self._lens,
            _SHADES,
            faces,
            picture.colour,
            picture.depth,
            picture.label,
            self._told,
        )


class _Drawn:
    """Many surfaces in one array of each kind."""

    def __init__(self, surfaces: Sequence[Surface]) -> None:
        nothing = Shape(
            np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)
        )
        for surface in surfaces:
            _check(surface)
        whole = reduce(add, (s.shape for s in surfaces), nothing)
        counts = [len(s.shape.vertices) for s in surfaces]
        self.vertices, self.normals = whole.vertices, whole.normals
        self.triangles = whole.triangles
        self.owner = np.repeat(np.arange(len(surfaces)), counts)
        self.rgb = np.array([s.rgb for s in surfaces], dtype=np.float64).reshape(-1, 3)
        self.labels = np.array([s.label for s in surfaces], dtype=np.int64)
        self.roughness = np.array([s.roughness for s in surfaces], dtype=np.float64)
        self._starts = np.cumsum([0, *counts])
        self._shapes = [s.shape for s in surfaces]

    def bent(self, vertices: Mapping[int, FloatArray]) -> "_Drawn":
        """The same surfaces, some with other vertices."""
        other = object.__new__(_Drawn)
        other.__dict__.update(self.__dict__)
        other.vertices, other.normals = self.vertices.copy(), self.normals.copy()
        for index, points in vertices.items():
            shape = self._shapes[index]
            if points.shape != shape.vertices.shape:
                raise ValueError(
                    f"surface {index}: found vertices {points.shape}, allowed "
                    f"{shape.vertices.shape}"
                )
            part = slice(self._starts[index], self._starts[index + 1])
            other.vertices[part] = points
            other.normals[part] = vertex_normals(points, shape.triangles, True)
        return other


def _check(surface: Surface) -> None:
    shape, rgb = surface.shape, np.asarray(surface.rgb)
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
    if not 0.0 < surface.roughness <= 1.0:
        raise ValueError(f"roughness must be in (0, 1], got {surface.roughness}")


def _lights_in_camera(lights: Sequence[Light], R_CW: FloatArray) -> FloatArray:
    rows = np.empty((len(lights), 4))
    for row, light in zip(rows, lights, strict=True):
        towards = -np.asarray(light.direction) / np.linalg.norm(light.direction)
        row[:3] = towards if light.of_camera else R_CW @ towards
        row[3] = light.intensity
    return rows
