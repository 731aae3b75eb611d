"""The part of a frame that may show the body: all else need not be looked at."""

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit

from bath_drake.notation import BoolArray, FloatArray, IntArray
from bath_drake.perception import morphology
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.pixels import pixel_area

Window = tuple[slice, slice]

# So many pixels around a body tell of its edge: two that were lost, and what is next.
REACH = 3


@dataclass(frozen=True)
class Crop:
    """The window of an image in which a body is looked for, and what is around it.

    Attributes:
        window: Rows and columns of the image; of size zero where there can be no body.
        spare: So many pixels at its top, bottom, left and right are near what is in the
            workspace box, too: discs that close gaps may stand there.
    """

    window: Window
    spare: tuple[int, int, int, int]

    @property
    def corner(self) -> tuple[int, int]:
        """The image's row and column that are the window's first."""
        return self.window[0].start, self.window[1].start

    def placed(self, mask: BoolArray, shape: tuple[int, int]) -> BoolArray:
        """Returns a window's mask in the image; False outside the window."""
        whole = np.zeros(shape, dtype=bool)
        whole[self.window] = mask
        return whole

    def closed(self, mask: BoolArray, radius: float) -> BoolArray:
        """Returns a window's mask, its gaps closed by discs that may be beside it."""
        reach = int(np.ceil(radius)) + 1
        top, bottom, left, right = (min(spare, reach) for spare in self.spare)
        rows, columns = mask.shape
        padded = np.pad(mask, ((top, bottom), (left, right)))
        closed = morphology.closed(padded, radius)
        return closed[top : top + rows, left : left + columns]


def crop_to_body(
    boxed: BoolArray, robot_mask: BoolArray, expected: BoolArray | None
) -> Crop:
    """Returns where a body may be: the robot's pixels in the box are many.

    Args:
        boxed: (H, W) pixels that show something in the workspace box.
        robot_mask: (H, W) pixels that may show the robot.
        expected: (H, W) where a back is expected, if the robot hides it.
    """
    body = boxed & ~robot_mask
    if expected is not None:
        body |= robot_mask & expected
    outer = _around(boxed, 2)
    # What is expected out of the box is not looked for.
    inner = _around(body[outer], REACH)
    (top, left), (height, width) = (s.start for s in outer), body[outer].shape
    window = (
        slice(top + inner[0].start, top + inner[0].stop),
        slice(left + inner[1].start, left + inner[1].stop),
    )
    rows, columns = inner
    spare = rows.start, height - rows.stop, columns.start, width - columns.stop
    return Crop(window, spare)


def _around(mask: BoolArray, margin: int) -> Window:
    """The rows and columns around a mask; of size zero if it is empty."""
    image = np.ascontiguousarray(mask).view(np.uint8)
    x, y, width, height = cv2.boundingRect(image) if mask.size else (0, 0, 0, 0)
    if width == 0:
        return slice(0, 0), slice(0, 0)
    return (
        slice(max(y - margin, 0), min(y + height + margin, mask.shape[0])),
        slice(max(x - margin, 0), min(x + width + margin, mask.shape[1])),
    )


def boxed_pixels(
    depth: FloatArray,
    camera: PinholeCamera,
    R_WC: FloatArray,
    p_WC: FloatArray,
    low_W: FloatArray,
    high_W: FloatArray,
) -> BoolArray:
    """Returns which pixels (H, W) of a depth image show something in a box.

    Args:
        depth: (H, W), metres; zero, NaN or infinite where nothing was measured.
        camera: Whose image it is.
        R_WC: (3, 3) its orientation in W.
        p_WC: (3,) its position in W, metres.
        low_W: (3,) the box's lower corner, metres.
        high_W: (3,) its upper corner.
    """
    x, y = _rays(camera)
    return _boxed(np.ascontiguousarray(depth), x, y, R_WC, p_WC, low_W, high_W)


def points_in_window(
    depth: FloatArray,
    camera: PinholeCamera,
    R_WC: FloatArray,
    p_WC: FloatArray,
    window: Window,
) -> tuple[FloatArray, FloatArray]:
    """Returns a window's depths (h, w) and points in W (h, w, 3), metres.

    The points are those of `bath_drake.perception.pixels.points_in_world`: NaN where
    nothing was measured. Arguments are as of `boxed_pixels`.
    """
    x, y = _rays(camera)
    part = np.array(depth[window], dtype=np.float64, order="C")
    return part, _points(part, x[window[1]], y[window[0]], R_WC, p_WC)


def _rays(camera: PinholeCamera) -> tuple[FloatArray, FloatArray]:
    """Of the points at depth 1 in C, x (W,) of the columns and y (H,) of the rows."""
    return camera.rays[0, :, 0].copy(), camera.rays[:, 0, 1].copy()


@njit(cache=True)
def _points(
    depth: FloatArray, x: FloatArray, y: FloatArray, R_WC: FloatArray, p_WC: FloatArray
) -> FloatArray:
    rows, columns = depth.shape
    points = np.full((rows, columns, 3), np.nan)
    for v in range(rows):
        for u in range(columns):
            z = depth[v, u]
            if z > 0.0 and z < np.inf:
                xz, yz = x[u] * z, y[v] * z
                for k in range(3):
                    points[v, u, k] = (
                        R_WC[k, 0] * xz + R_WC[k, 1] * yz + R_WC[k, 2] * z + p_WC[k]
                    )
    return points


# Without branches the vector unit takes several pixels at a time.
@njit(cache=True)
def _boxed(
    depth: FloatArray,
    x: FloatArray,
    y: FloatArray,
    R: FloatArray,
    p: FloatArray,
    low: FloatArray,
    high: FloatArray,
) -> BoolArray:
    """The `inside_box` of `points_in_world`; the points are not kept."""
    rows, columns = depth.shape
    boxed = np.empty((rows, columns), dtype=np.bool_)
    r00, r10, r20, r01, r11, r21 = R[0, 0], R[1, 0], R[2, 0], R[0, 1], R[1, 1], R[2, 1]
    r02, r12, r22, p0, p1, p2 = R[0, 2], R[1, 2], R[2, 2], p[0], p[1], p[2]
    l0, l1, l2, h0, h1, h2 = low[0], low[1], low[2], high[0], high[1], high[2]
    for v in range(rows):
        for u in range(columns):
            z = float(depth[v, u])
            xz, yz = x[u] * z, y[v] * z
            w0 = r00 * xz + r01 * yz + r02 * z + p0
            w1 = r10 * xz + r11 * yz + r12 * z + p1
            w2 = r20 * xz + r21 * yz + r22 * z + p2
            inside = (w0 >= l0) & (w0 <= h0) & (w1 >= l1) & (w1 <= h1)
            inside &= (w2 >= l2) & (w2 <= h2)
            boxed[v, u] = inside & (z > 0.0) & (z < np.inf)
    return boxed


@njit(cache=True)
def seen_points(
    points: FloatArray,
    depth: FloatArray,
    mask: BoolArray,
    eye: FloatArray,
    focal2: float,
    corner: tuple[int, int],
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Returns the pixels of a mask one by one, by row.

    Args:
        points: (h, w, 3) of a window, metres, in the frame of `eye`.
        depth: (h, w), metres along the optical axis.
        mask: (h, w) pixels of one smooth surface.
        eye: (3,) the camera's centre.
        focal2: Product of the two focal lengths, pixels^2.
        corner: The image's row and column that are the window's first.

    Returns:
        The points (n, 3); the surface (n,) each stands for, m^2, as of
        `bath_drake.perception.pixels.pixel_areas`; the image's columns and rows (n, 2).
    """
    rows, columns = mask.shape
    count = 0
    for v in range(rows):
        for u in range(columns):
            count += mask[v, u]
    seen, areas = np.empty((count, 3)), np.empty(count)
    pixels = np.empty((count, 2), dtype=np.int64)
    n = 0
    for v in range(rows):
        for u in range(columns):
            if mask[v, u]:
                for k in range(3):
                    seen[n, k] = points[v, u, k]
                areas[n] = pixel_area(points, depth[v, u], mask, v, u, eye, focal2)
                pixels[n, 0], pixels[n, 1] = corner[1] + u, corner[0] + v
                n += 1
    return seen, areas, pixels
