"""An RGB-D recording as a folder: opened whole, read frame by frame."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from bath_drake.demonstrations.rgbd.frame_files import FrameFiles
from bath_drake.demonstrations.rgbd.images import read_colour, read_depth
from bath_drake.demonstrations.rgbd.intrinsics import (
    missing_intrinsics,
    read_intrinsics,
)
from bath_drake.demonstrations.rgbd.timestamps import frames_of_table
from bath_drake.demonstrations.rgbd.tum import COLOUR_LIST, DEPTH_LIST, frames_of_lists
from bath_drake.demonstrations.rgbd.writer import (
    DEPTH_SCALE,
    INTRINSICS,
    TIMESTAMPS,
)
from bath_drake.errors import DemonstrationError
from bath_drake.notation import ByteArray, FloatArray
from bath_drake.perception.camera import PinholeCamera

TUM_SCALE = 5000.0
# An hour at 30 Hz.
MAX_FRAMES = 108_000


@dataclass(frozen=True, eq=False)
class RgbdFrame:
    """One frame.

    Attributes:
        t: When it was taken, s, on the recording's own clock.
        colour: (H, W, 3) RGB.
        depth: (H, W), m along the optical axis, 0 where nothing was measured.
    """

    t: float
    colour: ByteArray
    depth: FloatArray


@dataclass(frozen=True, eq=False)
class RgbdFolder:
    """A recording whose images are read when they are asked for.

    Attributes:
        path: The folder.
        camera: Of colour and depth, which is registered to it.
        depth_scale: Steps of the depth images a metre.
        X_WC: (4, 4) pose of the camera in a world whose z points up, or None.
        files: The frames' files by time.
    """

    path: Path
    camera: PinholeCamera
    depth_scale: float
    X_WC: FloatArray | None
    files: tuple[FrameFiles, ...]

    def __len__(self) -> int:
        return len(self.files)

    def __iter__(self) -> Iterator[RgbdFrame]:
        return (self.frame(k) for k in range(len(self)))

    def frame(self, index: int) -> RgbdFrame:
        """Reads a frame's two images.

        Raises:
            DemonstrationError: Naming the image that is damaged or of another size.
        """
        files = self.files[index]
        return RgbdFrame(
            files.t,
            read_colour(files.colour, self.camera),
            read_depth(files.depth, self.camera, self.depth_scale),
        )


def open_rgbd(folder: str | Path) -> RgbdFolder:
    """Opens a recording: reads everything but the images.

    Layout (docs/rgbd.md): `color/` (or colour, rgb, image) with PNG or JPEG images,
    `depth/` with 16-bit PNGs registered to colour, intrinsics.json, and
    timestamps.csv or TUM's rgb.txt and depth.txt.

    Raises:
        DemonstrationError: Naming file and line or key.
    """
    folder = Path(folder)
    if "\0" in str(folder) or not folder.is_dir():
        raise DemonstrationError(
            f"{str(folder)!r} is not a folder, expected one of colour and depth images"
        )
    frames, tum = _frames(folder)
    if not 0 < len(frames) <= MAX_FRAMES:
        raise DemonstrationError(
            f"{folder}: found {len(frames)} frames, allowed: 1 to {MAX_FRAMES}"
        )
    path = folder / INTRINSICS
    if not path.exists():
        missing_intrinsics(path, TUM_SCALE if tum else DEPTH_SCALE)
    intrinsics = read_intrinsics(path)
    scale = intrinsics.depth_scale
    if scale is None and tum:
        raise DemonstrationError(
            f"{path}: depth_scale: is missing, expected steps a metre "
            f"({TUM_SCALE:g} in TUM's data sets)"
        )
    return RgbdFolder(
        folder,
        intrinsics.camera,
        DEPTH_SCALE if scale is None else scale,
        intrinsics.X_WC,
        tuple(frames),
    )


def _frames(folder: Path) -> tuple[list[FrameFiles], bool]:
    """The frames by time, and whether TUM's lists named them."""
    if (folder / TIMESTAMPS).exists():
        return frames_of_table(folder), False
    if (folder / COLOUR_LIST).exists() and (folder / DEPTH_LIST).exists():
        return frames_of_lists(folder), True
    raise DemonstrationError(
        f"{folder}: holds neither {TIMESTAMPS} (header frame,t_s) nor TUM's "
        f"{COLOUR_LIST} and {DEPTH_LIST}"
    )
