"""A wound on the true skin: a thin patch and its outline.

Placed and drawn with the true mesh, so it belongs to the scene and to the
verification; the controller has to find it in the camera's image.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bath_drake.notation import FloatArray, IntArray
from bath_drake.patient.people import Person
from bath_drake.patient.skin import TrueSkin

# Fine enough to follow the folds between the mesh's triangles (about 25 mm).
_CELL_M = 0.004
# Above the skin by this much, so that the camera sees the patch, not the skin.
_LIFT_M = 0.0008
_OUTLINE_POINTS = 96

# Red, green, blue, 0 to 1, of a scab.
DARK = (0.05, 0.03, 0.03)


@dataclass(frozen=True, eq=False)
class WoundPatch:
    """A patch on the skin, in frame M.

    Attributes:
        vertices: (n, 3) m, just above the skin.
        normals: (n, 3) unit, out of the body.
        triangles: (m, 3) vertex indices.
        outline: (k, 3) m, its boundary on the skin, closed implicitly.
        colour: (3,) red, green, blue, 0 to 1.
    """

    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray
    outline: FloatArray
    colour: FloatArray


def wound_patch(
    person: Person,
    centre: FloatArray,
    semi_axes: FloatArray,
    angle: float,
    colour: Sequence[float] = DARK,
) -> WoundPatch:
    """Lays an ellipse of the true canonical plane on the skin.

    Args:
        person: Whose back.
        centre: (2,) in true canonical coordinates (`TrueSkin.canonical_map`).
        semi_axes: (2,) in true canonical coordinates.
        angle: Of the first semi-axis, rad, counter-clockwise.
        colour: Red, green, blue, 0 to 1.

    Raises:
        ValueError: If part of the ellipse would hang beside the back.
    """
    skin = TrueSkin(person)
    size = 2.0 * np.max(semi_axes) * skin.canonical_map.half_extents.max()
    rings = max(4, int(np.ceil(size / 2.0 / _CELL_M)))
    radii = np.linspace(0.0, 1.0, rings + 1)[1:]
    turns = np.linspace(0.0, 2.0 * np.pi, _OUTLINE_POINTS, endpoint=False)
    circle = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    disc = np.vstack([np.zeros((1, 2)), *(r * circle for r in radii)])
    c, s = np.cos(angle), np.sin(angle)
    p_N = centre + (disc * semi_axes) @ np.array([[c, s], [-s, c]])
    points, met = skin.under(p_N)
    if not met.all() or not skin.on_back(points).all():
        raise ValueError(
            f"the wound at {np.asarray(centre).tolist()} with semi-axes"
            f" {np.asarray(semi_axes).tolist()} does not lie on the back"
        )
    _, _, normals = skin.nearest(points)
    return WoundPatch(
        vertices=points + _LIFT_M * normals,
        normals=normals,
        triangles=_disc_triangles(rings, _OUTLINE_POINTS),
        outline=points[-_OUTLINE_POINTS:],
        colour=np.array(colour),
    )


def signed_polygon_distance(points: FloatArray, polygon: FloatArray) -> FloatArray:
    """Distance (n,) of points (n, 2) to a simple polygon (m, 2); negative inside."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    edge = end - start
    offset = points[:, None, :] - start
    share = (offset * edge).sum(axis=2) / np.maximum((edge**2).sum(axis=1), 1e-300)
    nearest = offset - np.clip(share, 0.0, 1.0)[:, :, None] * edge
    distance = np.sqrt((nearest**2).sum(axis=2)).min(axis=1)
    # Even-odd rule: a ray to the right crosses the outline an odd number of times.
    x, y = points[:, :1], points[:, 1:]
    straddles = (start[:, 1] > y) != (end[:, 1] > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = start[:, 0] + (y - start[:, 1]) * edge[:, 0] / edge[:, 1]
    inside = (straddles & (x < crossing)).sum(axis=1) % 2 == 1
    return np.asarray(np.where(inside, -distance, distance))


def _disc_triangles(rings: int, n: int) -> IntArray:
    """Triangles of a centre vertex and `rings` rings of `n` vertices each."""
    k = np.arange(n)
    following = (k + 1) % n
    # Counter-clockwise as seen from outside: they face out of the body.
    triangles = [np.stack([np.zeros(n, dtype=int), 1 + k, 1 + following], axis=1)]
    for ring in range(1, rings):
        inner, outer = 1 + (ring - 1) * n, 1 + ring * n
        triangles.append(np.stack([inner + k, outer + k, outer + following], axis=1))
        triangles.append(
            np.stack([inner + k, outer + following, inner + following], axis=1)
        )
    return np.vstack(triangles).astype(np.int64)
