"""Arrays out of a person's .npz files, read strictly."""

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.errors import ScenarioError
from bath_drake.files import read_bytes

_MAX_BYTES = 64 * 1024 * 1024


def read_arrays(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    """Returns the arrays of an .npz file by name.

    Raises:
        ScenarioError: If it is missing, too large or damaged.
    """
    data = read_bytes(path, limit=_MAX_BYTES, error=ScenarioError)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            size = sum(member.file_size for member in archive.infolist())
        if size > _MAX_BYTES:
            raise ScenarioError(
                f"{path}: unpacks to {size} bytes, allowed {_MAX_BYTES}"
            )
        with np.load(io.BytesIO(data), allow_pickle=False) as archive_of_arrays:
            return {key: archive_of_arrays[key] for key in archive_of_arrays.files}
    except (zipfile.BadZipFile, ValueError, OSError, EOFError, KeyError) as error:
        if isinstance(error, ScenarioError):
            raise
        raise ScenarioError(f"{path}: not a readable .npz file ({error})") from error


def take_array(
    path: Path, arrays: dict[str, np.ndarray[Any, Any]], key: str
) -> np.ndarray[Any, Any]:
    """Returns the array of a name; ScenarioError if there is none."""
    if key not in arrays:
        found = ", ".join(sorted(arrays)) or "nothing"
        raise ScenarioError(f"{path}: {key} is missing, found {found}")
    return arrays[key]
