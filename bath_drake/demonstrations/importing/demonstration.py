"""An imported track as a demonstration."""

from dataclasses import dataclass
from pathlib import Path

from bath_drake import __version__
from bath_drake.demonstrations.gaps import Gap
from bath_drake.demonstrations.importing.checks import check_track
from bath_drake.demonstrations.importing.formats import read_track
from bath_drake.demonstrations.importing.source import ImportOptions
from bath_drake.demonstrations.metadata import RecordingMetadata
from bath_drake.demonstrations.recording import Recording
from bath_drake.demonstrations.recording_text import as_it_will_be_read


@dataclass(frozen=True, eq=False)
class Imported:
    """What came of a file.

    Attributes:
        recording: As it will be read from the files it is written to.
        kind: Name of the format.
        what: What was read of the file, in words.
        gaps: All gaps, filled or not.
        missing: Samples of the file with no point.
        notes: What looks like another unit, in words.
    """

    recording: Recording
    kind: str
    what: str
    gaps: tuple[Gap, ...]
    missing: int
    notes: tuple[str, ...]


def import_demonstration(
    file: Path, output: Path, options: ImportOptions, told: str = ""
) -> Imported:
    """Reads a file of any known format as a demonstration, and checks it.

    Args:
        file: What is imported.
        output: Of the CSV file it will be.
        options: What is said of the file.
        told: The format's name; empty: by the suffix.

    Raises:
        DemonstrationError: Naming the file, what was found and what is allowed.
    """
    track, kind = read_track(file, options, told)
    checked = check_track(file, track)
    units = f", units {options.units}" if options.units else ""
    metadata = RecordingMetadata(
        frame=track.frame,
        body_box=track.box,
        source=f"{file.resolve().name} ({kind}, {track.what}{units}), by bath-drake "
        f"import {__version__}",
        gaps=tuple(
            (round(gap.start, 6), round(gap.end, 6))
            for gap in checked.gaps
            if not gap.filled
        ),
    )
    recording = as_it_will_be_read(output, checked.t, checked.points, metadata)
    return Imported(
        recording, kind, track.what, checked.gaps, checked.missing, checked.notes
    )
