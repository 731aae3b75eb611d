"""Files are read within limits, and written whole or not at all."""

import contextlib
import io
import os
import stat
import tempfile
import warnings
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from bath_drake.errors import BathDrakeError

_Error = type[BathDrakeError]


def read_bytes(path: str | Path, *, limit: int, error: _Error) -> bytes:
    """Returns a regular file's bytes; raises `error` if there is none or too many."""
    try:
        status = os.stat(path)
        # A pipe or a device would block or never end.
        if not stat.S_ISREG(status.st_mode):
            kind = "a directory" if stat.S_ISDIR(status.st_mode) else "not a file"
            raise error(f"{path}: found {kind}, expected a regular file")
        if status.st_size > limit:
            raise error(
                f"{path}: {status.st_size} bytes, at most {limit} bytes are allowed"
            )
        with open(path, "rb") as file:
            return file.read(limit + 1)[:limit]
    except OSError as problem:
        raise error(f"{path}: cannot be read: {problem.strerror}") from None
    except BathDrakeError:
        raise
    except ValueError as problem:
        raise error(f"{str(path)!r} is not a file name: {problem}") from None


def read_archive(
    path: str | Path, *, limit: int, unpacked: int | None = None, error: _Error
) -> dict[str, np.ndarray[Any, Any]]:
    """Returns the arrays of an .npz file by name.

    Args:
        path: The file.
        limit: Bytes that it has at most.
        unpacked: And that its arrays have; None for as many.
        error: What to raise.

    Raises:
        error: If it is missing, too large or damaged.
    """
    data = read_bytes(path, limit=limit, error=error)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            size = sum(member.file_size for member in archive.infolist())
        most = limit if unpacked is None else unpacked
        if size > most:
            raise error(f"{path}: unpacks to {size} bytes, allowed: {most}")
        # NumPy warns of headers it has to mend; none that it wrote itself.
        with warnings.catch_warnings(action="error"):
            with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
                return {key: arrays[key] for key in arrays.files}
    except error:
        raise
    # Whatever it is (zlib's errors, those of zip files, too little memory), the file
    # made the libraries raise it.
    except Exception as problem:
        told = (str(problem) or type(problem).__name__).splitlines()[0][:200]
        raise error(f"{path}: not a readable .npz file ({told})") from problem


def check_output(path: str | Path, *, error: _Error = BathDrakeError) -> None:
    """Raises `error` unless a file can be written at a path; touches nothing."""
    path = Path(path)
    if "\0" in str(path) or path.is_dir():
        raise error(f"{str(path)!r} is not the name of a file to write")
    if not path.parent.is_dir():
        raise error(f"{path}: folder {path.parent} does not exist")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise error(f"{path}: folder {path.parent} cannot be written to")


def remove(path: Path, *, error: _Error = BathDrakeError) -> None:
    """Removes a file, if there is one; raises `error` if that cannot be."""
    try:
        path.unlink(missing_ok=True)
    except OSError as problem:
        raise error(f"{path}: cannot be replaced: {problem.strerror}") from None


def write_atomically(
    path: str | Path,
    content: str | bytes | Callable[[Path], None],
    *,
    error: _Error = BathDrakeError,
) -> None:
    """Writes a file whole or not at all: a temporary neighbour, then one rename.

    Args:
        path: Where; an existing file is replaced.
        content: Text (written as UTF-8), bytes, or a function that writes the
            temporary file whose path (same suffix) it is given.
        error: The exception to raise.

    Raises:
        BathDrakeError: As `error`, when the file cannot be written.
    """
    staged = _stage(Path(path), content, error)
    try:
        _put(staged, Path(path), error)
    finally:
        _forget([staged])


def _stage(
    path: Path, content: str | bytes | Callable[[Path], None], error: _Error
) -> Path:
    """Writes what will be `path` beside it, down to the disk; returns where."""
    check_output(path, error=error)
    temporary: Path | None = None
    try:
        handle, name = tempfile.mkstemp(
            prefix=f".{path.stem[:100]}-", suffix=path.suffix, dir=path.parent
        )
        temporary = Path(name)
        os.close(handle)
        if callable(content):
            content(temporary)
        else:
            data = content.encode() if isinstance(content, str) else content
            temporary.write_bytes(data)
        # Renamed before its content is on disk, it could be empty after a power cut.
        with open(temporary, "rb") as file:
            os.fsync(file.fileno())
        # mkstemp makes files for the owner alone; give what `open` would have.
        os.umask(mask := os.umask(0))
        os.chmod(temporary, 0o666 & ~mask)
    except BaseException as problem:  # an interrupt, too, must leave nothing
        _forget([] if temporary is None else [temporary])
        if isinstance(problem, OSError):
            raise error(f"{path}: cannot be written: {problem.strerror}") from None
        raise
    return temporary


def _put(staged: Path, path: Path, error: _Error) -> None:
    """Gives a staged file its name; that takes no space."""
    try:
        os.replace(staged, path)
        _sync_folder(path.parent)
    except OSError as problem:
        raise error(f"{path}: cannot be written: {problem.strerror}") from None


def _forget(staged: Iterable[Path]) -> None:
    """Removes what is left of staged files; what cannot be must hide no other error."""
    for path in staged:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)


def _sync_folder(folder: Path) -> None:
    """After a power cut the file has its name as well."""
    held = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(held)
    finally:
        os.close(held)


def append(path: Path, text: str, *, error: _Error = BathDrakeError) -> None:
    """Adds text to a file, whole or not at all, down to the disk; else raises `error`.

    What a full disk took of it is cut off again.
    """
    try:
        size = path.stat().st_size if path.exists() else 0
        try:
            with open(path, "ab") as file:
                file.write(text.encode())
                file.flush()
                os.fsync(file.fileno())
        except OSError:
            with contextlib.suppress(OSError):
                os.truncate(path, size)
            raise
    except OSError as problem:
        raise error(f"{path}: cannot be written: {problem.strerror}") from None


def write_all(files: dict[Path, bytes], *, error: _Error = BathDrakeError) -> None:
    """Writes files that belong together, or puts back what was there before.

    All of them are on the disk before the first gets its name: a full one is noticed
    while every old file is still there.

    Raises:
        BathDrakeError: As `error`, when one cannot be written.
    """
    staged: dict[Path, Path] = {}
    before: dict[Path, bytes | None] = {}
    try:
        for path, content in files.items():
            staged[path] = _stage(path, content, error)
        for path, temporary in staged.items():
            old = path.read_bytes() if path.is_file() else None
            _put(temporary, path, error)
            before[path] = old
    except BaseException:  # an interrupt, too, must leave no half
        for path, old in before.items():
            if old is None:
                remove(path, error=error)
            else:
                write_atomically(path, old, error=error)
        raise
    finally:
        _forget(staged.values())
