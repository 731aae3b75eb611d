"""Files are written whole or not at all, also where there is no more room."""

import errno
import os
import subprocess
import sys

import pytest

from bath_drake import cli, files
from bath_drake.errors import DemonstrationError
from bath_drake.resources import models_folder

SKILL = models_folder() / "skills" / "back_sinusoid.yaml"
STROKE = models_folder() / "demonstrations" / "scrubbing_1.csv"


# In a process of its own no file can grow beyond 300 bytes: the kernel refuses in the
# middle of a write, as a full disk does, of which there is none to be had without being
# root. Not in this one: what pytest prints may go into a file as well.
NO_ROOM = """
import resource, signal, sys
from pathlib import Path
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (300, resource.RLIM_INFINITY))
"""


def without_room(code, *arguments):
    """Runs code in such a process; returns what became of it."""
    return subprocess.run(
        [sys.executable, "-c", NO_ROOM + code, *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )


WRITE = """
from bath_drake import files
path = Path(sys.argv[1])
try:
    files.write_atomically(path, bytes(1000))
except files.BathDrakeError as error:
    print(error)
"""


def test_a_file_that_finds_no_room_leaves_the_old_one_and_nothing_else(tmp_path):
    path = tmp_path / "a.csv"
    path.write_bytes(b"before")
    assert "cannot be written: File too large" in without_room(WRITE, path).stdout
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path]


WRITE_ALL = """
from bath_drake import files
folder = Path(sys.argv[1])
together = {folder / "old.yaml": b"after", folder / "new.yaml": b"new"}
try:
    files.write_all(together | {folder / "a.csv": bytes(1000)})
except files.BathDrakeError as error:
    print(error)
"""


def test_files_that_belong_together_find_room_together_or_stay(tmp_path):
    old = tmp_path / "old.yaml"
    old.write_bytes(b"before")
    assert "a.csv: cannot be written" in without_room(WRITE_ALL, tmp_path).stdout
    assert old.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [old]


def test_a_name_that_cannot_be_given_puts_the_others_back(tmp_path, monkeypatch):
    old, new = tmp_path / "old.yaml", tmp_path / "new.yaml"
    old.write_bytes(b"before")
    replace = os.replace

    def failing(source, path):
        if path.suffix == ".csv":
            raise OSError(errno.EIO, "the disk has gone")
        replace(source, path)

    monkeypatch.setattr(os, "replace", failing)
    together = {old: b"after", new: b"new", tmp_path / "a.csv": b""}
    with pytest.raises(DemonstrationError, match="the disk has gone"):
        files.write_all(together, error=DemonstrationError)
    assert old.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [old]


def test_files_that_belong_together_are_all_written(tmp_path):
    together = {tmp_path / "a.csv": b"a", tmp_path / "b.yaml": b"b"}
    files.write_all(together)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == together


APPEND = """
from bath_drake import files
path = Path(sys.argv[1])
try:
    files.append(path, "seven more\\n")
except files.BathDrakeError as error:
    print(error)
files.append(path, "ab\\n")
"""


def test_a_row_that_finds_no_room_is_cut_off_again(tmp_path):
    path = tmp_path / "rows.csv"
    path.write_bytes(b"x" * 295 + b"\n")
    assert "rows.csv: cannot be written" in without_room(APPEND, path).stdout
    assert path.read_bytes() == b"x" * 295 + b"\nab\n"


VERB = """
from bath_drake.cli import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize(
    "words",
    [
        ("import", str(STROKE)),
        ("reproduce", str(SKILL), "--start", "-0.5", "0.5"),
        ("certify", str(SKILL)),
        ("diagram", "reproduction"),
    ],
)
def test_a_verb_that_finds_no_room_says_so_and_leaves_the_old_file(words, tmp_path):
    out = tmp_path / {"diagram": "a.svg", "certify": "a.json"}.get(words[0], "a.csv")
    out.write_bytes(b"before")
    done = without_room(VERB, *words, "-o", out)
    assert done.returncode == cli.BAD_INPUT, done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    assert "File too large" in done.stderr
    assert out.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [out]
