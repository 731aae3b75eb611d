"""A progress bar on a terminal, silent in a pipe."""

import os
import sys
from typing import Any

from tqdm import tqdm


def progress_bar(**options: Any) -> "tqdm[Any]":
    """A tqdm on standard error; takes its options.

    tqdm shows nothing on a terminal of 0 rows and columns, which is what those say
    that do not know their size (under `script` or `docker exec`, say): 80 by 24 then.
    """
    shown = sys.stderr.isatty()
    if shown and 0 in _terminal_size():
        options = {"ncols": 80, "nrows": 24, **options}
    return tqdm(disable=not shown, **options)


def _terminal_size() -> tuple[int, int]:
    try:
        columns, lines = os.get_terminal_size(sys.stderr.fileno())
    except (OSError, ValueError):
        return 0, 0
    return columns, lines
