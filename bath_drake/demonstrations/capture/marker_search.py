"""The marker of a recording: its colour, and how large it is."""

from collections.abc import Mapping

import numpy as np

from bath_drake.demonstrations.capture.body import Images
from bath_drake.demonstrations.capture.marker import (
    RADII,
    MarkerSight,
    blob_radius,
    find_blobs,
    locate,
)
from bath_drake.demonstrations.capture.marker_colour import (
    MarkerColour,
    colour_of_pixels,
    colour_of_rgb,
    detect_colour,
)
from bath_drake.demonstrations.capture.options import CaptureOptions
from bath_drake.demonstrations.rgbd.folder import RgbdFolder
from bath_drake.errors import DemonstrationError
from bath_drake.notation import ByteArray, FloatArray
from bath_drake.perception.camera import PinholeCamera

# Half the side of the square of pixels around a click.
CLICK = 3
# A marker that nobody described is looked for in so many frames.
DETECTION_FRAMES = 12
# The ball's radius is that of its outlines where it is hidden least: this quantile.
RADIUS_RANK = 0.9


def marker_colour(
    recording: RgbdFolder, options: CaptureOptions, frames: Mapping[int, Images]
) -> MarkerColour:
    """Returns the marker's colour: said, shown in the first frame, or detected.

    Args:
        recording: The recording.
        options: What is said of the marker.
        frames: Images spread over the recording, by index.

    Raises:
        DemonstrationError: If the colour is too pale or nothing is a marker.
    """
    if options.marker_colour is not None:
        return colour_of_rgb(options.marker_colour, "--marker-colour")
    if options.marker_box is not None:
        return _shown(recording, options.marker_box, "--marker-box")
    if options.marker_at is not None:
        u, v = options.marker_at
        box = u - CLICK, v - CLICK, u + CLICK, v + CLICK
        return _shown(recording, box, "--marker-at", (u, v))
    # Blobs half or twice as wide as a marker can be are looked at too.
    camera = recording.camera
    nearest, farthest = 0.5, 4.0
    focal2 = np.pi * camera.fx * camera.fy
    sizes = (
        max(focal2 * (RADII[0] / farthest) ** 2, 5.0),
        focal2 * (RADII[1] / nearest) ** 2,
    )
    images = [colour for colour, _ in frames.values()]
    step = max(1, len(images) // DETECTION_FRAMES)
    return detect_colour(images[::step], sizes, str(recording.path))


def _shown(
    recording: RgbdFolder,
    box: tuple[int, int, int, int],
    name: str,
    at: tuple[int, int] | None = None,
) -> MarkerColour:
    camera = recording.camera
    left, top, right, bottom = box
    middle = at or (left, top)
    if (
        not (0 <= middle[0] < camera.width and 0 <= middle[1] < camera.height)
        or right < left
        or bottom < top
    ):
        raise DemonstrationError(
            f"{name}: found {','.join(map(str, at or box))}, allowed: columns 0 to "
            f"{camera.width - 1}, rows 0 to {camera.height - 1}"
        )
    colour: ByteArray = recording.frame(0).colour
    pixels = colour[max(top, 0) : bottom + 1, max(left, 0) : right + 1]
    return colour_of_pixels(pixels.reshape(-1, 3), name)


def find_marker(
    recording: RgbdFolder, options: CaptureOptions, frames: Mapping[int, Images]
) -> tuple[MarkerColour, float, FloatArray]:
    """Returns the marker's colour, its radius, m, and where it is (m, 3) in C.

    The colour is first what `marker_colour` says, then what the marker shows where it
    is found with that: of a named colour its shade in this light, of a click the
    shades of the whole ball.

    Args:
        recording: The recording.
        options: What is said of the marker.
        frames: Images spread over the recording, by index.

    Raises:
        DemonstrationError: If nothing of that colour has a marker's size, or two
            things do wherever one does.
    """
    first = marker_colour(recording, options, frames)
    said = f"{recording.path}: what has the marker's colour "
    said += ",".join(map(str, first.rgb))
    _, sights = _sights(frames, first, recording.camera, said)
    seen = [
        frames[k][0][sight.blob.rows, sight.blob.columns]
        for k, sight in sights.items()
        if sight.blob is not None
    ]
    colour = colour_of_pixels(np.concatenate(seen), said)
    radius, sights = _sights(frames, colour, recording.camera, said)
    places = [sight.p_C for sight in sights.values() if sight.seen]
    return colour, radius, np.array(places)


def _sights(
    frames: Mapping[int, Images],
    marker: MarkerColour,
    camera: PinholeCamera,
    said: str,
) -> tuple[float, dict[int, MarkerSight]]:
    """The ball's radius and its sights, at least one of which sees it."""
    blobs = {k: find_blobs(*images, marker, camera) for k, images in frames.items()}
    radii = [blob_radius(found[0], camera) for found in blobs.values() if found]
    if not radii:
        low, high = (2e3 * radius for radius in RADII)
        raise DemonstrationError(
            f"{said} is nowhere from {low:.0f} to {high:.0f} mm wide in {len(frames)} "
            "frames: another colour, or other intrinsics or depth_scale?"
        )
    radius = float(np.quantile(radii, RADIUS_RANK))
    sights = {
        k: locate(found, frames[k][1], camera, radius, None)
        for k, found in blobs.items()
    }
    if not any(sight.seen for sight in sights.values()):
        raise DemonstrationError(
            f"{said} is hidden or ambiguous in all of {len(frames)} frames"
        )
    return radius, sights
