"""A demonstration as the texts of its files, as `read_recording` reads them back."""

import hashlib
from pathlib import Path

import numpy as np

from bath_drake.demonstrations.metadata import RecordingMetadata, metadata_block
from bath_drake.demonstrations.recording import Recording
from bath_drake.notation import FloatArray
from bath_drake.yaml_io import dump_yaml

# Micrometres and microseconds are finer than any tracker.
_DIGITS = 6
RESOLUTION = 1e-6


def recording_text(t: FloatArray, points: FloatArray) -> str:
    """Returns the CSV text of a demonstration, in seconds and metres.

    Args:
        t: (n,) times, s.
        points: (n, 2) or (n, 3) m.
    """
    header = ["t_s", "x_m", "y_m", "z_m"][: 1 + points.shape[1]]
    # Adding zero turns -0.0 into 0.0.
    rows = np.round(np.column_stack([t, points]), _DIGITS) + 0.0
    lines = [",".join(f"{value:.{_DIGITS}f}" for value in row) for row in rows]
    return "\n".join([",".join(header), *lines, ""])


def as_it_will_be_read(
    path: Path, t: FloatArray, points: FloatArray, metadata: RecordingMetadata
) -> Recording:
    """Returns what `read_recording` will read at `path` once it is written."""
    text = recording_text(t, points)
    return Recording(
        path=path,
        t=np.round(t, _DIGITS),
        points=np.round(points, _DIGITS),
        metadata=metadata,
        sha256=hashlib.sha256(text.encode()).hexdigest(),
    )


def file_texts(recording: Recording) -> tuple[str, str]:
    """Returns the texts of NAME.csv and NAME.yaml."""
    metadata = dump_yaml(metadata_block(recording.metadata))
    return recording_text(recording.t, recording.points), metadata
