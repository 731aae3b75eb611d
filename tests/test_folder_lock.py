"""One process at a time writes into a run's folder."""

import signal
import subprocess
import sys

import pytest

from bath_drake import cli
from bath_drake.errors import RunFolderError
from bath_drake.files import remove
from bath_drake.folder_lock import locked

HOLDER = """
import sys, time
from pathlib import Path
from bath_drake.folder_lock import locked
with locked(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that has the folder."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(tmp_path)],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


def test_a_second_process_is_refused_and_told_which_folder(tmp_path, holder):
    with pytest.raises(RunFolderError, match="another run is writing it"):
        with locked(tmp_path):
            pass


def test_a_killed_process_leaves_the_folder_free_and_empty(tmp_path, holder):
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    with locked(tmp_path):
        assert not list(tmp_path.iterdir())


def test_the_report_of_a_run_that_goes_on_is_refused(tmp_path, holder, capsys):
    assert cli.main(["report", str(tmp_path)]) == 2
    assert str(tmp_path) in capsys.readouterr().err


def test_a_folder_that_is_none_is_refused(tmp_path):
    with pytest.raises(RunFolderError, match="not a folder of a run"):
        with locked(tmp_path / "nothing"):
            pass


def test_what_cannot_be_removed_is_an_error_of_ours(tmp_path):
    with pytest.raises(RunFolderError, match="cannot be replaced"):
        remove(tmp_path, error=RunFolderError)
