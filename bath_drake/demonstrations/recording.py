"""Reads a recorded demonstration: NAME.csv and, if there is one, NAME.yaml."""

import hashlib
import math
import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bath_drake.demonstrations.canonical import read_only
from bath_drake.demonstrations.metadata import RecordingMetadata, read_metadata
from bath_drake.errors import DemonstrationError
from bath_drake.files import read_bytes
from bath_drake.notation import FloatArray

MAX_BYTES = 16 * 1024 * 1024
# Fewer samples tell no stroke from noise, and the smoothing spline needs five.
MIN_POINTS = 5
# A washing stroke fits on a body. A wider one is in other units.
MAX_SPAN = 10.0
# Beyond this distance from the origin a float64 metre loses the hand's motion.
MAX_DISTANCE = 1e6
# A path that stays within a micrometre is a point.
MIN_SPAN = 1e-6

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
LENGTH_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}

# A column's name: t, x_m, `y (mm)`, `z [cm]`, or x_m with a remark in parentheses.
_COLUMN = re.compile(
    r"(?P<name>[a-z]+)"
    r"(?:_(?P<suffix>[a-z]+))?"
    r"(?:\s*[(\[]\s*(?P<bracket>[^)\]]*)[)\]])?",
    re.IGNORECASE,
)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?", re.ASCII)


@dataclass(frozen=True, eq=False)
class Recording:
    """One recorded demonstration, in the coordinates it was recorded in.

    Attributes:
        path: The CSV file.
        t: Times, shape (n,), s, strictly increasing.
        points: Positions, shape (n, 2) or (n, 3), m, in the file's own frame.
        metadata: What NAME.yaml says; all defaults if there is none.
        sha256: Hash of the CSV file's bytes, hexadecimal.
    """

    path: Path
    t: FloatArray
    points: FloatArray
    metadata: RecordingMetadata
    sha256: str

    @property
    def name(self) -> str:
        """The file's name without folder and suffix."""
        return self.path.stem


def read_recording(path: str | Path) -> Recording:
    """Reads a demonstration file.

    The CSV has one header line (with or without a leading ``#``) that names the
    columns t, x, y and optionally z, in any order; a name may carry its unit
    (``t_s``, ``x_mm``, ``x (mm)``), otherwise it is seconds and metres. Units are
    converted to seconds and metres. NAME.yaml beside it is optional.

    Raises:
        DemonstrationError: Naming file and line or key, when a file cannot be
            read, is no such table, or holds no motion.
    """
    path = Path(path)
    data = read_bytes(path, limit=MAX_BYTES, error=DemonstrationError)
    lines = csv_text(path, data).rstrip().splitlines()
    if not lines:
        raise DemonstrationError(
            f"{path}: the file is empty, expected a header line and rows t, x, y[, z]"
        )
    names, units = _header(path, lines[0])
    table = _rows(path, lines, len(names))
    columns = {
        name: table[:, i] * unit
        for i, (name, unit) in enumerate(zip(names, units, strict=True))
    }
    t = columns.pop("t")
    points = np.stack([columns[name] for name in sorted(columns)], axis=-1)
    _check_motion(path, t, points)
    metadata_path = path.with_suffix(".yaml")
    metadata = RecordingMetadata()
    if metadata_path != path and os.path.lexists(metadata_path):
        metadata = read_metadata(metadata_path)
        if metadata.body_box is not None and points.shape[1] != 3:
            raise DemonstrationError(
                f"{metadata_path}: body_box: needs 3-D points, but {path} has columns "
                "t, x, y only"
            )
    return Recording(
        path=path,
        t=read_only(t),
        points=read_only(points),
        metadata=metadata,
        sha256=hashlib.sha256(data).hexdigest(),
    )


def csv_text(path: Path, data: bytes) -> str:
    """A file's bytes as text; DemonstrationError if they are none."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        raise DemonstrationError(
            f"{path}: byte {problem.start} is not UTF-8 text, expected a CSV file"
        ) from None
    if "\0" in text:
        raise DemonstrationError(f"{path}: binary data, expected a CSV file")
    return text


def _header(path: Path, line: str) -> tuple[list[str], list[float]]:
    """Returns the columns' names and the factors to seconds and metres."""
    allowed = "expected a header such as t_s,x_m,y_m[,z_m]"
    # Commas within parentheses belong to a remark.
    cells = re.split(r",(?![^(]*\))", line.strip().lstrip("#"))
    if all(_NUMBER.fullmatch(cell.strip()) for cell in cells):
        raise DemonstrationError(f"{path}: line 1: no header, {allowed}")
    names: list[str] = []
    units: list[float] = []
    for cell in cells:
        match = _COLUMN.fullmatch(cell.strip())
        name = match["name"].lower() if match else ""
        if match is None or name not in ("t", "x", "y", "z"):
            raise DemonstrationError(
                f"{path}: line 1: unknown column {cell.strip()[:40]!r}, {allowed}"
            )
        if name in names:
            raise DemonstrationError(f"{path}: line 1: column {name} is there twice")
        known = TIME_UNITS if name == "t" else LENGTH_UNITS
        unit = match["suffix"] or match["bracket"] or ("s" if name == "t" else "m")
        if unit.strip() not in known:
            raise DemonstrationError(
                f"{path}: line 1: unknown unit {unit[:40]!r} of column {name}, "
                f"allowed: {', '.join(known)}"
            )
        names.append(name)
        units.append(known[unit.strip()])
    missing = [name for name in ("t", "x", "y") if name not in names]
    if missing:
        raise DemonstrationError(
            f"{path}: line 1: column {', '.join(missing)} is missing, {allowed}"
        )
    return names, units


def _rows(path: Path, lines: list[str], width: int) -> FloatArray:
    table = np.empty((len(lines) - 1, width))
    for index, line in enumerate(lines[1:]):
        place = f"{path}: line {index + 2}"
        cells = [cell.strip() for cell in line.split(",")]
        if len(cells) != width:
            raise DemonstrationError(
                f"{place}: found {len(cells) if line.strip() else 0} values, "
                f"expected {width}"
            )
        for column, cell in enumerate(cells):
            number = float(cell) if _NUMBER.fullmatch(cell) else math.nan
            if not math.isfinite(number):
                raise DemonstrationError(
                    f"{place}: found {cell[:40]!r}, expected a finite number"
                )
            table[index, column] = number
    return table


def _check_motion(path: Path, t: FloatArray, points: FloatArray) -> None:
    if t.size < MIN_POINTS:
        raise DemonstrationError(
            f"{path}: {t.size} points, at least {MIN_POINTS} are needed"
        )
    backwards = np.flatnonzero(np.diff(t) <= 0.0)
    if backwards.size:
        row = int(backwards[0])
        raise DemonstrationError(
            f"{path}: line {row + 3}: time {t[row + 1]:.9g} s does not increase "
            f"after {t[row]:.9g} s"
        )
    span = float(np.max(np.ptp(points, axis=0)))
    if span > MAX_SPAN or float(np.max(np.abs(points))) > MAX_DISTANCE:
        raise DemonstrationError(
            f"{path}: the path spans {span:.4g} m, at most {MAX_SPAN:g} m are allowed "
            "(millimetres? then name the columns x_mm, y_mm)"
        )
    if span < MIN_SPAN:
        raise DemonstrationError(
            f"{path}: the path has no length (it spans {span:.3g} m)"
        )
