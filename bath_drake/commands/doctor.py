"""`bath-drake doctor`."""

import argparse

from bath_drake.doctor import run_doctor


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Takes no arguments of its own."""


def run(options: argparse.Namespace) -> int:
    """Returns 0 if all is well, 1 if not."""
    return run_doctor()
