"""Whether frames can be believed: their pixels, their stamps, frozen images."""

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from bath_drake.notation import FloatArray
from bath_drake.shared import Shared

# So many depth images in a row that are the same to the last bit are no measurements.
FROZEN_FRAMES = 3
# Stamps in steps of a period accumulate rounding, s.
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class FrameCheck(Shared):
    """What is known of a camera's frames so far.

    Attributes:
        stamp: The latest so far, s; -inf before the first frame.
        invalid_share: Of the newest frame's depth pixels, those that are not positive
            and finite; 1 before the first frame.
        repeats: How many frames in a row before it had the very same depth image.
        stamp_bad: Whether the last stamp was before `stamp`, of the future, or none.
        bits: (H, W) the newest depth image, bit for bit; None before the first frame.
    """

    stamp: float = -inf
    invalid_share: float = 1.0
    repeats: int = 0
    stamp_bad: bool = False
    bits: NDArray[np.int32] | None = None

    @property
    def frozen(self) -> bool:
        """Whether the camera gives one frame again and again."""
        return self.repeats >= FROZEN_FRAMES - 1

    def status(self, *, watch_frozen: bool = True) -> FloatArray:
        """Returns the guards' `frame_status` (3,): the share, frozen, stamp bad."""
        frozen = watch_frozen and self.frozen
        return np.array([self.invalid_share, float(frozen), float(self.stamp_bad)])


def stamp_is_new(check: FrameCheck, stamp: float, now: float) -> bool:
    """Whether a stamp, s, is that of a frame not seen yet, at the time `now`, s."""
    return check.stamp < stamp <= now + ROUNDING


def without_new_frame(check: FrameCheck, stamp: float) -> FrameCheck:
    """Returns what is known after a look at a stamp, s, that is no new frame's.

    The latest stamp again says that no frame has come, and so does -inf before the
    first; any other is bad, and is not kept: later frames must not be measured by it.
    """
    return FrameCheck(
        check.stamp,
        check.invalid_share,
        check.repeats,
        not abs(stamp - check.stamp) <= ROUNDING and stamp != check.stamp,
        check.bits,
    )


def with_frame(
    check: FrameCheck, depth: NDArray[np.float32], stamp: float
) -> FrameCheck:
    """Returns what is known after a new frame.

    Args:
        check: What was known before it.
        depth: (H, W), m; 0, NaN or infinite where nothing was measured.
        stamp: When it was taken, s, later than all before.

    The share is of the whole image: in front of walls 3 % of the pixels say nothing.

    Raises:
        ValueError: If the image is not of two dimensions or has no pixels.
    """
    if depth.ndim != 2 or depth.size == 0:
        raise ValueError(f"depth must have shape (H, W), got {depth.shape}")
    # A copy: the image is the camera's, who may write the next one into it.
    image = np.array(depth, dtype=np.float32, order="C")
    bits = image.view(np.int32)
    # NaN is neither.
    valid = np.count_nonzero((image > 0.0) & (image < np.inf))
    same = check.bits is not None and np.array_equal(bits, check.bits)
    bits.setflags(write=False)
    repeats = check.repeats + 1 if same else 0
    invalid = image.size - valid
    return FrameCheck(stamp, invalid / image.size, repeats, False, bits)
