"""Colour, depth and labels of a scene of coloured surfaces."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bath_drake.notation import ByteArray, FloatArray
from bath_drake.perception.camera import PinholeCamera
from bath_drake.rendering._kernels import colour_in, find_nearest, place
from bath_drake.rendering.solids import subdivided
from bath_drake.rendering.surfaces import Surface, Surfaces

# Light is worked out at vertices: what stands still gets as many as it takes, m.
_LONGEST_EDGE_M = 0.15
# Of the display that colours are made for.
_GAMMA = 2.2
_SHADES = np.rint(255.0 * np.linspace(0.0, 1.0, 1025) ** (2.0 / _GAMMA)).astype(
    np.uint8
)
# As Drake labels what is no geometry.
NOTHING = 32766


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
        self._moving = Surfaces.of(moving)
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
        fine = [replace(s, shape=subdivided(s.shape, _LONGEST_EDGE_M)) for s in still]
        standing = Surfaces.of(fine)
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
        drawn: Surfaces,
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
            drawn.one_sided,
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


def _lights_in_camera(lights: Sequence[Light], R_CW: FloatArray) -> FloatArray:
    rows = np.empty((len(lights), 4))
    for row, light in zip(rows, lights, strict=True):
        towards = -np.asarray(light.direction) / np.linalg.norm(light.direction)
        row[:3] = towards if light.of_camera else R_CW @ towards
        row[3] = light.intensity
    return rows
