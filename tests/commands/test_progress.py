import contextlib
import os
import pty
import sys

import pytest

from bath_drake.commands._progress import progress_bar


def show(**options):
    with progress_bar(total=4, desc="washing", **options) as bar:
        bar.update(2)
        bar.refresh()


def read_all(reader):
    """What came through a pseudo-terminal: it comes in pieces, and ends in an error."""
    pieces = []
    with contextlib.suppress(OSError):
        while piece := os.read(reader, 65536):
            pieces.append(piece)
    return b"".join(pieces)


def test_in_a_pipe_there_is_no_bar(capsys):
    show()
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("size", [(0, 0), (100, 30)])
def test_a_terminal_sees_it_even_if_it_does_not_know_its_size(monkeypatch, size):
    reader, writer = pty.openpty()
    monkeypatch.setattr(os, "get_terminal_size", lambda _: os.terminal_size(size))
    with os.fdopen(writer, "w", encoding="utf-8") as terminal:
        monkeypatch.setattr(sys, "stderr", terminal)
        # A new pseudo-terminal has no size; what tqdm would find is given here.
        given = {"ncols": 100, "nrows": 30} if size[0] else {}
        show(**given)
    seen = read_all(reader).decode()
    os.close(reader)
    assert "washing" in seen
    assert "50%" in seen
