"""What lists of frames have in common: lines, times, and files inside the folder."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from bath_drake.errors import DemonstrationError
from bath_drake.files import read_bytes

MAX_BYTES = 16 * 1024 * 1024


@dataclass(frozen=True)
class FrameFiles:
    """One frame's files.

    Attributes:
        t: When it was taken, s.
        colour: The colour image.
        depth: The depth image.
        place: File and line that name them, for messages.
    """

    t: float
    colour: Path
    depth: Path
    place: str


def read_lines(path: Path) -> list[str]:
    """Returns a text file's lines; raises DemonstrationError if it is none."""
    data = read_bytes(path, limit=MAX_BYTES, error=DemonstrationError)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        raise DemonstrationError(
            f"{path}: byte {problem.start} is not UTF-8 text"
        ) from None
    return text.rstrip().splitlines()


def parse_time(cell: str, place: str) -> float:
    """Returns a cell as a finite number; raises DemonstrationError naming `place`."""
    try:
        t = float(cell)
    except ValueError:
        t = math.nan
    if not math.isfinite(t):
        raise DemonstrationError(f"{place}: found {cell[:40]!r}, expected a time")
    return t


def file_inside(folder: Path, name: str, place: str) -> Path:
    """Returns a file named relative to the folder.

    Raises:
        DemonstrationError: Naming `place`, if the name leads out of the folder or
            there is no such file.
    """
    pure = PurePosixPath(name)
    if "\0" in name or pure.is_absolute() or ".." in pure.parts:
        raise DemonstrationError(
            f"{place}: found {name[:60]!r}, expected a file inside the folder"
        )
    path = folder / pure
    if not path.is_file():
        raise DemonstrationError(f"{place}: the file {name[:60]!r} is missing")
    return path


def check_increasing(frames: Sequence[FrameFiles]) -> None:
    """Raises DemonstrationError naming the first frame not later than the last."""
    for before, frame in itertools.pairwise(frames):
        if not frame.t > before.t:
            raise DemonstrationError(
                f"{frame.place}: time {frame.t:.9g} s does not increase after "
                f"{before.t:.9g} s"
            )
