"""Reads the shapes that benchmarks of reproduction run on."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.io import loadmat
from scipy.io.matlab import MatReadError

from bath_drake.benchmarks.reproduction import Shape
from bath_drake.demonstrations.processing import canonical_demonstrations
from bath_drake.demonstrations.recording import read_recording
from bath_drake.errors import BathDrakeError
from bath_drake.notation import FloatArray

_TAKE = re.compile(r"(?P<name>.+)_(?P<number>\d+)")
WHERE_LASA_IS = (
    "the LASA handwriting data set's .mat files, as in the public repository "
    "nbfigueroa/ds-opt"
)


def stroke_shapes(folder: Path, wanted: Sequence[str] = ()) -> list[Shape]:
    """Shapes of demonstration files NAME_1.csv, NAME_2.csv, ..., denoised.

    Args:
        folder: Where they are.
        wanted: Their names; none means all.

    Raises:
        BathDrakeError: A name is unknown, a file cannot be used.
    """
    takes: dict[str, list[tuple[int, Path]]] = {}
    for path in folder.glob("*.csv"):
        parts = _TAKE.fullmatch(path.stem)
        if parts:
            takes.setdefault(parts["name"], []).append((int(parts["number"]), path))
    shapes = []
    for name in _choose(sorted(takes), wanted):
        recordings = [read_recording(path) for _, path in sorted(takes[name])]
        _check_count(folder / name, len(recordings))
        found, _ = canonical_demonstrations(recordings)
        shapes.append(Shape.of(name, [(d.times, d.points) for d in found]))
    return shapes


def lasa_shapes(folder: Path | None, wanted: Sequence[str] = ()) -> list[Shape]:
    """Shapes of the LASA data set: NAME.mat, each with its `demos` (pos, t).

    Args:
        folder: Where the files are.
        wanted: Names of shapes; none means all.

    Raises:
        BathDrakeError: There is no folder or no such file in it, a name is unknown,
            or a file is of another kind.
    """
    if folder is None:
        raise BathDrakeError(f"lasa: --data DIR is needed: a folder of {WHERE_LASA_IS}")
    paths = {path.stem: path for path in folder.glob("*.mat")}
    if not paths:
        raise BathDrakeError(
            f"--data: no .mat file in {folder}, expected {WHERE_LASA_IS}"
        )
    names = _choose(sorted(paths, key=str.lower), wanted)
    return [Shape.of(name, _lasa_takes(paths[name])) for name in names]


def _choose(names: Sequence[str], wanted: Sequence[str]) -> Sequence[str]:
    for name in wanted:
        if name not in names:
            raise BathDrakeError(
                f"--shapes: found {name!r}, allowed: {', '.join(names)}"
            )
    return [name for name in names if not wanted or name in wanted]


def _check_count(what: Path, count: int) -> None:
    if count < 2:
        raise BathDrakeError(f"{what}: {count} demonstrations, at least 2 are needed")


def _lasa_takes(path: Path) -> list[tuple[FloatArray, FloatArray]]:
    try:
        content = loadmat(path, squeeze_me=True, struct_as_record=False)
    except (OSError, ValueError, NotImplementedError, MatReadError) as problem:
        reason = str(problem).splitlines()[0] if str(problem) else "damaged"
        raise BathDrakeError(
            f"{path}: no MATLAB file that can be read ({reason}), "
            f"expected one of {WHERE_LASA_IS}"
        ) from None
    if "demos" not in content:
        raise BathDrakeError(f"{path}: no variable demos, expected {WHERE_LASA_IS}")
    takes = []
    for number, demo in enumerate(np.atleast_1d(content["demos"]), start=1):
        where = f"{path}: demos{{{number}}}"
        try:
            points = np.asarray(demo.pos, dtype=np.float64).T
            times = np.asarray(demo.t, dtype=np.float64).ravel()
        except (AttributeError, TypeError, ValueError):
            raise BathDrakeError(
                f"{where}: expected a struct with numbers pos and t"
            ) from None
        if points.shape != (len(times), 2) or len(times) < 2:
            raise BathDrakeError(
                f"{where}: pos has shape {points.T.shape} and t {times.shape}, "
                "expected (2, n) and (n,), n > 1"
            )
        if not (np.isfinite(points).all() and np.isfinite(times).all()):
            raise BathDrakeError(f"{where}: a number is not finite")
        if (np.diff(times) < 0.0).any():
            raise BathDrakeError(f"{where}: t decreases, expected times in order")
        if not np.ptp(points, axis=0).max() > 0.0:
            raise BathDrakeError(f"{where}: all points are one")
        takes.append((times, points))
    _check_count(path, len(takes))
    return takes
