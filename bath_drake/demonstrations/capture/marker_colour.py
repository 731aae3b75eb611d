"""The marker's colour: given, learned from a piece of a picture, or found.

Hue and saturation change little with the light on the marker; brightness changes
much and hardly counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from bath_drake.errors import DemonstrationError
from bath_drake.notation import BoolArray, ByteArray, FloatArray

# Half the range of hues taken for the marker's, degrees: at least, and at most.
MIN_TOLERANCE, MAX_TOLERANCE = 14.0, 35.0
# Paler or darker pixels are not the marker's, as a share of its own and outright. A
# colour that was named and not seen is paler in a picture: lamps shine on it.
SATURATION_SHARE, NAMED_SHARE, MIN_SATURATION = 0.75, 0.5, 0.35
MIN_VALUE = 0.12
# Skin is paler than this, and so is not learned for the marker beside it.
VIVID = 0.45
# Skin's hues, degrees: a marker that nobody described is none of these.
SKIN_HUES = (-20.0, 55.0)
# How a marker that nobody described is recognised: it is the only blob of its hue,
# in most of the frames.
HUE_STEP = 20
LEAST_VALUE = 0.2
MIN_FRAMES, MIN_ALONE = 0.6, 0.8


@dataclass(frozen=True)
class MarkerColour:
    """Which pixels may be the marker's.

    Attributes:
        hue: Degrees, 0 red, 120 green, 240 blue.
        tolerance: Greatest difference of hue, degrees.
        saturation: Least saturation, 0 to 1.
        rgb: The colour itself, for messages and pictures.
    """

    hue: float
    tolerance: float
    saturation: float
    rgb: tuple[int, int, int]

    def mask(self, colour: ByteArray) -> BoolArray:
        """Returns which pixels (H, W) of an RGB image have the colour."""
        hsv = cv2.cvtColor(colour, cv2.COLOR_RGB2HSV)
        low_s, low_v = round(255 * self.saturation), round(255 * MIN_VALUE)
        # OpenCV halves the hue's degrees to fit a byte.
        low = round((self.hue - self.tolerance) / 2.0)
        high = round((self.hue + self.tolerance) / 2.0)
        found = np.zeros(colour.shape[:2], dtype=np.bool_)
        for turn in (-180, 0, 180):
            first, last = max(low + turn, 0), min(high + turn, 179)
            if first <= last:
                found |= (
                    cv2.inRange(
                        hsv,
                        np.array([first, low_s, low_v]),
                        np.array([last, 255, 255]),
                    )
                    > 0
                )
        return found


def colour_of_rgb(rgb: Sequence[int], where: str) -> MarkerColour:
    """Returns the marker's colour from one RGB value, 0 to 255.

    Raises:
        DemonstrationError: Naming `where`, if the colour is too pale.
    """
    return _learned(np.array([rgb], dtype=np.uint8), where, NAMED_SHARE)


def colour_of_pixels(pixels: ByteArray, where: str) -> MarkerColour:
    """Learns the marker's colour from pixels (n, 3), RGB, most of them the marker's.

    Raises:
        DemonstrationError: Naming `where`, if most of them are too pale.
    """
    return _learned(pixels, where, SATURATION_SHARE)


def _learned(pixels: ByteArray, where: str, share: float) -> MarkerColour:
    hsv = cv2.cvtColor(pixels[None], cv2.COLOR_RGB2HSV)[0].astype(np.float64)
    saturations, hues = hsv[:, 1] / 255.0, 2.0 * hsv[:, 0]
    # A box around a ball has a rim of something else: the vivid half is the ball.
    palest = VIVID if saturations.max() >= VIVID else MIN_SATURATION
    vivid = saturations >= max(np.median(saturations), palest)
    if not vivid.any():
        raise DemonstrationError(
            f"{where}: the colour is too pale to be told from skin and walls "
            f"(saturation {saturations.max():.2f}), allowed: from {MIN_SATURATION} on"
        )
    hue = _median_hue(hues[vivid])
    spread = np.median(np.abs(_turned(hues[vivid] - hue)))
    tolerance = float(np.clip(4.0 * spread, MIN_TOLERANCE, MAX_TOLERANCE))
    least = max(share * float(np.median(saturations[vivid])), MIN_SATURATION)
    red, green, blue = (round(v) for v in np.median(pixels[vivid], axis=0).tolist())
    return MarkerColour(hue, tolerance, least, (red, green, blue))


def detect_colour(
    frames: Sequence[ByteArray], pixels: tuple[float, float], where: str
) -> MarkerColour:
    """Finds the one vivid colour that shows as a single small blob.

    Args:
        frames: Colour images (H, W, 3), spread over the recording.
        pixels: Least and greatest number of pixels of a marker's blob.
        where: What to name in the message.

    Raises:
        DemonstrationError: If no colour or several do.
    """
    alone: dict[int, list[ByteArray]] = {}
    for colour in frames:
        hsv = cv2.cvtColor(colour, cv2.COLOR_RGB2HSV)
        vivid = (hsv[..., 1] >= 255 * VIVID) & (hsv[..., 2] >= 255 * LEAST_VALUE)
        # Most of a room is pale: what is left is quickly counted.
        rows, columns = np.nonzero(vivid)
        hues = 2.0 * hsv[rows, columns, 0]
        for hue in range(0, 360, HUE_STEP):
            if SKIN_HUES[0] <= _turned(np.array(hue, dtype=np.float64)) <= SKIN_HUES[1]:
                continue
            near = np.abs(_turned(hues - hue)) <= HUE_STEP
            if np.count_nonzero(near) < pixels[0]:
                continue
            mask = np.zeros(vivid.shape, dtype=np.uint8)
            mask[rows[near], columns[near]] = 1
            _, _, stats, _ = cv2.connectedComponentsWithStats(mask)
            sizes = stats[1:, cv2.CC_STAT_AREA]
            largest = sizes.max()
            if pixels[0] <= largest <= pixels[1] and largest >= MIN_ALONE * sizes.sum():
                alone.setdefault(hue, []).append(colour[rows[near], columns[near]])
    found = {h: len(p) for h, p in alone.items() if len(p) >= MIN_FRAMES * len(frames)}
    # Neighbouring hues are one colour: the best of them stands for all.
    best = [
        h
        for h, n in found.items()
        if all(found.get((h + d) % 360, 0) < n + (d > 0) for d in (-HUE_STEP, HUE_STEP))
    ]
    colours = [colour_of_pixels(np.concatenate(alone[h]), where) for h in best]
    if len(colours) != 1:
        seen = " and ".join(",".join(map(str, c.rgb)) for c in colours)
        raise DemonstrationError(
            f"{where}: found {seen or 'no'} vivid blob{'s' if seen else ''} that could "
            "be the marker, expected one; name its colour (--marker-colour) or show it "
            "in the first frame (--marker-box, --marker-at)"
        )
    return colours[0]


def _turned(angle: FloatArray) -> FloatArray:
    """Degrees in [-180, 180)."""
    return np.asarray((angle + 180.0) % 360.0 - 180.0)


def _median_hue(hues: FloatArray) -> float:
    """The median on the circle: that about the mean direction."""
    mean = np.degrees(np.angle(np.exp(1j * np.radians(hues)).mean()))
    return float((mean + np.median(_turned(hues - mean))) % 360.0)
