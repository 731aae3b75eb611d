"""A demonstration as the text of its CSV file, as `read_recording` reads it back."""

import numpy as np

from bath_drake.notation import FloatArray


def recording_text(t: FloatArray, points: FloatArray) -> str:
    """Returns the CSV text of a demonstration, in seconds and metres.

    Args:
        t: (n,) times, s.
        points: (n, 2) or (n, 3) m.
    """
    header = ["t_s", "x_m", "y_m", "z_m"][: 1 + points.shape[1]]
    # Micrometres and microseconds are finer than any tracker. Adding zero turns -0.0
    # into 0.0.
    rows = np.round(np.column_stack([t, points]), 6) + 0.0
    lines = [",".join(f"{value:.6f}" for value in row) for row in rows]
    return "\n".join([",".join(header), *lines, ""])
