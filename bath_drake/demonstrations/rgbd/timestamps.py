"""timestamps.csv: a row a frame, with its time and what names its images."""

import re
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from bath_drake.demonstrations.rgbd.frame_files import (
    FrameFiles,
    check_increasing,
    file_inside,
    parse_time,
    read_lines,
)
from bath_drake.demonstrations.rgbd.writer import TIMESTAMPS
from bath_drake.errors import DemonstrationError

COLOUR_FOLDERS = ("color", "colour", "rgb", "image", "images")
DEPTH_FOLDERS = ("depth",)
COLOUR_SUFFIXES = (".png", ".jpg", ".jpeg")
DEPTH_SUFFIXES = (".png",)

_FRAME = ("frame", "#frame", "index", "id", "name", "file", "filename", "frame_id")
_COLOUR = (*COLOUR_FOLDERS, "rgb_file", "color_file", "colour_file")
_DEPTH = (*DEPTH_FOLDERS, "depth_file")
_TIME = re.compile(r"(?:t|time|timestamp|stamp)(?:[_ ]?[(\[]?(s|sec|ms|us|ns)[)\]]?)?")
_UNITS = {None: 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


@dataclass(frozen=True)
class _Images:
    """The images of a folder, by their stem and by its number."""

    kind: str
    by_stem: dict[str, Path] = field(default_factory=dict)
    by_number: dict[int, Path] = field(default_factory=dict)


def frames_of_table(folder: Path) -> list[FrameFiles]:
    """Returns the frames that timestamps.csv names.

    The header names a column of times (`t_s`, `timestamp`, `time_ms` ...; seconds
    without a unit) and either one column (`frame`, `index` ...) with the stem or
    number of both images, or two (`color`, `depth`) with those of each, or with paths.

    Raises:
        DemonstrationError: Naming file and line: a row is no frame, an image is
            missing, times do not increase, or images are left over.
    """
    path = folder / TIMESTAMPS
    lines = read_lines(path)
    names = [_cell(name).lower() for name in lines[0].split(",")] if lines else []
    time, unit, columns = _columns(path, names)
    images = (
        _images("colour", folder, COLOUR_FOLDERS, COLOUR_SUFFIXES),
        _images("depth", folder, DEPTH_FOLDERS, DEPTH_SUFFIXES),
    )
    frames = []
    for number, line in enumerate(lines[1:], start=2):
        place = f"{path}: line {number}"
        cells = [_cell(text) for text in line.split(",")]
        if len(cells) != len(names):
            raise DemonstrationError(
                f"{place}: found {len(cells) if line.strip() else 0} values, "
                f"expected {len(names)}"
            )
        colour, depth = (
            _find(folder, cells[column], known, place)
            for column, known in zip(columns, images, strict=True)
        )
        t = parse_time(cells[time], place) * unit
        frames.append(FrameFiles(t, colour, depth, place))
    check_increasing(frames)
    _check_leftovers(path, images[0], {frame.colour for frame in frames})
    _check_leftovers(path, images[1], {frame.depth for frame in frames})
    return frames


def _cell(text: str) -> str:
    return text.strip().strip('"').strip()


def _columns(path: Path, names: list[str]) -> tuple[int, float, tuple[int, int]]:
    """The column of times, its unit, and those that name colour and depth."""
    times = [k for k, name in enumerate(names) if _TIME.fullmatch(name)]
    frame, colour, depth = (
        [k for k, name in enumerate(names) if name in known]
        for known in (_FRAME, _COLOUR, _DEPTH)
    )
    pair = (colour, depth) if colour and depth else (frame, frame)
    if len(times) != 1 or any(len(columns) != 1 for columns in pair):
        raise DemonstrationError(
            f"{path}: line 1: found {','.join(names)[:80]!r}, expected a header such "
            "as frame,t_s or color,depth,t_s"
        )
    match = _TIME.fullmatch(names[times[0]])
    return times[0], _UNITS[match[1] if match else None], (pair[0][0], pair[1][0])


def _images(
    kind: str, folder: Path, names: tuple[str, ...], suffixes: tuple[str, ...]
) -> _Images:
    """The images of the first folder of these names that is there."""
    inner = next((folder / name for name in names if (folder / name).is_dir()), None)
    if inner is None:
        raise DemonstrationError(
            f"{folder}: holds no folder of {kind} images, expected {' or '.join(names)}"
        )
    images = _Images(kind)
    for path in sorted(inner.iterdir()):
        if path.suffix.lower() not in suffixes:
            continue
        if path.stem in images.by_stem:
            raise DemonstrationError(
                f"{path}: the frame is there twice, see {images.by_stem[path.stem]}"
            )
        images.by_stem[path.stem] = path
        if _is_number(path.stem):
            images.by_number.setdefault(int(path.stem), path)
    return images


def _is_number(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) < 20


def _find(folder: Path, cell: str, images: _Images, place: str) -> Path:
    """The image a cell names: by its stem, by its number, or by its path."""
    if cell in images.by_stem:
        return images.by_stem[cell]
    if _is_number(cell) and int(cell) in images.by_number:
        return images.by_number[int(cell)]
    if PurePosixPath(cell).suffix or "/" in cell:
        return file_inside(folder, cell, place)
    raise DemonstrationError(f"{place}: no {images.kind} image of frame {cell[:40]!r}")


def _check_leftovers(path: Path, images: _Images, used: set[Path]) -> None:
    """Refuses images that no row names, but for one that a recorder broke off at."""
    left = [image for image in images.by_stem.values() if image not in used]
    if len(left) > 1:
        raise DemonstrationError(
            f"{path}: names {len(used)} of the {len(images.by_stem)} {images.kind} "
            f"images; the first without a row is {left[0].name}"
        )
