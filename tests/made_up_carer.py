"""A recording of a barrel-shaped back and a marker on it, drawn without a simulator."""

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from bath_drake.demonstrations.rgbd.writer import RgbdWriter
from bath_drake.perception.camera import PinholeCamera

CAMERA = PinholeCamera(192, 160, 150.0, 150.0, 96.0, 80.0)
DISTANCE = 1.0  # of the body's axis from the camera, m
BREADTH, LENGTH, DEPTH = 0.18, 0.42, 0.12  # semi-axes of the body, m
HEIGHT = 0.22  # half the back's, m
WALL = 1.8
SKIN, TRUNKS, GREY = (205, 150, 120), (60, 70, 140), (120, 120, 120)
GREEN = (20, 190, 40)
RADIUS = 0.018


@dataclass
class Scene:
    """What a frame shows: lengths in m, in the body's frame unless said otherwise.

    The body's frame is the camera's with its origin on the barrel's axis: x to the
    right in the image (and of the person), y down, z away from the camera.
    """

    turn: np.ndarray = field(default_factory=lambda: np.zeros(3))  # rotation vector
    shift: np.ndarray = field(default_factory=lambda: np.zeros(3))
    marker: tuple[float, float] | None = (0.0, 0.0)  # x, y of the contact
    second: tuple[float, float] | None = None  # another ball of the same colour
    hand: tuple[float, float] | None = None  # a ball of skin's colour before the back
    colour: tuple[int, int, int] = GREEN
    wall: tuple[int, int, int] = GREY
    body: bool = True


def contact(x, y):
    """The point of the barrel at x, y and its outward normal, in the body's frame."""
    z = -DEPTH * np.sqrt(1.0 - (x / BREADTH) ** 2 - (y / LENGTH) ** 2)
    normal = np.array([x / BREADTH**2, y / LENGTH**2, z / DEPTH**2])
    return np.array([x, y, z]), normal / np.linalg.norm(normal)


def draw(scene, rng=None, noise=0.001):
    """Colour (H, W, 3) and depth (H, W), m, of a scene."""
    R = Rotation.from_rotvec(scene.turn).as_matrix()
    origin = np.array([0.0, 0.0, DISTANCE]) + scene.shift
    rays = CAMERA.rays
    depth = np.full(CAMERA.shape, WALL)
    colour = np.empty((*CAMERA.shape, 3), dtype=np.uint8)
    colour[:] = scene.wall
    if scene.body:
        # In the body's frame a ray is eye + z * ray.
        eye, ray = -R.T @ origin, rays @ R
        scale = 1.0 / np.array([BREADTH, LENGTH, DEPTH])
        z = _nearest_root(ray * scale, eye * scale, 1.0)
        y = eye[1] + z * ray[..., 1]
        skin = np.isfinite(z) & (np.abs(y) <= HEIGHT)
        trunks = np.isfinite(z) & (y > HEIGHT) & (y <= HEIGHT + 0.15)
        _paint(depth, colour, z, skin, SKIN)
        _paint(depth, colour, z, trunks, TRUNKS)
    for place, radius, paint in (
        (scene.marker, RADIUS, scene.colour),
        (scene.second, RADIUS, scene.colour),
        (scene.hand, 0.05, SKIN),
    ):
        if place is not None:
            point, normal = contact(*place)
            lifted = radius if paint is not SKIN else 0.12
            centre = R @ (point + lifted * normal) + origin
            z = _nearest_root(rays, -centre, radius**2)
            _paint(depth, colour, z, np.isfinite(z), paint)
    if rng is not None:
        depth = depth + rng.normal(0.0, noise, depth.shape)
    return colour, np.round(depth, 3)


def _nearest_root(ray, eye, square):
    """The least z with |eye + z ray|^2 = square; inf where there is none."""
    a, b = np.sum(ray**2, axis=-1), np.sum(ray * eye, axis=-1)
    root = b**2 - a * (np.sum(eye**2) - square)
    with np.errstate(invalid="ignore"):
        return np.where(root >= 0.0, (-b - np.sqrt(root)) / a, np.inf)


def _paint(depth, colour, z, where, paint):
    where = where & (z < depth)
    depth[where] = z[where]
    colour[where] = paint


def swaying(k, **kwargs):
    """Frame k of a body that turns and sways a little."""
    turn = np.array([0.02 * np.sin(0.5 * k), 0.06 * np.sin(0.3 * k), 0.0])
    shift = np.array([0.004 * np.sin(0.4 * k), 0.0, 0.006 * np.cos(0.35 * k)])
    return Scene(turn=turn, shift=shift, **kwargs)


FRAMES, RATE = 24, 12.0


def stroke_place(k):
    """Where the marker touches the barrel in frame k: a wave from left to right."""
    share = k / (FRAMES - 1)
    return -0.1 + 0.2 * share, 0.1 * np.sin(2.0 * np.pi * share)


def write_recording(folder, hidden=(), frames=FRAMES, **kwargs):
    """Writes a recording of a stroke; in `hidden` frames a hand covers the marker."""
    writer = RgbdWriter(folder, CAMERA, None)
    rng = np.random.default_rng(7)
    for k in range(frames):
        place = stroke_place(k)
        scene = swaying(k, **{"marker": None if k in hidden else place} | kwargs)
        # The hand is below the marker, and above in the hidden frames.
        x, y = place
        scene.hand = place if k in hidden else (x, min(y + 0.12, 0.2))
        writer.write(k / RATE, *draw(scene, rng))
    return folder
