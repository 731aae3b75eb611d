"""A depth image as a shaded point cloud, drawn from any side without a GPU."""

from dataclasses import dataclass

import numpy as np

from bath_drake.notation import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """A virtual pinhole camera that looks at a target.

    Attributes:
        eye: (3,) where it is, m.
        target: (3,) the point in the middle of the picture.
        up: (3,) a direction that points upwards in it.
        width: Columns, pixels.
        height: Rows, pixels.
        field_of_view: Vertical angle of the picture, rad.
    """

    eye: FloatArray
    target: FloatArray
    up: FloatArray
    width: int = 1200
    height: int = 1000
    field_of_view: float = 0.5

    @property
    def axes(self) -> FloatArray:
        """(3, 3) rows: right, down and forward of the picture."""
        forward = self.target - self.eye
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, self.up)
        right = right / np.linalg.norm(right)
        return np.stack([right, np.cross(forward, right), forward])

    @property
    def focal_length(self) -> float:
        """Pixels."""
        return float(0.5 * self.height / np.tan(0.5 * self.field_of_view))

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Returns picture coordinates (..., 2) and distances (...) along the view."""
        seen = (np.asarray(points) - self.eye) @ self.axes.T
        depth = np.where(seen[..., 2] > 1e-6, seen[..., 2], np.nan)
        centre = np.array([self.width, self.height]) / 2.0
        return seen[..., :2] / depth[..., None] * self.focal_length + centre, depth


def shade(colours: FloatArray, normals: FloatArray, light: FloatArray) -> FloatArray:
    """Lambertian shading of colours (n, 3) in [0, 1]; `light` points to the lamp."""
    light = light / np.linalg.norm(light)
    facing = np.clip(normals @ light, 0.0, 1.0)
    known = np.linalg.norm(normals, axis=1) > 0.5
    share = np.where(known, 0.42 + 0.62 * facing, 0.7)
    return np.clip(colours * share[:, None], 0.0, 1.0)


def draw_points(
    view: Viewpoint,
    points: FloatArray,
    colours: FloatArray,
    size: float,
    background: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> FloatArray:
    """Draws points (n, 3) as small discs; nearer ones hide those behind.

    Args:
        view: From where.
        points: (n, 3), m.
        colours: (n, 3) in [0, 1].
        size: Diameter of a point at the target, m.
        background: Colour where no point is.

    Returns:
        The picture, (height, width, 3).
    """
    picture = np.empty((view.height, view.width, 3))
    picture[:] = background
    places, depth = view.project(points)
    order = np.argsort(-depth, kind="stable")  # NaN comes last
    order = order[: int(np.isfinite(depth).sum())]
    reach = float(np.linalg.norm(view.target - view.eye))
    disc = _disc(max(0.5, 0.5 * size * view.focal_length / reach))
    # Far points first, each with all pixels of its disc: the last one written stays.
    pixels = np.floor(places[order, None] + disc[None]).astype(np.int64)
    u, v = pixels[..., 0].ravel(), pixels[..., 1].ravel()
    inside = (u >= 0) & (u < view.width) & (v >= 0) & (v < view.height)
    owner = np.repeat(order, len(disc))[inside]
    picture[v[inside], u[inside]] = colours[owner]
    return picture


def _disc(radius: float) -> IntArray:
    span = np.arange(-int(np.ceil(radius)), int(np.ceil(radius)) + 1)
    columns, rows = np.meshgrid(span, span)
    inside = columns**2 + rows**2 <= radius**2
    return np.column_stack([columns[inside], rows[inside]]).astype(np.int64)
