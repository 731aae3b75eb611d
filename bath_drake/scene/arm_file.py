"""Finds an arm's model, and what a file beside it says of the arm."""

from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.errors import ScenarioError
from bath_drake.resources import models_folder
from bath_drake.schema import fill
from bath_drake.yaml_block import Block
from bath_drake.yaml_io import read_yaml

SHIPPED = "fr3_nozzle"
# What a scenario may leave out where the arm's file gives it.
_PLACED = (
    "base_position",
    "base_yaw",
    "home",
    "posture",
    "stiffness",
    "damping",
)


@dataclass(kw_only=True)
class ArmFile:
    """NAME.yaml beside NAME.urdf; every key may be left out."""

    base_position: list[float] | None = None  # m, W
    base_yaw: float | None = None  # rad
    home: list[float] | None = None  # rad
    posture: list[float] | None = None  # rad
    stiffness: list[float] | None = None  # N m/rad
    damping: list[float] | None = None  # N m s/rad
    # Link (0 the base, 8 the nozzle, in link 7's frame), a segment's two ends in its
    # frame, m, and a radius, m. None: fitted to the collision geometry.
    capsules: list[list[float]] | None = field(default=None)


def shipped_arms() -> list[str]:
    """Returns the names of the arms that ship."""
    folder = models_folder() / "arm"
    return sorted(path.stem for path in folder.glob("*_nozzle.urdf"))


def find_arm(model: str) -> Path:
    """Returns the URDF of a shipped arm's name, or of a path.

    Raises:
        ValueError: "model: found ..., allowed ..." if there is none.
    """
    path = Path(model)
    if model in shipped_arms():
        path = models_folder() / "arm" / f"{model}.urdf"
    if path.suffix != ".urdf" or "\0" in model or not path.is_file():
        raise ValueError(
            f"model: found {model[:60]!r}, allowed {', '.join(shipped_arms())}, or the "
            "path of a .urdf file"
        )
    return path


def read_arm_file(urdf: Path) -> ArmFile:
    """Returns what the file beside a URDF says; nothing if there is none.

    Raises:
        ScenarioError: Naming file and key, what was found and what is allowed.
    """
    path = urdf.with_suffix(".yaml")
    if not path.is_file():
        return ArmFile()
    return _read(path, path.stat().st_mtime_ns)


@cache
def _read(path: Path, changed: int) -> ArmFile:
    block = Block(read_yaml(path, error=ScenarioError), str(path), error=ScenarioError)
    found = fill(ArmFile, block)
    for key in ("home", "posture", "stiffness", "damping"):
        _check_numbers(path, key, getattr(found, key), 7)
    _check_numbers(path, "base_position", found.base_position, 3)
    for k, row in enumerate(found.capsules or []):
        _check_numbers(path, f"capsules[{k}]", row, 8)
    return found


def _check_numbers(path: Path, key: str, found: list[float] | None, size: int) -> None:
    if found is not None and (len(found) != size or not np.isfinite(found).all()):
        raise ScenarioError(f"{path}: {key}: found {found}, allowed {size} numbers")


def completed(given: dict[str, Any]) -> dict[str, Any]:
    """Returns the values of an `ArmConfig` of which some are given.

    Another arm than the one that ships first has its own home: its file's, or one that
    is given.

    Raises:
        ValueError: "key: found ..., allowed ..." if there is no such arm, or it has no
            home or posture.
    """
    model = given.get("model", SHIPPED)
    urdf = find_arm(model)
    if model == SHIPPED:
        return given
    told = read_arm_file(urdf)
    values = {
        key: getattr(told, key) for key in _PLACED if getattr(told, key) is not None
    }
    values |= given
    for key in ("home", "posture"):
        if key not in values:
            raise ValueError(
                f"{key}: found none, allowed seven angles, rad, for {urdf.name} has no"
                f" {urdf.with_suffix('.yaml').name} beside it that gives them"
            )
    return values
