"""Operations on masks with discs of any size, at a cost that does not grow."""

from functools import cache

import cv2
import numpy as np

from bath_drake.notation import BoolArray, ByteArray
from bath_drake.perception.components import components


def _bytes(mask: BoolArray) -> ByteArray:
    return np.ascontiguousarray(mask).view(np.uint8)


# Up to this radius a pass with the disc itself is faster than a distance transform.
_SMALL_RADIUS = 3.0


@cache
def _disc(radius: float) -> ByteArray:
    """Returns the pixels within `radius` of the middle one, the same as OpenCV's.

    Its distance is not quite Euclidean; with the very same disc both ways of
    dilating and eroding agree to the pixel.
    """
    reach = int(np.ceil(radius))
    canvas = np.ones((2 * reach + 1, 2 * reach + 1), dtype=np.uint8)
    canvas[reach, reach] = 0
    distance = cv2.distanceTransform(canvas, cv2.DIST_L2, cv2.DIST_MASK_5)
    return np.asarray(distance <= radius).view(np.uint8)


def erode(mask: BoolArray, radius: float) -> BoolArray:
    """Returns pixels further than `radius` pixels from the outside."""
    if radius <= _SMALL_RADIUS:
        return np.asarray(cv2.erode(_bytes(mask), _disc(radius))).view(np.bool_)
    distance = cv2.distanceTransform(_bytes(mask), cv2.DIST_L2, cv2.DIST_MASK_5)
    return np.asarray(distance > radius)


def dilate(mask: BoolArray, radius: float) -> BoolArray:
    """Returns pixels within `radius` pixels of the mask."""
    if radius <= _SMALL_RADIUS:
        return np.asarray(cv2.dilate(_bytes(mask), _disc(radius))).view(np.bool_)
    if not mask.any():
        return mask.copy()
    distance = cv2.distanceTransform(_bytes(~mask), cv2.DIST_L2, cv2.DIST_MASK_5)
    return np.asarray(distance <= radius)


def near(mask: BoolArray, other: BoolArray, radius: float) -> bool:
    """Whether a pixel of one mask is within `radius` pixels of the other's."""
    x, y, width, height = cv2.boundingRect(_bytes(mask))
    reach = int(np.ceil(radius))
    window = (
        slice(max(y - reach, 0), y + height + reach),
        slice(max(x - reach, 0), x + width + reach),
    )
    return bool((dilate(mask[window], radius) & other[window]).any())


def opened(mask: BoolArray, radius: float) -> BoolArray:
    """Returns what a disc of `radius` pixels can cover inside the mask."""
    return dilate(erode(mask, radius), radius) & mask


def closed(mask: BoolArray, radius: float) -> BoolArray:
    """Returns the mask and the gaps a disc of `radius` pixels cannot enter."""
    return ~opened(~mask, radius) | mask


def largest_component(mask: BoolArray) -> BoolArray:
    """Returns the largest 4-connected component; an empty mask stays empty."""
    found = components(mask)
    if len(found.sizes) == 0:
        return mask.copy()
    return found.painted(np.arange(len(found.sizes)) == np.argmax(found.sizes))


def without_holes(mask: BoolArray) -> BoolArray:
    """Returns the mask with everything it encloses."""
    holes = components(~mask)
    return holes.painted(~holes.at_edge) | mask


def without_specks(mask: BoolArray, most: int) -> BoolArray:
    """Returns the mask with the holes of up to `most` pixels that it encloses."""
    holes = components(~mask)
    return holes.painted(holes.sizes <= most) | mask


def convex_hull(mask: BoolArray) -> BoolArray:
    """Returns the convex hull of the mask's pixels."""
    canvas = np.zeros(mask.shape, dtype=np.uint8)
    pixels = cv2.findNonZero(_bytes(mask))
    if pixels is not None:
        cv2.fillConvexPoly(canvas, cv2.convexHull(pixels), 1)
    return canvas.astype(bool)


def stoutest_part(mask: BoolArray, radius: float, share: float) -> BoolArray:
    """Returns the mask's stoutest part, without limbs and neck.

    An opening by a disc, of which only the largest component of the eroded core
    grows back, so that a head on a neck thinner than the disc stays off.

    Args:
        mask: (H, W).
        radius: Least radius of the disc, pixels.
        share: Least radius as a share of that of the largest disc inside the mask.

    Returns:
        (H, W); empty if no disc of `radius` fits.
    """
    distance = cv2.distanceTransform(_bytes(mask), cv2.DIST_L2, cv2.DIST_MASK_5)
    radius = max(radius, share * float(distance.max()))
    core = largest_component(np.asarray(distance > radius))
    return dilate(core, radius) & mask
