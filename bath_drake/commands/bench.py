"""`bath-drake bench`: measures, and compares with what is to be reached."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the benchmark, where its figures go, and what single ones take."""
    from bath_drake.benchmarks.registry import BENCHMARKS, NAMES, users

    parser.add_argument(
        "name",
        metavar="NAME",
        help=f"one of {', '.join(NAMES)}; in this version: {', '.join(BENCHMARKS)}",
    )
    parser.add_argument(
        "--json", type=Path, metavar="FILE", help="write the figures here as well"
    )
    parser.add_argument(
        "--data",
        type=Path,
        metavar="DIR",
        help=f"a folder of data to run on ({users('data')})",
    )
    parser.add_argument(
        "--held-out",
        action="store_true",
        help=f"judge on data that were not learned from ({users('held_out')})",
    )
    parser.add_argument(
        "--peers",
        action="store_true",
        help=f"run other methods as well ({users('peers')})",
    )
    parser.add_argument(
        "--hours",
        type=float,
        metavar="H",
        help=f"how long to run for ({users('hours')})",
    )
    parser.add_argument(
        "--shapes",
        metavar="NAME,...",
        help=f"run on these shapes alone, without targets ({users('shapes')})",
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="a few seconds' effort a shape, without targets; washing without camera "
        f"and motors ({users('quick')})",
    )


def run(options: argparse.Namespace) -> int:
    """Returns 0 if all targets are met, 1 if not."""
    import json
    import math
    import time

    from bath_drake.benchmarks.figures import (
        Report,
        Settings,
        all_passed,
        row_table,
        rows_to_json,
        table,
        to_mapping,
    )
    from bath_drake.benchmarks.machine import machine, versions
    from bath_drake.benchmarks.registry import find
    from bath_drake.commands._progress import progress_bar
    from bath_drake.errors import BathDrakeError
    from bath_drake.files import check_output, write_atomically

    settings = Settings(
        data=options.data,
        held_out=options.held_out,
        peers=options.peers,
        hours=options.hours,
        shapes=_names(options.shapes),
        quick=options.quick,
    )
    benchmark = find(options.name, settings)
    if settings.data is not None and not settings.data.is_dir():
        found = str(settings.data)
        raise BathDrakeError(f"--data: found {found!r}, expected a folder")
    if settings.hours is not None and not 0.0 < settings.hours < math.inf:
        raise BathDrakeError(f"--hours: found {settings.hours}, allowed: above 0")
    if options.json is not None:
        check_output(options.json)
    # Before it starts: the load it makes itself is not what others did to it.
    about = {"machine": machine(), "versions": versions()}
    began = time.perf_counter()
    with progress_bar(
        total=1.0, bar_format="{desc} {bar} {percentage:.0f} % [{elapsed}]"
    ) as bar:

        def progress(what: str, share: float) -> None:
            bar.set_description_str(what, refresh=False)
            bar.n = share
            bar.refresh()

        outcome = benchmark.run(settings, progress)
    report = outcome if isinstance(outcome, Report) else Report(outcome)
    data = {
        "benchmark": options.name,
        "figures": to_mapping(report.figures),
        "rows": rows_to_json(report.rows),
        "seconds": time.perf_counter() - began,
        **about,
    }
    if options.json is not None:
        text = json.dumps(data, indent=2, allow_nan=False)
        write_atomically(options.json, text + "\n")
    if report.rows:
        print(row_table(report.rows) + "\n")
    print(table(report.figures))
    return 0 if all_passed(report.figures) else 1


def _names(text: str | None) -> tuple[str, ...]:
    """The names in a list with commas between.

    Raises:
        BathDrakeError: One is empty.
    """
    from bath_drake.errors import BathDrakeError

    if text is None:
        return ()
    names = tuple(name.strip() for name in text.split(","))
    if not all(names):
        raise BathDrakeError(f"--shapes: found {text!r}, expected NAME,NAME,...")
    return names
