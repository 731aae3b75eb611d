"""Files are written whole or not at all, also where there is no more room."""

import errno
import os
import resource
import signal
import subprocess
import sys

import pytest

from bath_drake import cli, files
from bath_drake.errors import DemonstrationError
from bath_drake.resources import models_folder

SKILL = models_folder() / "skills" / "back_sinusoid.yaml"
STROKE = models_folder() / "demonstrations" / "scrubbing_1.csv"


@pytest.fixture
def no_room(tmp_path):
    """No file can grow beyond 300 bytes: the kernel refuses in the middle of a write.

    As a full disk does, of which there is none to be had without being root.
    """
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (300, before[1]))
    yield tmp_path
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, handler)


def test_a_file_that_finds_no_room_leaves_the_old_one_and_nothing_else(no_room):
    path = no_room / "a.csv"
    path.write_bytes(b"before")
    with pytest.raises(DemonstrationError, match="cannot be written: File too large"):
        files.write_atomically(path, bytes(1000), error=DemonstrationError)
    assert path.read_bytes() == b"before"
    assert list(no_room.iterdir()) == [path]


def test_files_that_belong_together_find_room_together_or_stay(no_room):
    old, new = no_room / "old.yaml", no_room / "new.yaml"
    old.write_bytes(b"before")
    together = {old: b"after", new: b"new", no_room / "a.csv": bytes(1000)}
    with pytest.raises(DemonstrationError, match=r"a\.csv: cannot be written"):
        files.write_all(together, error=DemonstrationError)
    assert old.read_bytes() == b"before"
    assert list(no_room.iterdir()) == [old]


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


def test_a_row_that_finds_no_room_is_cut_off_again(no_room):
    path = no_room / "rows.csv"
    path.write_bytes(b"x" * 295 + b"\n")
    with pytest.raises(DemonstrationError, match=r"rows\.csv: cannot be written"):
        files.append(path, "seven more\n", error=DemonstrationError)
    assert path.stat().st_size == 296
    files.append(path, "ab\n")
    assert path.read_bytes().endswith(b"x\nab\n")


# Of a verb's own process: what it says, and that nothing else was touched.
LIMITED = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (300, resource.RLIM_INFINITY))
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
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, *words, "-o", str(out)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == cli.BAD_INPUT, done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    assert "File too large" in done.stderr
    assert out.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [out]
