"""One process at a time writes into a run's folder."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bath_drake.errors import RunFolderError


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keeps other processes from writing into an existing folder.

    The lock is on the folder itself: it leaves nothing behind, and is gone with the
    process, however that ends. It does not nest.

    Raises:
        RunFolderError: If another process has it, or there is no such folder.
    """
    try:
        held = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except OSError as error:
        reason = error.strerror or str(error)
        raise RunFolderError(f"{folder}: not a folder of a run ({reason})") from None
    try:
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise RunFolderError(
                f"{folder}: another run is writing it, allowed one at a time; wait for "
                "it or choose another folder"
            ) from None
        yield
    finally:
        os.close(held)
