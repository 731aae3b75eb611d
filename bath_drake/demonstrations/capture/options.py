"""What the user says about a recording."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class CaptureOptions:
    """What the user says about a recording; of the marker at most one thing.

    Attributes:
        marker_colour: RGB, 0 to 255.
        marker_box: First and last column and row (x0, y0, x1, y1) of a box around it
            in the first frame.
        marker_at: Column and row of one of its pixels in the first frame.
    """

    marker_colour: tuple[int, int, int] | None = None
    marker_box: tuple[int, int, int, int] | None = None
    marker_at: tuple[int, int] | None = None
