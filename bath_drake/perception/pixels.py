"""Per-pixel geometry of an organised point image, compiled."""

import numpy as np
from numba import njit

from bath_drake.notation import BoolArray, FloatArray, IntArray

# Skin seen at a flatter angle than this counts as seen at it (cosine of 80
# degrees): a grazing pixel must not outweigh a hundred others.
MIN_COSINE = 0.17


@njit(cache=True)
def points_in_world(
    depth: FloatArray, rays: FloatArray, R_WC: FloatArray, p_WC: FloatArray
) -> FloatArray:
    """Returns the points a depth image shows, in W.

    Args:
        depth: (H, W), metres.
        rays: (H, W, 3) points at depth 1 in C.
        R_WC: (3, 3) orientation of the camera in W.
        p_WC: (3,) position of the camera in W.

    Returns:
        (H, W, 3) points in W; NaN where the depth is not finite and positive.
    """
    rows, columns = depth.shape
    points = np.empty((rows, columns, 3))
    for v in range(rows):
        for u in range(columns):
            z = depth[v, u]
            if z > 0.0 and z < np.inf:
                x, y = rays[v, u, 0] * z, rays[v, u, 1] * z
                for k in range(3):
                    points[v, u, k] = (
                        R_WC[k, 0] * x + R_WC[k, 1] * y + R_WC[k, 2] * z + p_WC[k]
                    )
            else:
                points[v, u, 0] = points[v, u, 1] = points[v, u, 2] = np.nan
    return points


@njit(cache=True)
def inside_box(points: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    """Returns which points (H, W, 3) lie in an axis-aligned box; NaN does not."""
    rows, columns, _ = points.shape
    inside = np.empty((rows, columns), dtype=np.bool_)
    for v in range(rows):
        for u in range(columns):
            ok = True
            for k in range(3):
                p = points[v, u, k]
                ok = ok and p >= low[k] and p <= high[k]
            inside[v, u] = ok
    return inside


@njit(cache=True)
def behind_jump(
    points: FloatArray, mask: BoolArray, limit: float, most_lost: int = 2
) -> BoolArray:
    """Returns the mask's pixels beside a jump of depth.

    Args:
        points: (H, W, 3), metres.
        mask: (H, W) pixels asked about.
        limit: Two neighbours further apart than this do not touch, metres.
        most_lost: So many pixels without depth in a row are the sensor's, and looked
            past; more are no surface.

    Returns:
        (H, W) True where, to the right, left, up or down, what was measured next is
        further off than `limit` for every step to it, or too many pixels away.
    """
    rows, columns, _ = points.shape
    found = np.zeros((rows, columns), dtype=np.bool_)
    for v in range(rows):
        for u in range(columns):
            if not mask[v, u]:
                continue
            for k in range(4):
                dv = (0, 0, 1, -1)[k]
                du = (1, -1, 0, 0)[k]
                if not (0 <= v + dv < rows and 0 <= u + du < columns):
                    continue
                touches = False
                for n in range(1, most_lost + 2):
                    y, x = v + n * dv, u + n * du
                    if not (0 <= y < rows and 0 <= x < columns):
                        touches = True  # the image ends before anything is known
                        break
                    d2 = 0.0
                    for c in range(3):
                        d2 += (points[y, x, c] - points[v, u, c]) ** 2
                    if d2 == d2:  # measured
                        touches = d2 <= (n * limit) ** 2
                        break
                if not touches:
                    found[v, u] = True
                    break
    return found


@njit(cache=True)
def with_rim(
    points: FloatArray, mask: BoolArray, allowed: BoolArray, limit: float
) -> BoolArray:
    """Returns the mask with the pixels beside it on which its surface goes on.

    Args:
        points: (H, W, 3), metres.
        mask: (H, W).
        allowed: (H, W) what may be added.
        limit: Two neighbours further apart than this do not touch, metres.

    Returns:
        (H, W) the mask, and each allowed pixel that touches one of it to the right,
        left, up or down.
    """
    rows, columns, _ = points.shape
    grown = mask.copy()
    for v in range(rows):
        for u in range(columns):
            if mask[v, u] or not allowed[v, u]:
                continue
            for k in range(4):
                y, x = v + (0, 0, 1, -1)[k], u + (1, -1, 0, 0)[k]
                if not (0 <= y < rows and 0 <= x < columns and mask[y, x]):
                    continue
                d2 = 0.0
                for c in range(3):
                    d2 += (points[y, x, c] - points[v, u, c]) ** 2
                if d2 <= limit * limit:
                    grown[v, u] = True
    return grown


@njit(cache=True)
def column_steps(points: FloatArray, mask: BoolArray) -> FloatArray:
    """Returns the distances (n,), m, of horizontal neighbours both in the mask."""
    rows, columns, _ = points.shape
    steps = np.empty(rows * columns)
    count = 0
    for v in range(rows):
        for u in range(columns - 1):
            if mask[v, u] and mask[v, u + 1]:
                d2 = 0.0
                for k in range(3):
                    d2 += (points[v, u + 1, k] - points[v, u, k]) ** 2
                steps[count] = np.sqrt(d2)
                count += 1
    return steps[:count].copy()


@njit(cache=True)
def pixel_normals(points: FloatArray, mask: BoolArray, reach: int) -> FloatArray:
    """Returns rough normals of an organised point image.

    Args:
        points: (H, W, 3), metres.
        mask: (H, W) pixels of one surface.
        reach: Differences are taken to the furthest neighbour in the mask within
            this many pixels on either side.

    Returns:
        (H, W, 3) unit normals on the camera's side (image rows run down, columns
        right, as in frame C); zero where the neighbours span no plane.
    """
    rows, columns, _ = points.shape
    normals = np.zeros((rows, columns, 3))
    for v in range(rows):
        for u in range(columns):
            if not mask[v, u]:
                continue
            n0, n1, n2 = _normal(points, mask, v, u, reach)
            length = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
            if length > 0.0:
                normals[v, u, 0] = n0 / length
                normals[v, u, 1] = n1 / length
                normals[v, u, 2] = n2 / length
    return normals


@njit(cache=True)
def normals_at(
    points: FloatArray, mask: BoolArray, reach: int, pixels: IntArray
) -> FloatArray:
    """Returns the (n, 3) `pixel_normals` of some pixels, counted by row, of a mask."""
    _, columns, _ = points.shape
    normals = np.zeros((len(pixels), 3))
    for i in range(len(pixels)):
        v, u = pixels[i] // columns, pixels[i] % columns
        n0, n1, n2 = _normal(points, mask, v, u, reach)
        length = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
        if length > 0.0:
            normals[i, 0] = n0 / length
            normals[i, 1] = n1 / length
            normals[i, 2] = n2 / length
    return normals


@njit(cache=True)
def facing_along(
    points: FloatArray, mask: BoolArray, reach: int, axis: FloatArray, limit: float
) -> BoolArray:
    """Returns the mask's pixels whose normal is turned towards an axis.

    Args:
        points: (H, W, 3), metres.
        mask: (H, W) pixels of one surface.
        reach: As of `pixel_normals`.
        axis: (3,) unit vector.
        limit: Cosine of the angle between normal and axis that is not exceeded.

    Returns:
        (H, W) True where it is.
    """
    rows, columns, _ = points.shape
    facing = np.zeros((rows, columns), dtype=np.bool_)
    for v in range(rows):
        for u in range(columns):
            if mask[v, u]:
                n0, n1, n2 = _normal(points, mask, v, u, reach)
                length = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
                along = n0 * axis[0] + n1 * axis[1] + n2 * axis[2]
                facing[v, u] = along > limit * length
    return facing


@njit(cache=True, inline="always")
def _normal(
    points: FloatArray, mask: BoolArray, v: int, u: int, reach: int
) -> tuple[float, float, float]:
    """Returns a pixel's normal, of any length, as of `pixel_normals`."""
    rows, columns = mask.shape
    a, b, c, d = u, u, v, v
    for _ in range(reach):
        if a > 0 and mask[v, a - 1]:
            a -= 1
        if b < columns - 1 and mask[v, b + 1]:
            b += 1
        if c > 0 and mask[c - 1, u]:
            c -= 1
        if d < rows - 1 and mask[d + 1, u]:
            d += 1
    return _cross(points[c, u], points[d, u], points[v, a], points[v, b])


@njit(cache=True, inline="always")
def _cross(
    a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray
) -> tuple[float, float, float]:
    """Returns (b - a) x (d - c); no arrays are made, unlike numpy's cross."""
    x0, x1, x2 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    y0, y1, y2 = d[0] - c[0], d[1] - c[1], d[2] - c[2]
    return x1 * y2 - x2 * y1, x2 * y0 - x0 * y2, x0 * y1 - x1 * y0


@njit(cache=True)
def pixel_areas(
    points: FloatArray,
    depth: FloatArray,
    mask: BoolArray,
    eye: FloatArray,
    focal2: float,
) -> FloatArray:
    """Returns the surface behind each pixel of a mask.

    A pixel's solid angle is (z / r)^3 / f^2 at the depth z and the distance r, so
    a surface at the angle t to the ray shows z^3 / (r f^2 cos t) in it.

    Args:
        points: (H, W, 3), metres, in the frame of `eye`.
        depth: (H, W), metres along the optical axis.
        mask: (H, W) pixels of one smooth surface.
        eye: (3,) the camera's centre.
        focal2: Product of the two focal lengths, pixels^2.

    Returns:
        (H, W), m^2; zero outside the mask.
    """
    rows, columns, _ = points.shape
    areas = np.zeros((rows, columns))
    for v in range(rows):
        for u in range(columns):
            if not mask[v, u]:
                continue
            areas[v, u] = pixel_area(points, depth[v, u], mask, v, u, eye, focal2)
    return areas


@njit(cache=True, inline="always")
def pixel_area(
    points: FloatArray,
    z: float,
    mask: BoolArray,
    v: int,
    u: int,
    eye: FloatArray,
    focal2: float,
) -> float:
    """Returns the surface behind one pixel, at the depth z, as of `pixel_areas`."""
    rows, columns = mask.shape
    a = u - 1 if u > 0 and mask[v, u - 1] else u
    b = u + 1 if u < columns - 1 and mask[v, u + 1] else u
    c = v - 1 if v > 0 and mask[v - 1, u] else v
    d = v + 1 if v < rows - 1 and mask[v + 1, u] else v
    n0, n1, n2 = _cross(points[v, a], points[v, b], points[c, u], points[d, u])
    length = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    ray0 = points[v, u, 0] - eye[0]
    ray1 = points[v, u, 1] - eye[1]
    ray2 = points[v, u, 2] - eye[2]
    r = np.sqrt(ray0 * ray0 + ray1 * ray1 + ray2 * ray2)
    cosine = 1.0
    if length > 0.0:
        dot = n0 * ray0 + n1 * ray1 + n2 * ray2
        cosine = max(abs(dot) / (length * r), MIN_COSINE)
    return float(z**3 / (r * focal2 * cosine))
