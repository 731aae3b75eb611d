"""Finds the shipped models and scenarios, in a checkout or in a wheel."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def _data_folder(name: str) -> Path:
    # A wheel carries the folders in _data; an editable install does not.
    for folder in (_PACKAGE / "_data" / name, _PACKAGE.parent / name):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"the {name} folder is missing from this installation")


def models_folder() -> Path:
    """Returns the folder of arm, people, scene, demonstrations and skills."""
    return _data_folder("models")


def diagrams_folder() -> Path:
    """Returns the folder of scenarios and wiring records."""
    return _data_folder("diagrams")
