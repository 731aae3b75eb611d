"""Files that belong together: all of them are written, or none."""

from pathlib import Path


def write_all(files: dict[Path, bytes]) -> None:
    """Writes all files, or puts back what was there before.

    Raises:
        DemonstrationError: One cannot be written.
    """
    from bath_drake.errors import DemonstrationError
    from bath_drake.yaml_io import write_atomically

    before: dict[Path, bytes | None] = {}
    try:
        for path, content in files.items():
            old = path.read_bytes() if path.is_file() else None
            write_atomically(path, content, error=DemonstrationError)
            before[path] = old
    except BaseException:  # an interrupt, too, must leave no half
        for path, old in before.items():
            if old is None:
                path.unlink(missing_ok=True)
            else:
                write_atomically(path, old, error=DemonstrationError)
        raise
