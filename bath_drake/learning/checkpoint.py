"""What learning has computed so far, kept in a file that a kill cannot spoil.

Learning is a sequence of named steps, each a pure function of earlier steps and of a
random generator seeded by the step's own numbers. A checkpoint keeps their results;
a run that finds them there goes on where the last one ended, to the same end bit by
bit. The file only grows, record by record: any beginning of it is a checkpoint, and
what a kill tears off at the end is computed again.
"""

import fcntl
import hashlib
import io
import json
import os
import struct
import threading
import time
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

import numpy as np

from bath_drake.errors import CheckpointError
from bath_drake.notation import FloatArray

Arrays = dict[str, FloatArray]

_MAGIC = b"bath-drake checkpoint 1\n"
_HEAD = struct.Struct("<Q32s")  # a payload's length and SHA-256; then their CRC-32
_CRC = struct.Struct("<I")
# Waiting for the disk after every step of 50 ms would be felt.
_INTERVAL = 0.5


class Stopped(Exception):
    """Raised in place of a step that is not begun, since learning is to stop."""


class Steps(Protocol):
    """Where a part of learning keeps its steps."""

    def step(self, key: str, compute: Callable[[], Arrays]) -> Arrays:
        """As `Checkpoint.step`."""


@dataclass(frozen=True)
class Under:
    """The steps of one part of learning, under names of their own.

    Attributes:
        steps: Where they are kept.
        name: Goes before every key.
    """

    steps: Steps
    name: str

    def step(self, key: str, compute: Callable[[], Arrays]) -> Arrays:
        """As `Checkpoint.step`."""
        return self.steps.step(f"{self.name}/{key}", compute)


class Checkpoint:
    """Results of steps by name, in memory and in a file.

    The file is locked as long as the checkpoint is open. Any thread may use it.
    """

    def __init__(
        self,
        path: Path | None = None,
        identity: Mapping[str, Any] | None = None,
        *,
        resume: bool = False,
    ) -> None:
        """Opens a checkpoint.

        Args:
            path: The file, made if there is none; None keeps nothing.
            identity: What the results depend on, such as the demonstrations' hashes
                and the configuration: plain values that JSON keeps.
            resume: Whether a file that is there may be continued.

        Raises:
            CheckpointError: The file holds steps and ``resume`` is not set, is in use,
                is no checkpoint, is damaged, belongs to another ``identity``, or
                cannot be read or made.
        """
        self._path = path
        self._known: dict[str, bytes] = {}
        self._asked: set[str] = set()
        self._pending: list[bytes] = []
        self._guard = threading.Lock()
        self._stopping = False
        self._file = -1
        self._end = 0
        self._written = time.monotonic()
        if path is not None:
            self._file = _open_locked(path)
            try:
                self._load(path, json.loads(json.dumps(dict(identity or {}))), resume)
            except BaseException:
                os.close(self._file)
                raise
        self.found = len(self._known)
        """How many steps the file held when it was opened."""

    def step(self, key: str, compute: Callable[[], Arrays]) -> Arrays:
        """The result of the step ``key``: the stored one, or else ``compute()``.

        The arrays are the caller's own, contiguous, and the same whether they were
        stored or not. At most half a second of finished steps is not yet on disk.

        Raises:
            Stopped: `stop` was called, and the step is not stored.
            CheckpointError: The file cannot be written.
            ValueError: ``compute`` gave arrays of objects, or ``key`` was asked for
                before: two steps of one name would take each other's result.
        """
        with self._guard:
            if key in self._asked:
                raise ValueError(f"the step {key!r} is asked for twice")
            known = self._known.get(key)
        if known is None:
            if self._stopping:
                raise Stopped(key)
            known = _encode(key, compute())
            if self._path is not None:
                with self._guard:
                    self._known[key] = known
                    self._pending.append(_record(known))
                if time.monotonic() - self._written >= _INTERVAL:
                    self.flush()
        self._asked.add(key)
        return _decode(known)[1]

    def stop(self) -> None:
        """Lets no further step begin; a signal handler may call it."""
        self._stopping = True

    def flush(self) -> None:
        """Puts everything on disk; raises CheckpointError if that fails."""
        with self._guard:
            if self._path is None or self._file < 0 or not self._pending:
                return
            data = b"".join(self._pending)
            try:
                # From the last whole record on: an earlier try may have been cut.
                os.ftruncate(self._file, self._end)
                _write(self._file, data, self._end)
                os.fsync(self._file)
            except OSError as problem:
                raise CheckpointError(
                    f"{self._path}: cannot be written: {problem.strerror}"
                ) from None
            self._end += len(data)
            self._pending.clear()
            self._written = time.monotonic()

    def close(self) -> None:
        """Puts everything on disk and lets go of the file; without steps it goes."""
        try:
            if self._known:
                self.flush()
            elif self._path is not None and self._file >= 0:
                self._path.unlink(missing_ok=True)
        finally:
            if self._file >= 0:
                os.close(self._file)  # and with it the lock
                self._file = -1

    def remove(self) -> None:
        """Deletes the file, its work done."""
        self._known.clear()
        self._pending.clear()
        self.close()

    def __enter__(self) -> "Checkpoint":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _load(self, path: Path, identity: dict[str, Any], resume: bool) -> None:
        try:
            with open(self._file, "rb", closefd=False) as file:
                data = file.read()
        except OSError as problem:
            raise CheckpointError(
                f"{path}: cannot be read: {problem.strerror}"
            ) from None
        if data[: len(_MAGIC)] != _MAGIC[: len(data)]:
            raise CheckpointError(f"{path}: found no checkpoint of this version")
        payloads, self._end = _split(data, path)
        if len(payloads) < 2:  # new, or killed before its first step: nothing to lose
            self._end = 0
            self._pending = [_MAGIC, _record(json.dumps(identity).encode())]
            self.flush()
            return
        if not resume:
            raise CheckpointError(
                f"{path}: found the checkpoint of an unfinished run; "
                "continue it (--resume) or delete it"
            )
        differs = difference(json.loads(payloads[0]), identity)
        if differs is not None:
            raise CheckpointError(
                f"{path}: {differs}; continue with what it was begun with, or delete it"
            )
        self._known = {_decode(p)[0]: p for p in payloads[1:]}


def _open_locked(path: Path) -> int:
    """A descriptor of the file at ``path``, which nobody else holds."""
    try:
        while True:
            file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                # The holder before may just have deleted the file we opened.
                if os.fstat(file).st_nlink > 0:
                    return file
            except BaseException:
                os.close(file)
                raise
            os.close(file)
    except BlockingIOError:
        raise CheckpointError(f"{path}: another run is writing it") from None
    except OSError as problem:
        raise CheckpointError(f"{path}: cannot be opened: {problem.strerror}") from None


def _write(file: int, data: bytes, offset: int) -> None:
    view = memoryview(data)
    while view:
        count = os.pwrite(file, view, offset)
        view, offset = view[count:], offset + count


def _record(payload: bytes) -> bytes:
    head = _HEAD.pack(len(payload), hashlib.sha256(payload).digest())
    return head + _CRC.pack(zlib.crc32(head)) + payload


def _split(data: bytes, path: Path) -> tuple[list[bytes], int]:
    """All whole payloads, and where the last one ends."""
    payloads, at = [], len(_MAGIC)
    while len(data) >= at + _HEAD.size + _CRC.size:
        begin = at + _HEAD.size + _CRC.size
        head = data[at : at + _HEAD.size]
        length, digest = _HEAD.unpack(head)
        whole = _CRC.pack(zlib.crc32(head)) == data[at + _HEAD.size : begin]
        if whole and len(data) < begin + length:
            break
        payload = data[begin : begin + length]
        if not whole or hashlib.sha256(payload).digest() != digest:
            raise CheckpointError(
                f"{path}: byte {at}: found a damaged record; delete the file, "
                "and learning begins anew"
            )
        payloads.append(payload)
        at = begin + length
    return payloads, at


def difference(found: Mapping[str, Any], given: Mapping[str, Any]) -> str | None:
    """Where two trees of plain values differ first, in words; None if nowhere."""
    for key in sorted(found.keys() | given.keys()):
        ours, theirs = found.get(key), given.get(key)
        if isinstance(ours, dict) and isinstance(theirs, dict):
            inner = difference(ours, theirs)
            if inner is not None:
                return f"{key}.{inner}"
        elif ours != theirs:
            return f"{key}: found {_short(ours)}, this run has {_short(theirs)}"
    return None


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def _encode(key: str, arrays: Mapping[str, FloatArray]) -> bytes:
    out = io.BytesIO()
    out.write(json.dumps([key, list(arrays)]).encode() + b"\n")
    for array in arrays.values():
        np.lib.format.write_array(out, np.array(array, order="C"), allow_pickle=False)
    return out.getvalue()


def _decode(payload: bytes) -> tuple[str, Arrays]:
    stream = io.BytesIO(payload)
    key, names = json.loads(stream.readline())
    return key, {
        name: np.lib.format.read_array(stream, allow_pickle=False) for name in names
    }
