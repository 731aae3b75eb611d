"""A wound on the true skin: a thin dark patch and its outline.

Placed and drawn with the true mesh, so it belongs to the scene and to the
verification; the controller has to find it in the camera's image.
"""

from dataclasses import dataclass

import numpy as np

from bath_drake.notation import FloatArray, IntArray
from bath_drake.scene.people import LABEL_BACK, Person

# Fine enough to follow the folds between the mesh's triangles (about 25 mm).
_CELL_M = 0.004
# Above the skin by this much, so that the camera sees the patch, not the skin.
_LIFT_M = 0.0008
_OUTLINE_POINTS = 96


@dataclass(frozen=True, eq=False)
class WoundPatch:
    """A patch on the skin, in frame M.

    Attributes:
        vertices: (n, 3) m, just above the skin.
        normals: (n, 3) unit, out of the body.
        triangles: (m, 3) vertex indices.
        outline: (k, 3) m, its boundary on the skin, closed implicitly.
    """

    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray
    outline: FloatArray


def back_point(person: Person, p_N: FloatArray) -> FloatArray:
    """Returns true skin points (..., 3) in M at true canonical points (..., 2).

    True canonical coordinates span the 1-99 % extents of the back's vertices in M:
    x to the person's right (-x of M), y to the head (z of M), projected along y.
    The points' y is NaN where there is no skin.
    """
    p_N = np.asarray(p_N, dtype=np.float64)
    low, high = person.back_extents
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    x = middle[0] - half[0] * p_N[..., 0]
    z = middle[2] + half[2] * p_N[..., 1]
    points, _ = _skin_under(person, np.stack([x.ravel(), z.ravel()], axis=1))
    return points.reshape(*p_N.shape[:-1], 3)


def wound_patch(
    person: Person, centre: FloatArray, semi_axes: FloatArray, angle: float
) -> WoundPatch:
    """Lays an ellipse of the true canonical plane on the skin.

    Args:
        person: Whose back.
        centre: (2,) in true canonical coordinates (see `back_point`).
        semi_axes: (2,) in true canonical coordinates.
        angle: Of the first semi-axis, rad, counter-clockwise.

    Raises:
        ValueError: If part of the ellipse would hang beside the back.
    """
    low, high = person.back_extents
    half = (high - low)[[0, 2]] / 2.0
    size = 2.0 * np.max(semi_axes) * half.max()
    rings = max(4, int(np.ceil(size / 2.0 / _CELL_M)))
    radii = np.linspace(0.0, 1.0, rings + 1)[1:]
    turns = np.linspace(0.0, 2.0 * np.pi, _OUTLINE_POINTS, endpoint=False)
    circle = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    disc = np.vstack([np.zeros((1, 2)), *(r * circle for r in radii)])
    c, s = np.cos(angle), np.sin(angle)
    p_N = centre + (disc * semi_axes) @ np.array([[c, s], [-s, c]])
    middle = ((low + high) / 2.0)[[0, 2]]
    columns = middle + p_N * half * [-1.0, 1.0]
    points, triangle = _skin_under(person, columns)
    if not np.isfinite(points).all() or not _on_back(person, triangle).all():
        raise ValueError(
            f"the wound at {np.asarray(centre).tolist()} with semi-axes"
            f" {np.asarray(semi_axes).tolist()} does not lie on the back"
        )
    normals = _vertex_normals(person)[person.triangles[triangle]].mean(axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return WoundPatch(
        vertices=points + _LIFT_M * normals,
        normals=normals,
        triangles=_disc_triangles(rings, _OUTLINE_POINTS),
        outline=points[-_OUTLINE_POINTS:],
    )


def _disc_triangles(rings: int, n: int) -> IntArray:
    """Triangles of a centre vertex and `rings` rings of `n` vertices each."""
    k = np.arange(n)
    following = (k + 1) % n
    # x of N runs against x of M: this order makes them face out of the body.
    triangles = [np.stack([np.zeros(n, dtype=int), 1 + k, 1 + following], axis=1)]
    for ring in range(1, rings):
        inner, outer = 1 + (ring - 1) * n, 1 + ring * n
        triangles.append(np.stack([inner + k, outer + k, outer + following], axis=1))
        triangles.append(
            np.stack([inner + k, outer + following, inner + following], axis=1)
        )
    return np.vstack(triangles).astype(np.int64)


def _skin_under(person: Person, columns: FloatArray) -> tuple[FloatArray, IntArray]:
    """Returns the hindmost skin point (n, 3) at each (x, z), and its triangle."""
    corners = person.vertices[person.triangles]
    flat = corners[:, :, [0, 2]]
    low, high = columns.min(axis=0), columns.max(axis=0)
    near = ((flat.min(axis=1) <= high) & (flat.max(axis=1) >= low)).all(axis=1)
    index = np.flatnonzero(near)
    points = np.column_stack(
        [columns[:, 0], np.full(len(columns), np.nan), columns[:, 1]]
    )
    hit = np.full(len(columns), -1, dtype=np.int64)
    if len(index) == 0:
        return points, hit
    a, b, c = flat[index].transpose(1, 0, 2)
    area = _cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = _cross(columns[:, None] - a, c - a) / area
        v = _cross(b - a, columns[:, None] - a) / area
    # A hair's breadth beyond an edge still counts, or points on edges fall through.
    inside = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1.0 + 1e-9)
    depth = corners[index, :, 1]
    with np.errstate(invalid="ignore"):
        y = (
            depth[:, 0]
            + u * (depth[:, 1] - depth[:, 0])
            + v * (depth[:, 2] - depth[:, 0])
        )
    y = np.where(inside, y, -np.inf)
    best = y.argmax(axis=1)
    found = inside.any(axis=1)
    points[found, 1] = y[found, best[found]]
    hit[found] = index[best[found]]
    return points, hit


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    result: FloatArray = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return result


def _on_back(person: Person, triangle: IntArray) -> FloatArray:
    labels = person.labels[person.triangles[triangle]]
    result: FloatArray = (triangle >= 0) & (labels == LABEL_BACK).any(axis=1)
    return result


def _vertex_normals(person: Person) -> FloatArray:
    a, b, c = person.vertices[person.triangles].transpose(1, 0, 2)
    faces = np.cross(b - a, c - a)
    normals = np.zeros_like(person.vertices)
    for k in range(3):
        np.add.at(normals, person.triangles[:, k], faces)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(length > 0.0, length, 1.0)
