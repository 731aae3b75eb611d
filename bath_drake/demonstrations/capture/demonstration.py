"""A captured stroke as a demonstration: its files' text, and how it will be read."""

import hashlib
from pathlib import Path

import numpy as np

from bath_drake import __version__
from bath_drake.demonstrations.capture.pipeline import Capture
from bath_drake.demonstrations.metadata import (
    BodyBox,
    RecordingMetadata,
    metadata_block,
)
from bath_drake.demonstrations.recording import Recording
from bath_drake.demonstrations.recording_text import recording_text
from bath_drake.yaml_io import dump_yaml


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
    text = recording_text(found.stroke.t, found.stroke.points)
    return Recording(
        path=path,
        t=np.round(found.stroke.t, 6),
        points=np.round(found.stroke.points, 6),
        metadata=metadata,
        sha256=hashlib.sha256(text.encode()).hexdigest(),
    )


def file_texts(recording: Recording) -> tuple[str, str]:
    """Returns the texts of NAME.csv and NAME.yaml."""
    metadata = dump_yaml(metadata_block(recording.metadata))
    return recording_text(recording.t, recording.points), metadata
