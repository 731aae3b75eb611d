"""`bath-drake report`."""

import argparse
from pathlib import Path

from bath_drake.folder_lock import locked
from bath_drake.report.page import write_report


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Takes the folder of a run."""
    parser.add_argument("folder", metavar="DIR", type=Path, help="a run's folder")


def run(options: argparse.Namespace) -> int:
    """Writes report.html, prints its path; returns 0."""
    with locked(options.folder):
        page = write_report(options.folder)
    print(page)
    return 0
