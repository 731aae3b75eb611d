"""Which pixels may show the person's skin: one protocol, by colour or by a network.

What is made of these pixels, the largest torso in the workspace box, is the same for
all (`bath_drake.perception.segmentation`).
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from bath_drake.notation import BoolArray, ByteArray, FloatArray
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.segmentation import SegmentationConfig, skin_mask


@dataclass(frozen=True, eq=False)
class Picture:
    """One frame, as a segmenter gets it.

    Attributes:
        colour: (H, W, 3 or 4), RGB.
        depth: (H, W), metres; zero, NaN or infinite where nothing was measured.
        camera: The camera, the same for colour and depth.
        boxed: (H, W) pixels that show something in the workspace box.
    """

    colour: ByteArray
    depth: FloatArray
    camera: PinholeCamera
    boxed: BoolArray


class Segmenter(Protocol):
    """Says which pixels may show the person's skin."""

    def segment(self, picture: Picture) -> BoolArray:
        """Returns them, (H, W); those outside the workspace box do not matter."""
        ...


@dataclass(frozen=True, eq=False)
class ClassicSegmenter:
    """By colour, as in the paper (IV-B).

    Attributes:
        config: What colours skin has.
    """

    config: SegmentationConfig

    def segment(self, picture: Picture) -> BoolArray:
        """Returns the pixels (H, W) in the box that have the colour of skin."""
        skin = np.zeros(picture.boxed.shape, dtype=bool)
        inside = np.flatnonzero(picture.boxed)
        if len(inside) > 0:
            pixels = picture.colour.reshape(-1, picture.colour.shape[2])
            colours = np.take(pixels, inside, axis=0)
            skin.ravel()[inside] = skin_mask(colours[None], self.config)[0]
        return skin
