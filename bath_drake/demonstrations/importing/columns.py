"""Which column or array of a table is what, and in which unit, by their names."""

import itertools
import re
from pathlib import Path

from bath_drake.demonstrations.importing.source import (
    TIME_UNITS,
    ImportOptions,
    listed,
)
from bath_drake.demonstrations.recording import LENGTH_UNITS
from bath_drake.errors import DemonstrationError

# What programs call them, in lower case, without a unit.
_TIME = ("t", "time", "timestamp", "stamp", "secs", "seconds", "sec")
_PREFIXES = ("", "p", "pos", "position", "t", "trans", "translation", "hand", "tip")
_SPACED = re.compile(r"[\s.\-/\[\]()]+")


def choose_columns(
    path: Path, names: list[str], options: ImportOptions
) -> dict[str, str]:
    """Which column is t, x, y and z: as told, or as their names say.

    Raises:
        DemonstrationError: A name that was told is not there, or names leave a choice;
            with the names there are.
    """
    asked = {key: options.columns[key] for key in "xyz" if key in options.columns}
    for key, name in asked.items():
        if name not in names:
            raise DemonstrationError(
                f"{path}: --{key}: found no column {name!r}; allowed: {listed(names)}"
            )
    chosen = {"t": choose_time(path, names, options), **asked}
    if asked:
        twice = [
            name for name in chosen.values() if list(chosen.values()).count(name) > 1
        ]
        if twice:
            raise DemonstrationError(
                f"{path}: column {twice[0]!r} is told twice; allowed: {listed(names)}"
            )
        missing = [key for key in "xy" if key not in asked]
        if missing:
            raise DemonstrationError(
                f"{path}: --{missing[0]} is missing beside --{next(iter(asked))}; "
                f"allowed: {listed(names)}"
            )
        return chosen
    triples = []
    for prefix in _PREFIXES:
        found = {key: _named(names, prefix, key) for key in "xyz"}
        if found["x"] and found["y"]:
            # Every choice that the names leave.
            choices = itertools.product(*(found[key] or [""] for key in "xyz"))
            triples += [
                {k: name for k, name in zip("xyz", choice, strict=True) if name}
                for choice in choices
            ]
    if len(triples) != 1:
        told = "no" if not triples else f"{len(triples)} sets of"
        raise DemonstrationError(
            f"{path}: found {told} columns that are x, y and z by their names; say "
            f"which with --x, --y and --z; there are: {listed(names)}"
        )
    return chosen | triples[0]


def choose_time(path: Path, names: list[str], options: ImportOptions) -> str:
    """Which column is the time; raises DemonstrationError as `choose_columns`."""
    told = options.columns.get("t")
    if told is not None:
        if told not in names:
            raise DemonstrationError(
                f"{path}: --time: found no column {told!r}; allowed: {listed(names)}"
            )
        return told
    found = [name for name in names if _bare(name)[0] in _TIME]
    if len(found) != 1:
        count = "no column" if not found else f"{len(found)} columns"
        raise DemonstrationError(
            f"{path}: found {count} that are the time by their names; say which with "
            f"--time; there are: {listed(names)}"
        )
    return found[0]


def _named(names: list[str], prefix: str, key: str) -> list[str]:
    wanted = {f"{prefix}{key}", f"{prefix}_{key}", f"{key}_{prefix}"} - {f"{key}_"}
    return [name for name in names if _bare(name)[0] in wanted]


def _bare(name: str) -> tuple[str, str | None]:
    """A column's name without its unit, and the unit."""
    parts = [part for part in _SPACED.split(name.strip().lower()) if part]
    words = "_".join(parts).split("_")
    if len(words) > 1 and words[-1] in (*LENGTH_UNITS, "s", "ms", "us", "ns"):
        return "_".join(words[:-1]), words[-1]
    return "_".join(words), None


def factor(path: Path, name: str, key: str, options: ImportOptions) -> float:
    """The factor to seconds or metres of a column, by its name or as told."""
    known = TIME_UNITS if key == "t" else LENGTH_UNITS
    option = "--time-units" if key == "t" else "--units"
    told = options.time_units if key == "t" else options.units
    unit = told or _bare(name)[1] or ("s" if key == "t" else "m")
    if unit not in known:
        raise DemonstrationError(
            f"{path}: column {name!r} is {key} and in {unit} by its name, allowed: "
            f"{', '.join(known)}; say which with {option}"
        )
    return known[unit]
