"""`bath-drake capture`: a demonstration out of an RGB-D recording of a marker."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bath_drake.demonstrations.capture.pipeline import Capture


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the recording, the output and what may be said of the marker."""
    parser.add_argument(
        "folder", type=Path, metavar="FOLDER", help="the recording (docs/rgbd.md)"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="DEMO.csv",
        help="the stroke in the back's frame; its body box goes into DEMO.yaml, an "
        "overview into DEMO.png",
    )
    marker = parser.add_mutually_exclusive_group()
    marker.add_argument(
        "--marker-colour",
        type=_integers("R,G,B", 3, 255),
        metavar="R,G,B",
        help="the marker's colour, 0 to 255 each; if nothing is said of the marker, it "
        "is the one small vivid blob that is no skin",
    )
    marker.add_argument(
        "--marker-at",
        type=_integers("X,Y", 2),
        metavar="X,Y",
        help="column and row of a pixel of the marker in the first frame",
    )
    marker.add_argument(
        "--marker-box",
        type=_integers("X0,Y0,X1,Y1", 4),
        metavar="X0,Y0,X1,Y1",
        help="a box around the marker in the first frame",
    )


def _integers(
    form: str, count: int, largest: int = 1_000_000
) -> Callable[[str], tuple[int, ...]]:
    def parse(text: str) -> tuple[int, ...]:
        numbers = text.split(",")
        if len(numbers) != count or not all(
            n.isascii() and n.isdigit() and len(n) < 8 and int(n) <= largest
            for n in numbers
        ):
            raise argparse.ArgumentTypeError(
                f"found {text[:40]!r}, expected {form}, whole numbers from 0 to "
                f"{largest}"
            )
        return tuple(int(n) for n in numbers)

    return parse


def run(options: argparse.Namespace) -> int:
    """Writes DEMO.csv, DEMO.yaml and DEMO.png, or none of them; returns 0."""
    import io

    from bath_drake.commands._progress import progress_bar
    from bath_drake.demonstrations.capture.demonstration import demonstration
    from bath_drake.demonstrations.capture.options import CaptureOptions
    from bath_drake.demonstrations.capture.pipeline import capture
    from bath_drake.demonstrations.processing import canonical_demonstrations
    from bath_drake.demonstrations.recording_text import file_texts
    from bath_drake.demonstrations.rgbd.folder import open_rgbd
    from bath_drake.errors import DemonstrationError
    from bath_drake.files import write_all
    from bath_drake.report import style
    from bath_drake.report.capture_figure import draw_capture

    output: Path = options.output
    _check_outputs(output, options.folder)
    recording = open_rgbd(options.folder)
    said = CaptureOptions(
        marker_colour=options.marker_colour,
        marker_box=options.marker_box,
        marker_at=options.marker_at,
    )
    with progress_bar(desc="capturing", unit="frame") as bar:

        def progress(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        found = capture(recording, said, progress)
    stroke = demonstration(found, output, options.folder)
    # What cannot be learned from is told now, and nothing is written.
    (learned,), _ = canonical_demonstrations([stroke])
    picture = io.BytesIO()
    with style.figure_style():
        figure = draw_capture(recording, found, learned)
        figure.savefig(picture, format="png", dpi=110, metadata={"Software": None})
    table, metadata = file_texts(stroke)
    write_all(
        {
            output.with_suffix(".png"): picture.getvalue(),
            output.with_suffix(".yaml"): metadata.encode(),
            output: table.encode(),
        },
        error=DemonstrationError,
    )
    print("\n".join(_summary(found, len(recording), output)))
    return 0


def _check_outputs(output: Path, folder: Path) -> None:
    """All three can be written, and none is a part of the recording."""
    from bath_drake.demonstrations.rgbd.writer import TIMESTAMPS
    from bath_drake.errors import DemonstrationError
    from bath_drake.files import check_output

    if output.suffix != ".csv":
        raise DemonstrationError(f"{output}: expected a name that ends in .csv")
    for suffix in (".csv", ".yaml", ".png"):
        check_output(output.with_suffix(suffix), error=DemonstrationError)
    if output.resolve() == (folder / TIMESTAMPS).resolve():
        raise DemonstrationError(f"{output}: is a file of the recording")


def _summary(found: "Capture", frames: int, output: Path) -> list[str]:
    stroke, half = found.stroke, found.body.canonical_map.half_extents
    rgb = ",".join(map(str, found.marker.rgb))
    lines = [
        f"marker:   {2e3 * found.radius:.0f} mm wide, colour {rgb}",
        f"back:     {2e2 * half[0]:.1f} x {2e2 * half[1]:.1f} cm",
        f"stroke:   {stroke.t.size} samples of {frames} frames, "
        f"{stroke.t[0]:.2f} to {stroke.t[-1]:.2f} s",
    ]
    for gap in stroke.gaps:
        what = "filled" if gap.filled else "LEFT OPEN, longer than 0.2 s"
        lines.append(
            f"gap:      {gap.start:.2f} to {gap.end:.2f} s, marker {gap.reason}: {what}"
        )
    paths = (output, output.with_suffix(".yaml"), output.with_suffix(".png"))
    lines.append(f"written:  {', '.join(map(str, paths))}")
    return lines
