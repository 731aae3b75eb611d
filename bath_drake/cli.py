"""The command line `bath-drake VERB`: parse, call one function, print."""

import argparse
import errno
import importlib
import keyword
import logging
import os
import re
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from bath_drake import __version__
from bath_drake.errors import BathDrakeError

# Verb -> what it does. Each is a module of bath_drake.commands, imported only
# when asked for: Drake, Open3D and numba take seconds to import.
VERBS = {
    "demo": "demonstrations -> learned skill -> closed loop -> report",
    "capture": "a demonstration out of an RGB-D recording of a marker",
    "perceive": "what perception makes of an RGB-D recording, no simulator",
    "import": "a demonstration out of a C3D, MMM, NPZ or CSV file or a ROS bag",
    "show": "plot what demonstration files hold, before anyone learns from them",
    "learn": "learn one skill from one or more demonstration files",
    "reproduce": "roll a skill out, no simulator",
    "certify": "check that a field has no trap",
    "reach": "whether the arm gets all over the path, and from where it would",
    "simulate": "build a scenario's Diagram, run it closed-loop, judge it",
    "report": "write report.html out of a run's folder",
    "diagram": "draw a scenario's block diagram",
    "bench": "measure, and compare with what is to be reached",
    "doctor": "what is installed, what is missing, the line that fixes it",
}
BAD_INPUT = 2
INTERRUPTED = 130
# No more room: on the disk, of a quota, in a file.
_NO_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


class _Parser(argparse.ArgumentParser):
    """A parser that takes -9.3e-05 for a number and errs on one line."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**{"allow_abbrev": False, **kwargs})
        # argparse (before 3.14) takes a number in exponent form for an option.
        self._negative_number_matcher = re.compile(
            r"^-(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?$"
        )

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {message} (see {self.prog} --help)\n")


def _build_parser(verb: str | None) -> argparse.ArgumentParser:
    parser = _Parser(
        prog="bath-drake",
        description="Washing motions learned from a carer, on Drake. "
        "Research software: not certified for use on people.",
    )
    parser.add_argument("--version", action="version", version=__version__)
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for name, summary in VERBS.items():
        child = verbs.add_parser(name, help=summary, description=summary)
        child.add_argument("-v", "--verbose", action="store_true", help="say more")
        if name == verb:
            _command(name).add_arguments(child)
    return parser


def _command(verb: str) -> Any:
    module = f"{verb}_" if keyword.iskeyword(verb) else verb
    return importlib.import_module(f"bath_drake.commands.{module}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one verb; returns its exit code (2 for bad input)."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    verb = next((word for word in words if not word.startswith("-")), None)
    options = _build_parser(verb if verb in VERBS else None).parse_args(words)
    logging.basicConfig(
        level=logging.DEBUG if options.verbose else logging.WARNING,
        format="%(levelname)s %(name)s: %(message)s",
    )
    for chatty in ("matplotlib", "numba", "PIL", "drake"):
        logging.getLogger(chatty).setLevel(logging.WARNING)
    try:
        return int(_command(options.verb).run(options))
    except BathDrakeError as error:
        # Names out of hostile files break no line and move no cursor.
        told = "".join(c if c.isprintable() else "?" for c in str(error))
        print(f"bath-drake {options.verb}: {told}", file=sys.stderr)
        return BAD_INPUT
    except BrokenPipeError:
        # A reader such as `head` has gone; that is no error of ours.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as problem:
        if problem.errno not in _NO_SPACE:
            raise
        # Nobody's input, but no bug either: numba keeps what it compiles, for one.
        where = f"{problem.filename}: " if problem.filename else ""
        print(f"bath-drake {options.verb}: {where}{problem.strerror}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print(f"bath-drake {options.verb}: interrupted", file=sys.stderr)
        return INTERRUPTED
