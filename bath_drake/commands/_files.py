"""Files that belong together: all of them are written, or none."""

from pathlib import Path


def write_all(files: dict[Path, bytes]) -> None:
    """Writes all files, or takes back those that were not there before.

    Raises:
        DemonstrationError: One cannot be written.
    """
    from bath_drake.errors import DemonstrationError
    from bath_drake.yaml_io import write_atomically

    new: list[Path] = []
    try:
        for path, content in files.items():
            there = path.exists()
            write_atomically(path, content, error=DemonstrationError)
            if not there:
                new.append(path)
    except DemonstrationError:
        for path in new:
            path.unlink(missing_ok=True)
        raise
