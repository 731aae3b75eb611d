"""The file lists of the TUM RGB-D data sets: rgb.txt and depth.txt.

Each line is a time in seconds and a file; colour and depth were not taken at quite
the same times and are paired, as in the data sets' own associate.py, by nearness.
"""

from dataclasses import dataclass
from pathlib import Path

from bath_drake.demonstrations.rgbd.frame_files import (
    FrameFiles,
    file_inside,
    parse_time,
    read_lines,
)
from bath_drake.errors import DemonstrationError

COLOUR_LIST, DEPTH_LIST = "rgb.txt", "depth.txt"
# Colour and depth further apart than this do not show the same, s.
TOLERANCE = 0.02


@dataclass(frozen=True)
class _Entry:
    t: float
    path: Path
    place: str


def frames_of_lists(folder: Path) -> list[FrameFiles]:
    """Returns the pairs of the two lists, at the times of their colour images.

    An image without a partner within `TOLERANCE`, or whose partner has a nearer one,
    belongs to no frame.

    Raises:
        DemonstrationError: Naming file and line: a line is no entry, a file is
            missing, times do not increase, or nothing pairs.
    """
    colour, depth = (_entries(folder, name) for name in (COLOUR_LIST, DEPTH_LIST))
    best: dict[int, tuple[float, FrameFiles]] = {}
    k = 0
    for entry in colour if depth else ():
        while k + 1 < len(depth) and (
            abs(depth[k + 1].t - entry.t) <= abs(depth[k].t - entry.t)
        ):
            k += 1
        apart = abs(depth[k].t - entry.t)
        if apart <= TOLERANCE and (k not in best or apart < best[k][0]):
            frame = FrameFiles(entry.t, entry.path, depth[k].path, entry.place)
            best[k] = apart, frame
    if not best:
        raise DemonstrationError(
            f"{folder / DEPTH_LIST}: no depth image within {1000.0 * TOLERANCE:g} ms "
            f"of a colour image in {COLOUR_LIST}"
        )
    return [frame for _, frame in best.values()]


def _entries(folder: Path, name: str) -> list[_Entry]:
    entries: list[_Entry] = []
    for number, line in enumerate(read_lines(folder / name), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        place = f"{folder / name}: line {number}"
        cells = line.replace(",", " ").split()
        if len(cells) != 2:
            raise DemonstrationError(
                f"{place}: found {len(cells)} words, expected a time and a file"
            )
        t = parse_time(cells[0], place)
        if entries and not t > entries[-1].t:
            raise DemonstrationError(
                f"{place}: time {t:.9g} s does not increase after {entries[-1].t:.9g} s"
            )
        entries.append(_Entry(t, file_inside(folder, cells[1], place), place))
    return entries
