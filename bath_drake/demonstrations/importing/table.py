"""Tables of any program: CSV with columns of other names, NPZ with arrays."""

import csv
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from bath_drake.demonstrations.importing.columns import (
    choose_columns,
    choose_time,
    factor,
)
from bath_drake.demonstrations.importing.source import (
    ImportOptions,
    Track,
    listed,
)
from bath_drake.demonstrations.recording import csv_text
from bath_drake.errors import DemonstrationError
from bath_drake.files import read_archive, read_bytes
from bath_drake.notation import FloatArray

MAX_BYTES = 64 * 1024 * 1024
# An archive may hold far more than its own size.
MAX_UNPACKED_BYTES = 512 * 1024 * 1024


def read_csv(path: Path, options: ImportOptions) -> Track:
    """Reads a table of text: one line of names, then rows; commas, semicolons or tabs.

    Empty cells and NaN are gaps. Lines that begin with # are remarks.

    Raises:
        DemonstrationError: Naming the file and the line or the column.
    """
    data = read_bytes(path, limit=MAX_BYTES, error=DemonstrationError)
    text = csv_text(path, data)
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(lines) < 2:
        raise DemonstrationError(
            f"{path}: found {len(lines)} lines, expected names and rows"
        )
    head = lines[0][1]
    delimiter = max(",;\t", key=head.count)
    names = [name.strip() for name in next(csv.reader([head], delimiter=delimiter))]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise DemonstrationError(
            f"{path}: line {lines[0][0]}: {twice!r} is there twice"
        )
    chosen = choose_columns(path, names, options)
    rows, places = [], []
    for number, line in lines[1:]:
        cells = next(csv.reader([line], delimiter=delimiter))
        if len(cells) != len(names):
            raise DemonstrationError(
                f"{path}: line {number}: found {len(cells)} values, expected "
                f"{len(names)}"
            )
        place = f"line {number}"
        rows.append(
            [_number(path, place, cells[names.index(name)]) for name in chosen.values()]
        )
        places.append(place)
    table = np.array(rows, dtype=np.float64)
    columns = {key: table[:, k] for k, key in enumerate(chosen)}
    return _track(path, columns, chosen, options, tuple(places))


def read_npz(path: Path, options: ImportOptions) -> Track:
    """Reads arrays of an .npz file: a time and three coordinates, or an (n, 2 or 3).

    Raises:
        DemonstrationError: Naming the file and the array.
    """
    arrays = _arrays(path, options)
    wanted = options.columns.get("points")
    planes = {
        name: a for name, a in arrays.items() if a.ndim == 2 and a.shape[1] in (2, 3)
    }
    single = {name: a for name, a in arrays.items() if a.ndim == 1}
    if wanted is None and "x" not in options.columns and len(planes) == 1:
        (wanted,) = planes
    if wanted is None:
        chosen = choose_columns(path, list(single), options)
        columns = {key: single[name] for key, name in chosen.items()}
    else:
        if wanted not in planes:
            raise DemonstrationError(
                f"{path}: --points: found no array {wanted!r} of shape (n, 2) or "
                f"(n, 3); allowed: {listed(planes)}"
            )
        time = choose_time(path, list(single), options)
        points = planes[wanted]
        columns = {"t": single[time]}
        columns |= dict(zip("xyz", points.T, strict=False))
        chosen = {"t": time, "points": wanted}
    lengths = {len(column) for column in columns.values()}
    if len(lengths) > 1:
        told = ", ".join(f"{key} {len(column)}" for key, column in columns.items())
        raise DemonstrationError(f"{path}: arrays of unlike lengths: {told}")
    return _track(path, columns, chosen, options, ())


def _track(
    path: Path,
    columns: Mapping[str, FloatArray],
    chosen: Mapping[str, str],
    options: ImportOptions,
    places: tuple[str, ...],
) -> Track:
    in_unit = {
        key: column
        * factor(path, chosen.get(key, chosen.get("points", "")), key, options)
        for key, column in columns.items()
    }
    return Track(
        t=in_unit["t"],
        points=np.stack([in_unit[key] for key in "xyz" if key in columns], axis=-1),
        what="columns " + ", ".join(chosen.values()),
        places=places,
    )


def _number(path: Path, place: str, cell: str) -> float:
    cell = cell.strip()
    if not cell:
        return math.nan
    try:
        # `float` takes 1_000 as well; no table means that.
        return float(cell.replace("_", "?"))
    except ValueError:
        raise DemonstrationError(
            f"{path}: {place}: found {cell[:40]!r}, expected a number or nothing"
        ) from None


def _arrays(path: Path, options: ImportOptions) -> dict[str, FloatArray]:
    found = read_archive(
        path, limit=MAX_BYTES, unpacked=MAX_UNPACKED_BYTES, error=DemonstrationError
    )
    arrays = {
        name: array.astype(np.float64)
        for name, array in found.items()
        if array.dtype.kind in "fiu"
    }
    if not arrays:
        raise DemonstrationError(f"{path}: found no arrays of numbers")
    return arrays
