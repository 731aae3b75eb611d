"""`bath-drake import`: a demonstration out of another program's recording."""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bath_drake.demonstrations.importing.demonstration import Imported
    from bath_drake.demonstrations.importing.source import ImportOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the file, the output and what may be said of each format."""
    parser.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help="CSV, NPZ, C3D, MMM XML, or a ROS 1 or 2 bag (docs/importing.md)",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="DEMO.csv",
        help="the demonstration; what else is known of it goes into DEMO.yaml",
    )
    parser.add_argument("--format", choices=["csv", "npz", "c3d", "mmm", "bag"])
    parser.add_argument("--units", choices=["m", "cm", "mm"], help="of lengths")
    parser.add_argument("--time-units", choices=["s", "ms", "us", "ns"])
    for name, key in (("time", "t"), ("x", "x"), ("y", "y"), ("z", "z")):
        parser.add_argument(
            f"--{name}", dest=f"column_{key}", metavar="NAME", help="column or array"
        )
    parser.add_argument(
        "--points",
        dest="column_points",
        metavar="NAME",
        help="NPZ: an array of shape (n, 2) or (n, 3)",
    )
    parser.add_argument("--marker", metavar="NAME", help="C3D: the hand's marker")
    parser.add_argument(
        "--body-markers",
        metavar="A,B,C,D",
        help="C3D: right and left shoulder, right and left hip (RSHO,LSHO,RPSI,LPSI); "
        "none: the path in the laboratory",
    )
    parser.add_argument("--topic", metavar="NAME", help="bag: the hand's poses")
    parser.add_argument(
        "--motion", metavar="NAME", help="MMM: the person's, where there are several"
    )
    parser.add_argument("--segment", metavar="NAME", help="MMM: the hand's segment")
    parser.add_argument(
        "--model", metavar="MODEL.xml", help="MMM: the model file with the kinematics"
    )
    for name, what in (("start", "before"), ("end", "after")):
        parser.add_argument(
            f"--{name}",
            type=float,
            metavar="S",
            help=f"leave out what is {what}, in the file's time",
        )


def run(options: argparse.Namespace) -> int:
    """Writes DEMO.csv and DEMO.yaml, or neither; returns 0."""
    from bath_drake.demonstrations.importing.demonstration import import_demonstration
    from bath_drake.demonstrations.processing import canonical_demonstrations
    from bath_drake.demonstrations.recording_text import file_texts
    from bath_drake.errors import DemonstrationError
    from bath_drake.files import write_all

    output: Path = options.output
    _check_output(output, options.file)
    found = import_demonstration(
        options.file, output, _import_options(options), options.format or ""
    )
    # What cannot be learned from is told now, and nothing is written.
    canonical_demonstrations([found.recording])
    table, metadata = file_texts(found.recording)
    write_all(
        {output.with_suffix(".yaml"): metadata.encode(), output: table.encode()},
        error=DemonstrationError,
    )
    print("\n".join(_summary(found, output)))
    return 0


def _check_output(output: Path, file: Path) -> None:
    from bath_drake.errors import DemonstrationError
    from bath_drake.files import check_output

    if output.suffix != ".csv":
        raise DemonstrationError(f"{output}: expected a name that ends in .csv")
    for path in (output, output.with_suffix(".yaml")):
        check_output(path, error=DemonstrationError)
        if path.resolve() == file.resolve():
            raise DemonstrationError(f"{path}: is the file that is imported")


def _import_options(options: argparse.Namespace) -> "ImportOptions":
    from bath_drake.demonstrations.importing.source import ImportOptions
    from bath_drake.errors import DemonstrationError

    body: tuple[str, ...] = ()
    if options.body_markers is not None:
        body = tuple(name.strip() for name in options.body_markers.split(","))
        if body != ("none",) and not (len(body) == 4 and all(body)):
            raise DemonstrationError(
                f"--body-markers: found {options.body_markers!r}, expected four names "
                "with commas between, or none"
            )
    for name in ("start", "end"):
        cut = getattr(options, name)
        if cut is not None and not math.isfinite(cut):
            raise DemonstrationError(f"--{name}: found {cut}, expected a finite number")
    columns = {
        key: getattr(options, f"column_{key}") for key in ("t", "x", "y", "z", "points")
    }
    return ImportOptions(
        units=options.units,
        time_units=options.time_units,
        columns={key: name for key, name in columns.items() if name is not None},
        marker=options.marker or "",
        body_markers=body,
        topic=options.topic or "",
        motion=options.motion or "",
        segment=options.segment or "",
        model=options.model or "",
        start=options.start,
        end=options.end,
    )


def _summary(found: "Imported", output: Path) -> list[str]:
    import numpy as np

    recording = found.recording
    span = np.ptp(recording.points, axis=0).max()
    lines = [
        f"read:     {found.kind}, {found.what}",
        f"stroke:   {recording.t.size} samples, {recording.t[-1]:.2f} s, "
        f"longest side {span:.3f} m",
    ]
    box = recording.metadata.body_box
    if box is not None:
        wide, tall = 100.0 * box.extents[:2]
        lines.append(f"body:     {wide:.1f} x {tall:.1f} cm")
    if found.missing:
        lines.append(f"missing:  {found.missing} samples of the file have no point")
    for gap in found.gaps:
        what = "filled" if gap.filled else "LEFT OPEN, longer than 0.2 s"
        lines.append(f"gap:      {gap.start:.2f} to {gap.end:.2f} s: {what}")
    lines += [f"note:     {note}" for note in found.notes]
    lines.append(f"written:  {output}, {output.with_suffix('.yaml')}")
    return lines
