"""Reads intrinsics.json: the camera's numbers in any of the usual spellings."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from bath_drake.errors import DemonstrationError
from bath_drake.files import read_bytes
from bath_drake.notation import FloatArray
from bath_drake.perception.camera import PinholeCamera
from bath_drake.yaml_block import Block

MAX_BYTES = 1024 * 1024
# The largest image taken, pixels: that of an Azure Kinect.
MAX_PIXELS = 4096 * 3072
# Rounding of a pose that went through a file.
POSE_TOLERANCE = 1e-4

# Key -> other spellings (RealSense; ROS camera_info).
_FLAT = {"fx": (), "fy": (), "cx": ("ppx",), "cy": ("ppy",)}
_MATRICES = ("intrinsic_matrix", "K", "k", "camera_matrix")
_DISTORTION = ("distortion", "distortion_coefficients", "coeffs", "D", "d")
_SCALES = ("depth_scale", "depth_factor", "scale")
_EXAMPLE = (
    '{"width": 640, "height": 480, "fx": 525.0, "fy": 525.0, "cx": 319.5, '
    '"cy": 239.5, "depth_scale": 1000}'
)


@dataclass(frozen=True, eq=False)
class Intrinsics:
    """What intrinsics.json says.

    Attributes:
        camera: The pinhole; its principal point counts pixel corners, unlike the
            file's, which counts centres.
        depth_scale: Steps of the depth images a metre; None if the file is silent.
        X_WC: (4, 4) pose of the camera in a world whose z points up, or None.
    """

    camera: PinholeCamera
    depth_scale: float | None
    X_WC: FloatArray | None


def read_intrinsics(path: str | Path) -> Intrinsics:
    """Reads the file.

    It holds `width`, `height` and one of: `fx`, `fy`, `cx`, `cy` (or RealSense's
    `ppx`, `ppy`); `intrinsic_matrix` (Open3D); `K` (ROS), 3 rows or 9 numbers, by
    row or by column. Optional: `depth_scale` in steps a metre (below 1 it is metres
    a step, as RealSense has it), `X_WC`, and distortion coefficients if all are 0.

    Raises:
        DemonstrationError: Naming file and key.
    """
    block = _mapping(Path(path))
    size = [block.take(key, int) for key in ("width", "height")]
    if min(size) < 1 or size[0] * size[1] > MAX_PIXELS:
        block.fail(
            "width, height",
            f"found {size[0]} x {size[1]} pixels, allowed: up to {MAX_PIXELS}",
        )
    fx, fy, cx, cy = _focal_lengths_and_centre(block)
    if not (0.0 < fx < 1e6 and 0.0 < fy < 1e6):
        block.fail("fx, fy", f"found {fx:g} and {fy:g}, expected positive pixels")
    if not (0.0 <= cx + 0.5 <= size[0] and 0.0 <= cy + 0.5 <= size[1]):
        block.fail("cx, cy", f"found {cx:g} and {cy:g}, expected a point of the image")
    _refuse_distortion(block)
    camera = PinholeCamera(size[0], size[1], fx, fy, cx + 0.5, cy + 0.5)
    return Intrinsics(camera, _depth_scale(block), _pose(block))


def missing_intrinsics(path: Path, scale: float) -> NoReturn:
    """Raises the error of a folder without intrinsics.json; says what to put."""
    example = _EXAMPLE.replace("1000", f"{scale:g}")
    raise DemonstrationError(
        f"{path}: is missing; write the colour camera's numbers into it, such as "
        f"{example}"
    )


def _mapping(path: Path) -> Block:
    data = read_bytes(path, limit=MAX_BYTES, error=DemonstrationError)

    def refuse(name: str) -> NoReturn:
        raise ValueError(f"{name} is no number")

    try:
        tree = json.loads(data.decode("utf-8-sig"), parse_constant=refuse)
    except (ValueError, RecursionError) as problem:
        reason = " ".join(str(problem).split())[:100]
        raise DemonstrationError(f"{path}: is no JSON text: {reason}") from None
    if not isinstance(tree, dict):
        raise DemonstrationError(f"{path}: expected a mapping such as {_EXAMPLE}")
    # RealSense and Azure tools put the numbers one level down.
    for key in ("intrinsics", "color", "depth_intrinsics"):
        inner = tree.get(key)
        if isinstance(inner, dict) and "width" in inner and "width" not in tree:
            tree = {**tree, **inner}
    return Block(tree, str(path), error=DemonstrationError)


def _focal_lengths_and_centre(block: Block) -> tuple[float, float, float, float]:
    for key in _MATRICES:
        if block.has(key):
            return _from_matrix(block, key)
    numbers = []
    for key, others in _FLAT.items():
        found = next((name for name in (key, *others) if block.has(name)), key)
        numbers.append(block.take(found, float))
    fx, fy, cx, cy = numbers
    return fx, fy, cx, cy


def _from_matrix(block: Block, key: str) -> tuple[float, float, float, float]:
    value = _numbers(block, key)
    if value.size != 9:
        block.fail(key, f"found {value.size} numbers, expected 9")
    by_row = value.reshape(3, 3)
    for matrix in (by_row, by_row.T):
        # Only one of the two has its last row there, unless the centre is (0, 0).
        if np.array_equal(matrix[2], [0.0, 0.0, 1.0]):
            if matrix[1, 0] != 0.0 or matrix[0, 1] != 0.0:
                block.fail(key, "the pixels are skew, expected square corners")
            return matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]
    return block.fail(key, "expected fx, 0, cx; 0, fy, cy; 0, 0, 1 by row or column")


def _numbers(block: Block, key: str) -> FloatArray:
    """A list of numbers, a list of such lists, or a mapping with one as `data`."""
    if not block.is_list(key):
        return _numbers(block.take_block(key), "data")
    rows = _flat(block.take(key, list))
    if not all(type(v) in (int, float) and abs(v) < 1e9 for v in rows):
        block.fail(key, "expected numbers")
    return np.array(rows, dtype=np.float64)


def _flat(items: list[Any]) -> list[Any]:
    return [v for item in items for v in (item if isinstance(item, list) else [item])]


def _refuse_distortion(block: Block) -> None:
    for key in _DISTORTION:
        if block.is_list(key) and np.any(_numbers(block, key) != 0.0):
            block.fail(
                key, "the images are distorted; undistort them and put zeros here"
            )


def _depth_scale(block: Block) -> float | None:
    for key in _SCALES:
        if block.has(key):
            scale = block.take(key, float)
            if not 1e-5 <= scale <= 1e5:
                block.fail(key, f"found {scale:g}, expected steps a metre (1000)")
            return scale if scale >= 1.0 else 1.0 / scale
    return None


def _pose(block: Block) -> FloatArray | None:
    if not block.has("X_WC") or block.take_null("X_WC"):
        return None
    pose = _numbers(block, "X_WC")
    if pose.size != 16:
        block.fail("X_WC", f"found {pose.size} numbers, expected 4 rows of 4")
    pose = pose.reshape(4, 4)
    R_WC = pose[:3, :3]
    if not (
        np.allclose(R_WC @ R_WC.T, np.eye(3), atol=POSE_TOLERANCE)
        and np.linalg.det(R_WC) > 0.0
        and np.array_equal(pose[3], [0.0, 0.0, 0.0, 1.0])
    ):
        block.fail("X_WC", "expected a rotation, a position, and a last row 0, 0, 0, 1")
    u, _, vt = np.linalg.svd(R_WC)
    pose[:3, :3] = u @ vt
    pose.setflags(write=False)
    return pose
