"""Decodes the images of a recording, after a look at what their bytes claim.

A decoder allocates what a header claims and returns half a picture of half a file:
sizes are compared before, and a PNG's check sums are verified.
"""

import zlib
from pathlib import Path

import cv2
import numpy as np

from bath_drake.errors import DemonstrationError
from bath_drake.files import read_bytes
from bath_drake.notation import ByteArray, FloatArray
from bath_drake.perception.camera import PinholeCamera

# A 16-bit image of the largest size has 25 MB before compression.
MAX_BYTES = 64 * 1024 * 1024
_PNG = b"\x89PNG\r\n\x1a\n"
_JPEG = b"\xff\xd8"
_GREY = 0


def read_colour(path: Path, camera: PinholeCamera) -> ByteArray:
    """Reads a colour image, PNG or JPEG: (H, W, 3) RGB.

    Raises:
        DemonstrationError: Naming the file, if it is damaged or of another size.
    """
    data = read_bytes(path, limit=MAX_BYTES, error=DemonstrationError)
    if data.startswith(_PNG):
        width, height, _, _ = _png_header(path, data)
    elif data.startswith(_JPEG):
        width, height = _jpeg_size(path, data)
    else:
        raise DemonstrationError(f"{path}: is neither a PNG nor a JPEG image")
    _check_size(path, (width, height), camera)
    # A camera's images are upright; a tag that turns them would part them from depth.
    image = _decoded(path, data, cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB))


def read_depth(path: Path, camera: PinholeCamera, scale: float) -> FloatArray:
    """Reads a depth image: (H, W) m along the optical axis, 0 where unknown.

    Args:
        path: A greyscale PNG of 16 bits.
        camera: Whose image it is.
        scale: Steps a metre.

    Raises:
        DemonstrationError: Naming the file, if it is damaged or no such image.
    """
    data = read_bytes(path, limit=MAX_BYTES, error=DemonstrationError)
    if not data.startswith(_PNG):
        raise DemonstrationError(f"{path}: is no PNG image, expected 16-bit depth")
    width, height, bits, kind = _png_header(path, data)
    if bits != 16 or kind != _GREY:
        grey = "greyscale" if kind == _GREY else "colour"
        raise DemonstrationError(
            f"{path}: found {bits}-bit {grey}, expected a 16-bit greyscale PNG of depth"
        )
    _check_size(path, (width, height), camera)
    image = _decoded(path, data, cv2.IMREAD_UNCHANGED)
    return np.asarray(image * (1.0 / scale))


def _decoded(path: Path, data: bytes, flags: int) -> ByteArray:
    try:
        image = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), flags)
    except cv2.error:
        image = None
    if image is None:
        raise DemonstrationError(f"{path}: is a damaged image")
    return np.asarray(image)


def _check_size(path: Path, found: tuple[int, int], camera: PinholeCamera) -> None:
    if found != (camera.width, camera.height):
        raise DemonstrationError(
            f"{path}: found {found[0]} x {found[1]} pixels, expected "
            f"{camera.width} x {camera.height} as in intrinsics.json (depth must be "
            "registered to colour)"
        )


def _png_header(path: Path, data: bytes) -> tuple[int, int, int, int]:
    """Width, height, bits a channel and colour type; all check sums hold."""
    place = len(_PNG)
    kinds: list[bytes] = []
    while place + 12 <= len(data) and kinds[-1:] != [b"IEND"]:
        length = int.from_bytes(data[place : place + 4], "big")
        end = place + 12 + length
        check = int.from_bytes(data[end - 4 : end], "big")
        if end > len(data) or zlib.crc32(data[place + 4 : end - 4]) != check:
            raise DemonstrationError(
                f"{path}: damaged or cut off after {place} of {len(data)} bytes"
            )
        kinds.append(data[place + 4 : place + 8])
        place = end
    if kinds[:1] != [b"IHDR"] or kinds[-1] != b"IEND":
        raise DemonstrationError(f"{path}: cut off after {len(data)} bytes")
    width, height = (int.from_bytes(data[k : k + 4], "big") for k in (16, 20))
    return width, height, data[24], data[25]


def _jpeg_size(path: Path, data: bytes) -> tuple[int, int]:
    """Width and height by the first frame header; the end mark is there."""
    if data.rfind(b"\xff\xd9") < 0:
        raise DemonstrationError(f"{path}: cut off after {len(data)} bytes")
    place = 2
    while place + 9 <= len(data) and data[place] == 0xFF:
        mark = data[place + 1]
        if mark == 0xFF:  # padding
            place += 1
            continue
        # Start of frame, all codings; not DHT, JPG, DAC.
        if 0xC0 <= mark <= 0xCF and mark not in (0xC4, 0xC8, 0xCC):
            height = int.from_bytes(data[place + 5 : place + 7], "big")
            return int.from_bytes(data[place + 7 : place + 9], "big"), height
        place += 2 + int.from_bytes(data[place + 2 : place + 4], "big")
    raise DemonstrationError(f"{path}: damaged, no frame header in the JPEG image")
