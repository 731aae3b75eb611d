"""`bath-drake show`: what demonstration files hold, before anyone learns from them."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bath_drake.demonstrations.canonical import CanonicalDemonstration
    from bath_drake.demonstrations.hand_motion import HandMotion
    from bath_drake.demonstrations.recording import Recording


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the demonstrations and where the picture goes."""
    parser.add_argument("files", nargs="+", metavar="DEMO.csv")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("demonstrations.png"),
        metavar="PICTURE.png",
        help="PNG, SVG or PDF (%(default)s)",
    )


def run(options: argparse.Namespace) -> int:
    """Writes the picture and prints a few lines a demonstration; returns 0."""
    import io

    from bath_drake.demonstrations.hand_motion import hand_motion
    from bath_drake.demonstrations.processing import canonical_demonstrations
    from bath_drake.demonstrations.recording import read_recording
    from bath_drake.errors import BathDrakeError
    from bath_drake.files import check_output, write_atomically
    from bath_drake.report import style
    from bath_drake.report.recording_figure import draw_recordings

    output: Path = options.output
    kinds = {".png": "png", ".svg": "svg", ".pdf": "pdf"}
    if output.suffix not in kinds:
        raise BathDrakeError(
            f"-o: found {str(output)!r}, expected a name that ends in "
            f"{', '.join(kinds)}"
        )
    check_output(output)
    recordings = [read_recording(path) for path in options.files]
    demonstrations, frame = canonical_demonstrations(recordings)
    motions = [hand_motion(recording) for recording in recordings]
    picture = io.BytesIO()
    with style.figure_style():
        figure = draw_recordings(recordings, demonstrations, motions, frame)
        figure.savefig(picture, format=kinds[output.suffix], dpi=120)
    write_atomically(output, picture.getvalue(), error=BathDrakeError)
    for told in zip(recordings, demonstrations, motions, strict=True):
        print("\n".join(_told(*told)))
    print(f"frame:   {frame.kind}")
    for line in _left_out(demonstrations):
        print(line)
    print(f"picture: {output}")
    return 0


def _told(
    recording: "Recording", d: "CanonicalDemonstration", motion: "HandMotion"
) -> list[str]:
    import numpy as np

    t, outliers = recording.t, motion.outliers
    kept = np.delete(recording.points, outliers, axis=0)
    sides = " x ".join(f"{side:.3f}" for side in np.ptp(kept, axis=0))
    step = float(np.median(np.diff(t)))
    lines = [
        f"{recording.path}:",
        f"  {t.size} points in {t[-1] - t[0]:.2f} s (every {1e3 * step:.0f} ms), "
        f"length {motion.length:.3f} m, sides {sides} m",
    ]
    said = recording.metadata
    if said.body_box is not None:
        wide, tall = 100.0 * said.body_box.extents[:2]
        lines.append(f"  body box {wide:.1f} x {tall:.1f} cm")
    if outliers.size:
        times = ", ".join(f"{t[k]:.2f}" for k in outliers[:6])
        more = ", ..." if outliers.size > 6 else ""
        lines.append(f"  {outliers.size} outliers, left out (at {times}{more} s)")
    lines += [f"  gap from {a:.2f} to {b:.2f} s" for a, b in said.gaps]
    if d.periodic is not None:
        part = d.periodic
        size = float(np.linalg.norm(part.offsets, axis=1).max())
        turns = (part.phase[-1] - part.phase[0]) / (2.0 * np.pi)
        lines.append(
            f"  periodic: {turns:.1f} cycles of {part.period:.2f} s, up to {size:.3f} "
            "of N from the stroke"
        )
    if said.source:
        lines.append(f"  from {said.source}")
    return lines


def _left_out(demonstrations: Sequence["CanonicalDemonstration"]) -> list[str]:
    """Which would be left out by `learn`, and why."""
    from bath_drake.demonstrations.processing import without_strays
    from bath_drake.learning.grouping import group_strokes
    from bath_drake.learning.periodic import learn_cycle
    from bath_drake.learning.strokes import gather_strokes

    together = without_strays(demonstrations)
    strokes = gather_strokes(together)
    names = [d.name for d in together]
    groups, outliers = group_strokes(strokes.points, strokes.scale, names)
    lines = [
        f"left out by learn: {d.name}: {d.stray}" for d in demonstrations if d.stray
    ]
    lines += [f"left out by learn: {o.name}: {o.reason}" for o in outliers]
    lines += [
        f"not for the cycle: {o.name}: {o.reason}"
        for o in learn_cycle(together).left_out
    ]
    if len(groups) > 1:
        told = "; ".join(", ".join(names[i] for i in group) for group in groups)
        lines.append(f"ways:    {len(groups)}: {told}")
    return lines
