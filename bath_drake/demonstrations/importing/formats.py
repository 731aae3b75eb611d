"""Which reader a file is for."""

import os
from collections.abc import Callable
from pathlib import Path

from bath_drake.demonstrations.importing.c3d import read_c3d
from bath_drake.demonstrations.importing.mmm import read_mmm
from bath_drake.demonstrations.importing.ros_bag import read_bag
from bath_drake.demonstrations.importing.source import ImportOptions, Track
from bath_drake.demonstrations.importing.table import read_csv, read_npz
from bath_drake.errors import DemonstrationError

READERS: dict[str, Callable[[Path, ImportOptions], Track]] = {
    "csv": read_csv,
    "npz": read_npz,
    "c3d": read_c3d,
    "mmm": read_mmm,
    "bag": read_bag,
}
_SUFFIXES = {
    ".csv": "csv",
    ".tsv": "csv",
    ".txt": "csv",
    ".npz": "npz",
    ".c3d": "c3d",
    ".xml": "mmm",
    ".bag": "bag",
    ".mcap": "bag",
    ".db3": "bag",
}
# What each reader asks for besides --start and --end.
_TABLE = ("units", "time_units", "t", "x", "y", "z")
_OPTIONS = {
    "csv": _TABLE,
    "npz": (*_TABLE, "points"),
    "c3d": ("units", "marker", "body_markers"),
    "mmm": ("units", "motion", "segment", "model"),
    "bag": ("units", "topic"),
}
_FLAGS = {"time_units": "time-units", "body_markers": "body-markers", "t": "time"}


def format_of(path: Path, told: str = "") -> str:
    """The name of a file's format: as told, or by its suffix; a folder is a bag.

    Raises:
        DemonstrationError: The file is not there, or its suffix says nothing.
    """
    if not os.path.exists(path):
        raise DemonstrationError(f"{path}: no such file")
    folder = os.path.isdir(path)
    if folder and told in ("", "bag"):
        return "bag"
    # A pipe or a device would block or never end.
    if not os.path.isfile(path):
        what = "a directory" if folder else "not a file"
        raise DemonstrationError(f"{path}: found {what}, expected a regular file")
    if told:
        return told
    found = _SUFFIXES.get(path.suffix.lower())
    if found is None:
        raise DemonstrationError(
            f"{path}: its suffix {path.suffix!r} tells no format; say which with "
            f"--format: {', '.join(READERS)}"
        )
    return found


def read_track(path: Path, options: ImportOptions, told: str = "") -> tuple[Track, str]:
    """Reads a track of any known format; returns it and the format's name.

    Raises:
        DemonstrationError: Naming the file and what is wrong or missing in it.
    """
    kind = format_of(path, told)
    for name in options.told():
        if name not in _OPTIONS[kind]:
            raise DemonstrationError(
                f"{path}: --{_FLAGS.get(name, name)} says nothing of this format "
                f"({kind}), allowed: "
                + ", ".join(f"--{_FLAGS.get(name, name)}" for name in _OPTIONS[kind])
            )
    track = READERS[kind](path, options)
    return track.between(options.start, options.end), kind
