import itertools

import pytest

from bath_drake.cli import main
from bath_drake.demonstrations.recording import read_recording


@pytest.fixture
def imported(tmp_path, capsys):
    """Runs the verb; returns the recording, or None, and what was said."""
    numbers = itertools.count()

    def run(file, *words):
        output = tmp_path / f"demo_{next(numbers)}.csv"
        code = main(["import", str(file), "-o", str(output), *map(str, words)])
        told = capsys.readouterr()
        if code:
            assert code == 2
            assert told.err.count("\n") == 1
            assert not output.exists()
            assert not output.with_suffix(".yaml").exists()
            return None, told.err
        return read_recording(output), told.out

    return run
