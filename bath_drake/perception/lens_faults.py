"""What glare and water on the lens do to an image; the numbers are our own."""

from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from bath_drake.notation import BoolArray, ByteArray, FloatArray
from bath_drake.perception.faults import FaultsConfig, within

_Pixel = TypeVar("_Pixel", bound="np.generic")

_DROPLETS, _OUTLIERS = 4, 5
_WHITE, _GREY = 255, 90
# The blur inside a droplet, as a share of its radius.
_BLUR = 0.5
# A wrong depth is off by up to this share of the true one.
_WILD = 0.5


def droplets(
    count: int, radius: float, width: int, height: int, seed: int
) -> FloatArray:
    """Returns where the water is: (count, 3) columns, rows and radii, pixels.

    Args:
        count: How many.
        radius: Of the largest; the smallest have half of it.
        width: Of the image.
        height: Of the image.
        seed: Not negative: the drops stay where they are for a run.
    """
    rng = np.random.default_rng([seed, _DROPLETS])
    places = rng.uniform(0.0, [width, height], (count, 2))
    radii = rng.uniform(0.5 * radius, radius, count)
    return np.column_stack([places, radii])


def with_lens_faults(
    colour: ByteArray,
    depth: NDArray[np.float32],
    config: FaultsConfig,
    *,
    seed: int,
    frame: int,
    t: float,
) -> tuple[ByteArray, NDArray[np.float32]]:
    """Returns the images as they are taken through a wet lens or into a glare.

    Args:
        colour: (H, W, 3 or 4), RGB.
        depth: (H, W), m; 0 where nothing is measured.
        config: The faults; those of single frames are no matter here.
        seed: Not negative, of the whole run.
        frame: Its number: the wrong depths are another frame's no more.
        t: When it is taken, s.

    Returns:
        New images of the same shapes.
    """
    colour, depth = colour.copy(), depth.copy()
    height, width = depth.shape
    water, glare = config.droplets, config.saturation
    if water is not None and within(water, t):
        rng = np.random.default_rng([seed, frame, _OUTLIERS])
        for u, v, radius in droplets(
            water.count, water.radius * width, width, height, seed
        ):
            window, disc = _disc(u, v, radius, depth.shape)
            _blur(colour[window], disc, radius)
            draw = rng.random(disc.shape)
            inside = depth[window]
            wild = disc & (draw < water.lost + water.outliers)
            factors = rng.uniform(1.0 - _WILD, 1.0 + _WILD, disc.shape)
            inside[wild] *= factors[wild].astype(np.float32)
            inside[disc & (draw < water.lost)] = 0.0
    if glare is not None and within(glare, t):
        u, v = glare.centre[0] * width, glare.centre[1] * height
        window, disc = _disc(u, v, glare.radius * width, depth.shape)
        colour[window][disc] = _WHITE
        depth[window][disc] = 0.0
    blank, cover, shift = config.blank, config.covered, config.shifted
    if shift is not None and within(shift, t):
        colour = _shifted(colour, shift.pixels)
        depth = _shifted(depth, shift.pixels)
    if cover is not None and within(cover, t):
        u, v = cover.centre[0] * width, cover.centre[1] * height
        window, disc = _disc(u, v, cover.radius * width, depth.shape)
        colour[window][disc] = _GREY
        depth[window][disc] = cover.depth
    if blank is not None and within(blank, t):
        depth[: round(blank.share * height)] = np.nan
    return colour, depth


def _shifted(image: NDArray[_Pixel], pixels: list[int]) -> NDArray[_Pixel]:
    """The image moved by columns and rows; its edge goes on where nothing was."""
    du, dv = pixels
    rows = np.clip(np.arange(image.shape[0]) - dv, 0, image.shape[0] - 1)
    columns = np.clip(np.arange(image.shape[1]) - du, 0, image.shape[1] - 1)
    return image[rows[:, None], columns]


def _disc(
    u: float, v: float, radius: float, shape: tuple[int, ...]
) -> tuple[tuple[slice, slice], BoolArray]:
    """A window of the image, and the pixels of it whose centres are in a disc."""
    rows = slice(max(int(v - radius), 0), min(int(v + radius) + 1, shape[0]))
    columns = slice(max(int(u - radius), 0), min(int(u + radius) + 1, shape[1]))
    y = np.arange(rows.start, rows.stop) + 0.5 - v
    x = np.arange(columns.start, columns.stop) + 0.5 - u
    return (rows, columns), x[None, :] ** 2 + y[:, None] ** 2 <= radius**2


def _blur(image: ByteArray, disc: BoolArray, radius: float) -> None:
    """Blurs a window inside a disc, in place."""
    blurred = cv2.GaussianBlur(
        np.ascontiguousarray(image), (0, 0), max(_BLUR * radius, 0.5)
    )
    image[disc] = blurred[disc]
