"""The carer's limbs as meshes of few triangles: each one is drawn in every frame."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from bath_drake.carer.arm import FOREARM, GRIP, HAND, UPPER_ARM
from bath_drake.notation import FloatArray, IntArray

_ROUND, _RINGS = 16, 9


@dataclass(frozen=True, eq=False)
class Shape:
    """A closed mesh.

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


def ellipsoid(centre: Any, semi_axes: Any) -> Shape:
    """An ellipsoid along the axes: centre (3,), semi-axes (3,), m."""
    sphere, triangles = _sphere()
    axes = np.asarray(semi_axes, dtype=np.float64)
    normals = sphere / axes
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Shape(np.asarray(centre) + sphere * axes, normals, triangles)


def capsule(start: Any, end: Any, radius: float) -> Shape:
    """A cylinder with round ends about the points start and end (3,), m."""
    start, end = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    sphere, triangles = _sphere()
    z = (end - start) / np.linalg.norm(end - start)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    normals = sphere @ np.array([x, np.cross(z, x), z])
    # The sphere pulled apart at its equator's ring.
    ends = np.where(sphere[:, 2:] > 0.0, end, start)
    return Shape(ends + radius * normals, normals, triangles)


def _sphere() -> tuple[FloatArray, IntArray]:
    """Vertices and triangles of a unit sphere, poles on z, the equator doubled."""
    half = np.linspace(0.0, np.pi / 2, _RINGS // 2 + 1)
    # Rings just above and below the equator, so that a capsule has a cylinder.
    polar = np.r_[half[:-1], np.pi / 2 - 1e-9, np.pi / 2 + 1e-9, np.pi - half[-2::-1]]
    turn = np.linspace(0.0, 2.0 * np.pi, _ROUND, endpoint=False)
    p, a = np.meshgrid(polar, turn, indexing="ij")
    vertices = np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)], -1)
    k, rows = np.arange(_ROUND), np.arange(len(polar) - 1)[:, None] * _ROUND
    here, right = rows + k, rows + (k + 1) % _ROUND
    lower = np.stack([here, here + _ROUND, right + _ROUND], -1)
    upper = np.stack([here, right + _ROUND, right], -1)
    triangles = np.vstack([lower.reshape(-1, 3), upper.reshape(-1, 3)])
    return vertices.reshape(-1, 3), triangles.astype(np.int64)


def limbs(marker_radius: float) -> dict[str, dict[str, Shape]]:
    """Returns the meshes of each of `bath_drake.carer.arm.PARTS`, by colour.

    The marker's ball is not among them. The colours are `skin`, `sleeve` and `stick`;
    each mesh is in its part's frame.
    """
    hand = ellipsoid([0.62 * HAND, 0.0, 0.008], [0.052, 0.041, 0.019])
    for knuckle, joint, tip in _fingers():
        hand += capsule(knuckle, joint, 0.0095) + capsule(joint, tip, 0.0085)
    forearm = capsule([0, 0, 0], [0, 0, 0.5 * FOREARM], 0.027)
    forearm += ellipsoid([0, 0, 0.58 * FOREARM], [0.041, 0.046, 0.55 * FOREARM])
    forearm += ellipsoid([0, 0, FOREARM], [0.041, 0.041, 0.041])
    cuff = [0, 0, 0.35 * UPPER_ARM]
    head = capsule([0.17, 0, 0], [0.17, 0, 0.12], 0.055)
    head += ellipsoid([0.17, 0, 0.22], [0.075, 0.095, 0.115])
    return {
        "marker": {
            "stick": capsule([0, 0, marker_radius], [0, 0, GRIP + 0.06], 0.0055)
        },
        "hand": {"skin": hand},
        "forearm": {"skin": forearm},
        "upper_arm": {
            "skin": capsule([0, 0, 0], cuff, 0.043),
            "sleeve": capsule(cuff, [0, 0, UPPER_ARM], 0.062),
        },
        "trunk": {
            "skin": head,
            "sleeve": ellipsoid([0.17, 0, -0.22], [0.21, 0.13, 0.32]),
        },
    }


def _fingers() -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Knuckle, middle joint and tip of each finger, curled about the stick."""
    fingers = []
    for y in (-0.028, -0.010, 0.009, 0.027):
        knuckle = np.array([0.040, y, 0.016])
        joint = np.array([0.006, 0.75 * y, 0.027 - 0.2 * abs(y)])
        fingers.append((knuckle, joint, np.array([-0.010, 0.45 * y, 0.002])))
    thumb = [0.070, 0.034, -0.006], [0.034, 0.032, -0.014], [0.000, 0.010, -0.012]
    return [*fingers, (np.array(thumb[0]), np.array(thumb[1]), np.array(thumb[2]))]
