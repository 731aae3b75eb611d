"""C3D files of motion capture: one marker's path, in the back's frame if it is there.

With the four markers of shoulders and hips (by default those of the Plug-in Gait set)
the path is told from the moving body: frame B has its origin amid the four, x to the
person's right, y to the head and z out of the back. Without them it stays in the
laboratory's frame.
"""

import io
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.demonstrations.gaps import fill_gaps
from bath_drake.demonstrations.importing.source import (
    ImportOptions,
    Track,
    listed,
)
from bath_drake.demonstrations.metadata import MAX_EXTENT, BodyBox
from bath_drake.demonstrations.recording import LENGTH_UNITS
from bath_drake.errors import DemonstrationError
from bath_drake.notation import FloatArray

MAX_BYTES = 512 * 1024 * 1024
# Right shoulder, left shoulder, right hip, left hip (Plug-in Gait).
BACK_MARKERS = ("RSHO", "LSHO", "RPSI", "LPSI")
_WORKER = "bath_drake.demonstrations.importing.c3d_worker"
_PACKAGES = Path(__file__).parents[3]
# For --body-markers: the path stays in the laboratory's frame.
NO_BODY = "none"
_BLOCK = 512
# What the parameters' fourth byte tells of numbers as PCs write them.
_INTEL = 84
# The header counts frames in 16 bits; the library reads no more of them.
_MOST_FRAMES = 65535


def read_c3d(path: Path, options: ImportOptions) -> Track:
    """Reads one marker of a C3D file.

    Raises:
        DemonstrationError: Naming the file and what is wrong or missing in it.
    """
    content = _content(path)
    names = [name.strip() for name in content["labels"].tolist()]
    points, rate = content["points"], float(content["rate"])
    # Files may name more markers than they hold.
    names = names[: points.shape[1]]
    if len(names) < points.shape[1]:
        raise DemonstrationError(
            f"{path}: has names of {len(names)} markers, and {points.shape[1]} markers"
        )
    unit = _unit(path, str(content["unit"]).strip(), options)
    if not 0.0 < rate < np.inf:
        raise DemonstrationError(f"{path}: found a frame rate of {rate} Hz")
    first = int(content["first"])
    count = points.shape[2]
    t = np.arange(count) / rate
    hand = _marker(path, names, points, options.marker) * unit
    places = tuple(f"frame {first + k + 1}" for k in range(count))
    what = f"marker {options.marker}"
    asked = options.body_markers or BACK_MARKERS
    bare = {name.split(":")[-1] for name in names}
    if asked == (NO_BODY,) or not (options.body_markers or set(asked) <= bare):
        return Track(t, hand, what, places, frame="laboratory")
    corners = [
        _marker(path, names, points, name, "--body-markers") * unit for name in asked
    ]
    hand, box = _on_back(path, t, hand, corners)
    return Track(t, hand, what, places, box, "back")


def _content(path: Path) -> dict[str, Any]:
    try:
        size = path.stat().st_size
        with path.open("rb") as file:
            head = file.read(_BLOCK)
            file.seek(_BLOCK * (head[0] - 1 if head else 0))
            parameters = file.read(4)
    except OSError as problem:
        raise DemonstrationError(
            f"{path}: cannot be read: {problem.strerror}"
        ) from None
    if size > MAX_BYTES:
        raise DemonstrationError(f"{path}: {size} bytes, allowed: {MAX_BYTES}")
    # The library believes the header, whatever memory that takes.
    if len(head) < _BLOCK or head[1] != 0x50:
        raise DemonstrationError(f"{path}: no C3D file (its header is not one)")
    if parameters[3:] == bytes([_INTEL]):
        _check_size(path, head, size)
    # Modules of the folder one happens to be in are not the worker's (-P), and threads
    # would eat the memory it is allowed.
    command = [sys.executable, "-P", "-m", _WORKER, str(path.resolve())]
    there = [str(_PACKAGES), os.environ.get("PYTHONPATH", "")]
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(filter(None, there)),
        "OPENBLAS_NUM_THREADS": "1",
    }
    done = subprocess.run(command, capture_output=True, check=False, env=environment)
    if done.returncode:
        told = done.stderr.decode(errors="replace").strip().splitlines()
        crashed = done.returncode < 0 or not told
        reason = "the reader crashed on it" if crashed else told[-1]
        raise DemonstrationError(f"{path}: not a readable C3D file ({reason})")
    with np.load(io.BytesIO(done.stdout), allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}


def _check_size(path: Path, head: bytes, size: int) -> None:
    """Refuses headers that promise more frames than the file is long."""
    words = np.frombuffer(head, dtype="<u2")
    markers, analog, first, last = (int(words[k]) for k in (1, 2, 3, 4))
    scale = float(np.frombuffer(head, dtype="<f4", count=1, offset=12)[0])
    word = 4 if scale < 0.0 else 2
    frames = last - first + 1
    data = int(words[8])
    needed = frames * (4 * markers + analog) * word
    if last >= _MOST_FRAMES:
        raise DemonstrationError(
            f"{path}: has {last} frames or more, allowed: {_MOST_FRAMES - 1}; cut the "
            "stroke out where it was recorded"
        )
    if frames > 0 and needed > size - _BLOCK * max(data - 1, 0):
        raise DemonstrationError(
            f"{path}: truncated: {frames} frames of {markers} markers take {needed} "
            f"bytes, the file has {max(size - _BLOCK * max(data - 1, 0), 0)}"
        )


def _unit(path: Path, told: str, options: ImportOptions) -> float:
    if options.units is None and told not in LENGTH_UNITS:
        raise DemonstrationError(
            f"{path}: found the unit {told[:40]!r}, allowed: "
            f"{', '.join(LENGTH_UNITS)}; say which with --units"
        )
    return options.metres(told if told in LENGTH_UNITS else "mm")


def _marker(
    path: Path,
    names: list[str],
    points: FloatArray,
    name: str,
    option: str = "--marker",
) -> FloatArray:
    """A marker's path (n, 3) in the file's units; NaN where it was not seen.

    Systems put the subject's name before that of the marker, with a colon between.
    """
    if not name:
        raise DemonstrationError(
            f"{path}: say which marker is the hand's with --marker; there are: "
            f"{listed(names)}"
        )
    found = [k for k, own in enumerate(names) if own == name]
    found = found or [k for k, own in enumerate(names) if own.split(":")[-1] == name]
    if len(found) != 1:
        how = "no marker" if not found else f"{len(found)} markers"
        raise DemonstrationError(
            f"{path}: found {how} {name!r}; say which with {option}; there are: "
            f"{listed(names)}"
        )
    track = points[:, found[0]].T.copy()
    # Some systems write zeros where they saw nothing.
    track[(track == 0.0).all(axis=1)] = np.nan
    return track


def _on_back(
    path: Path, t: FloatArray, hand: FloatArray, corners: list[FloatArray]
) -> tuple[FloatArray, BodyBox]:
    """The hand in frame B of the back, and the back's box there."""
    right_top, left_top, right_low, left_low = (fill_gaps(t, c)[0] for c in corners)
    head = 0.5 * (right_top + left_top - right_low - left_low)
    right = 0.5 * (right_top + right_low - left_top - left_low)
    tall, wide = (
        np.linalg.norm(head, axis=1),
        np.linalg.norm(right_top - left_top, axis=1),
    )
    # Corners in one place are as good as not seen.
    y = head / np.where(tall > 0.0, tall, np.nan)[:, None]
    x = right - (right * y).sum(axis=1, keepdims=True) * y
    across = np.linalg.norm(x, axis=1, keepdims=True)
    x = x / np.where(across > 0.0, across, np.nan)
    R_BL = np.stack([x, y, np.cross(x, y)], axis=1)
    centre = 0.25 * (right_top + left_top + right_low + left_low)
    on_back = np.einsum("nij,nj->ni", R_BL, hand - centre)
    if not np.isfinite(on_back).any():
        raise DemonstrationError(
            f"{path}: the body's markers and the hand's are never seen together"
        )
    extents = np.array([np.nanmean(wide), np.nanmean(tall)])
    if not (extents <= MAX_EXTENT).all():
        raise DemonstrationError(
            f"{path}: the body's markers are {extents[0]:.3g} m and {extents[1]:.3g} m "
            f"apart, allowed: {MAX_EXTENT:g} m (millimetres? then --units mm)"
        )
    return on_back, BodyBox(np.zeros(3), np.eye(3), extents)
