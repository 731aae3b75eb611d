"""Which pixels may show the person's skin: one protocol, by colour or by a network.

What is made of these pixels, the largest torso in the workspace box, is the same for
all (`bath_drake.perception.segmentation`).
"""

from dataclasses import dataclass
from typing import Protocol

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
        points_W: (H, W, 3) what the depth shows, metres; NaN where nothing.
    """

    colour: ByteArray
    depth: FloatArray
    camera: PinholeCamera
    points_W: FloatArray


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
        """Returns the pixels (H, W) that have the colour of skin."""
        return skin_mask(picture.colour, self.config)
