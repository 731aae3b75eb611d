"""Arrays out of a person's .npz files, read strictly."""

from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.errors import ScenarioError
from bath_drake.files import read_archive

_MAX_BYTES = 64 * 1024 * 1024


def read_arrays(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    """Returns the arrays of an .npz file by name.

    Raises:
        ScenarioError: If it is missing, too large or damaged.
    """
    return read_archive(path, limit=_MAX_BYTES, error=ScenarioError)


def take_array(
    path: Path, arrays: dict[str, np.ndarray[Any, Any]], key: str
) -> np.ndarray[Any, Any]:
    """Returns the array of a name; ScenarioError if there is none."""
    if key not in arrays:
        found = ", ".join(sorted(arrays)) or "nothing"
        raise ScenarioError(f"{path}: {key} is missing, found {found}")
    return arrays[key]
