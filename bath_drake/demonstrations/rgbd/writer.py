"""Writes the frames of a depth camera into a folder.

    color/000000.png ...   8-bit RGB
    depth/000000.png ...   16-bit, millimetres, 0 = nothing measured, registered to the
                           colour image
    intrinsics.json        width, height, fx, fy, cx, cy, depth_scale, and X_WC if known
    timestamps.csv         header frame,t_s; a row a frame: its files' stem and seconds

The layout is that of common RGB-D data sets; the principal point counts pixel CENTRES
as integers, half a pixel less than `PinholeCamera`.
"""

import json
import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bath_drake.errors import DemonstrationError
from bath_drake.files import append, write_atomically
from bath_drake.notation import ByteArray, FloatArray
from bath_drake.perception.camera import PinholeCamera

COLOUR, DEPTH = "color", "depth"
INTRINSICS, TIMESTAMPS, TRUTH = "intrinsics.json", "timestamps.csv", "truth.npz"
DEPTH_SCALE = 1000.0  # steps a metre
TIMESTAMPS_HEADER = "frame,t_s"
_DEEPEST = 65535
# Compression costs more time than rendering at the usual level.
_PNG = (cv2.IMWRITE_PNG_COMPRESSION, 1)


def check_recording_output(folder: str | Path) -> None:
    """Raises DemonstrationError unless a recording can begin there; touches nothing."""
    folder = Path(folder)
    if "\0" in str(folder) or (os.path.lexists(folder) and not folder.is_dir()):
        raise DemonstrationError(f"{str(folder)!r} is not a folder to record into")
    for name in (COLOUR, DEPTH, INTRINSICS, TIMESTAMPS, TRUTH):
        if os.path.lexists(folder / name):
            raise DemonstrationError(
                f"{folder}: holds {name} of an earlier recording; record into a new "
                "or empty folder"
            )
    existing = folder.absolute()
    while not existing.exists():
        existing = existing.parent
    if not (existing.is_dir() and os.access(existing, os.W_OK | os.X_OK)):
        raise DemonstrationError(f"{folder}: {existing} cannot be written to")


class RgbdWriter:
    """Writes a recording, frame after frame.

    A row of timestamps.csv is added when both images of its frame are in place, so
    what an interrupted recording leaves behind is a shorter recording.

    Attributes:
        folder: Where it writes.
        times: Of the frames written so far, s.
    """

    def __init__(
        self, folder: str | Path, camera: PinholeCamera, X_WC: FloatArray | None = None
    ) -> None:
        """Makes the folder and writes what is known before the first frame.

        Args:
            folder: Not there yet, or without a recording in it.
            camera: Whose images will come.
            X_WC: (4, 4) pose of the camera in a world whose z points up, if known.

        Raises:
            DemonstrationError: If the folder holds a recording or cannot be made.
        """
        self.folder = Path(folder)
        self.times: list[float] = []
        self._camera = camera
        check_recording_output(self.folder)
        try:
            for name in (COLOUR, DEPTH):
                (self.folder / name).mkdir(parents=True, exist_ok=True)
        except OSError as problem:
            raise DemonstrationError(
                f"{self.folder}: cannot be made ({problem.strerror})"
            ) from None
        text = json.dumps(_intrinsics(camera, X_WC), indent=2, allow_nan=False) + "\n"
        for name, content in (
            (INTRINSICS, text),
            (TIMESTAMPS, TIMESTAMPS_HEADER + "\n"),
        ):
            write_atomically(self.folder / name, content, error=DemonstrationError)

    def write(self, t: float, colour: ByteArray, depth: NDArray[np.float32]) -> None:
        """Writes the next frame.

        Args:
            t: Its time, s, later than the last one's.
            colour: (H, W, 3) RGB.
            depth: (H, W), m along the optical axis; what is not finite and positive,
                or too deep for 16 bits of millimetres, counts as not measured.

        Raises:
            ValueError: On a wrong size or a time that does not increase.
            DemonstrationError: If a file cannot be written.
        """
        shape = self._camera.shape
        if colour.shape != (*shape, 3) or depth.shape != shape:
            raise ValueError(
                f"images must be {shape}, got {colour.shape} and {depth.shape}"
            )
        if not np.isfinite(t) or (self.times and t <= self.times[-1]):
            raise ValueError(f"time {t} does not increase after {self.times[-1:]}")
        stem = f"{len(self.times):06d}"
        self._write_image(COLOUR, stem, cv2.cvtColor(colour, cv2.COLOR_RGB2BGR))
        self._write_image(DEPTH, stem, millimetres(depth))
        append(self.folder / TIMESTAMPS, f"{stem},{t:.6f}\n", error=DemonstrationError)
        self.times.append(t)

    def write_truth(self, arrays: dict[str, NDArray[Any]]) -> None:
        """Writes truth.npz, what a simulator knows and no camera sees."""

        def save(path: Path) -> None:
            np.savez_compressed(path, **arrays)  # type: ignore[arg-type]

        write_atomically(self.folder / TRUTH, save, error=DemonstrationError)

    def _write_image(self, kind: str, stem: str, image: NDArray[Any]) -> None:
        _, data = cv2.imencode(".png", image, _PNG)
        path = self.folder / kind / f"{stem}.png"
        write_atomically(path, data.tobytes(), error=DemonstrationError)


def millimetres(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Returns a depth image in whole millimetres; 0 where nothing was measured."""
    steps = depth * np.float32(DEPTH_SCALE) + np.float32(0.5)
    known = (steps >= 1.0) & (steps < _DEEPEST + 1)
    return np.where(known, steps, np.float32(0.0)).astype(np.uint16)


def _intrinsics(camera: PinholeCamera, X_WC: FloatArray | None) -> dict[str, Any]:
    numbers: dict[str, Any] = {
        "width": camera.width,
        "height": camera.height,
        "fx": camera.fx,
        "fy": camera.fy,
        "cx": camera.cx - 0.5,
        "cy": camera.cy - 0.5,
        "depth_scale": DEPTH_SCALE,
    }
    if X_WC is not None:
        pose = np.asarray(X_WC, dtype=np.float64)
        if pose.shape != (4, 4) or not np.isfinite(pose).all():
            raise ValueError(f"X_WC must be finite with shape (4, 4), got {pose.shape}")
        numbers["X_WC"] = pose.tolist()
    return numbers
