"""A captured stroke as a demonstration: its files' text, and how it will be read."""

from pathlib import Path

import numpy as np

from bath_drake import __version__
from bath_drake.demonstrations.capture.pipeline import Capture
from bath_drake.demonstrations.metadata import BodyBox, RecordingMetadata
from bath_drake.demonstrations.recording import Recording
from bath_drake.demonstrations.recording_text import as_it_will_be_read


def demonstration(found: Capture, path: Path, source: Path) -> Recording:
    """Returns what `read_recording` will read from the files of a capture.

    Args:
        found: The capture.
        path: Of the CSV file.
        source: The recording's folder.
    """
    extents = 2.0 * found.body.canonical_map.half_extents
    metadata = RecordingMetadata(
        frame="back",
        body_box=BodyBox(np.zeros(3), np.eye(3), np.round(extents, 6)),
        source=f"{source.resolve().name}, by bath-drake capture {__version__}",
        gaps=tuple(
            (round(gap.start, 6), round(gap.end, 6))
            for gap in found.stroke.gaps
            if not gap.filled
        ),
    )
    return as_it_will_be_read(path, found.stroke.t, found.stroke.points, metadata)
