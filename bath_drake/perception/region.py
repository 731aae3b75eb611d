"""The square of a picture that a network looks at, and its mask's way back."""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bath_drake.notation import BoolArray, FloatArray
from bath_drake.perception.segmenter import Picture

# The square is so much larger than what is in it: a person's outline needs some room.
ROOM = 1.25


@dataclass(frozen=True)
class Region:
    """A square of a picture, pixels; it may reach over the picture's edge.

    Attributes:
        left: Column of its left edge.
        top: Row of its upper edge.
        side: Its side.
    """

    left: float
    top: float
    side: float

    def crop(self, image: NDArray[Any], height: int, width: int) -> NDArray[Any]:
        """Returns the square of an image (H, W, c), scaled to (height, width, c)."""
        warped = cv2.warpAffine(
            image,
            self._matrix(height, width),
            (width, height),
            flags=cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        return np.asarray(warped).reshape(height, width, -1)

    def paste(self, values: NDArray[Any], shape: tuple[int, int]) -> NDArray[Any]:
        """Returns values (h, w) of the scaled square in their place; 0 outside it."""
        height, width = values.shape
        rows, columns = shape
        return np.asarray(
            cv2.warpAffine(
                values,
                self._matrix(height, width),
                (columns, rows),
                flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            )
        )

    def _matrix(self, height: int, width: int) -> FloatArray:
        x, y = width / self.side, height / self.side
        return np.array([[x, 0.0, -x * self.left], [0.0, y, -y * self.top]])


def region_around(mask: BoolArray) -> Region | None:
    """Returns a square around a mask (H, W), with room; None if it is empty."""
    column, row, width, height = cv2.boundingRect(mask.view(np.uint8))
    if width == 0:
        return None
    side = ROOM * max(width, height)
    return Region(column + (width - side) / 2.0, row + (height - side) / 2.0, side)


def region_of(picture: Picture) -> Region | None:
    """Returns the square around what is in the workspace box; None if nothing is."""
    return region_around(picture.boxed)
