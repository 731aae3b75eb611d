"""What is wrong with a camera's frames, whatever they show."""

import math
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# So many equal images in a row are one image given again and again: noise repeats
# itself once by accident sooner than twice.
FROZEN_AFTER = 3


@dataclass(frozen=True)
class FrameCheck:
    """What is known after a frame.

    Attributes:
        stamp: Of the frame before, or this one, whichever is later, s.
        digest: Of its depth.
        equal: How many images in a row were this very one, this one included.
        invalid_share: Of its pixels, those whose depth is no number, or not positive;
            what is out of the sensor's range says that much and is none of them.
        went_back: Whether its stamp was before that of the frame before.
    """

    stamp: float = -math.inf
    digest: int = 0
    equal: int = 0
    invalid_share: float = 0.0
    went_back: bool = False

    @property
    def frozen(self) -> bool:
        """Whether the camera gives one image again and again."""
        return self.equal >= FROZEN_AFTER


def check_frame(
    before: FrameCheck, stamp: float, depth: NDArray[np.float32]
) -> FrameCheck:
    """Checks the newest frame; one that has been checked changes nothing.

    Args:
        before: What was known.
        stamp: When it was taken, s; NaN counts as gone back.
        depth: (H, W), m; infinite beyond the sensor's range.
    """
    if stamp == before.stamp and not before.went_back:
        return before
    if stamp == -math.inf:
        return before
    went_back = not stamp >= before.stamp
    digest = zlib.crc32(np.ascontiguousarray(depth).view(np.uint8).data)
    invalid = np.count_nonzero(~(depth > 0.0))
    return FrameCheck(
        stamp=before.stamp if went_back else stamp,
        digest=digest,
        equal=before.equal + 1 if digest == before.digest and before.equal else 1,
        invalid_share=float(invalid / max(depth.size, 1)),
        went_back=went_back,
    )
