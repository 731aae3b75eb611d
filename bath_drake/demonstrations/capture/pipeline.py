"""From an RGB-D recording to a stroke on the back (paper, Section III-A)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from bath_drake.demonstrations.capture.body import (
    MIN_SHARE,
    Body,
    Images,
    build_body,
)
from bath_drake.demonstrations.capture.contact import Skin
from bath_drake.demonstrations.capture.marker import NEAR, find_blobs, locate
from bath_drake.demonstrations.capture.marker_colour import MarkerColour
from bath_drake.demonstrations.capture.marker_search import find_marker
from bath_drake.demonstrations.capture.options import CaptureOptions
from bath_drake.demonstrations.capture.rigid_tracking import TrackedPose, track
from bath_drake.demonstrations.capture.stroke import CapturedStroke, cut_stroke
from bath_drake.demonstrations.rgbd.folder import RgbdFolder
from bath_drake.errors import DemonstrationError
from bath_drake.notation import FloatArray

# The body is gathered from so many frames.
BODY_FRAMES = 40
# Fewer samples are no stroke.
MIN_SAMPLES = 5
# A marker that comes back is looked for within so many steps of where it went.
MAX_REACH = 4

Progress = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class Capture:
    """What a recording holds.

    Attributes:
        stroke: The stroke, in the back's own frame P.
        body: The body it is on.
        marker: The marker's colour.
        radius: The marker's radius, m.
        poses: Of the body in every frame; None where it was lost.
        markers_C: (n, 3) the marker in every frame, in the camera's frame, m; NaN
            where it was not seen.
    """

    stroke: CapturedStroke
    body: Body
    marker: MarkerColour
    radius: float
    poses: tuple[TrackedPose | None, ...]
    markers_C: FloatArray


def capture(
    recording: RgbdFolder,
    options: CaptureOptions,
    progress: Progress = lambda done, total: None,
) -> Capture:
    """Captures the stroke of a recording.

    Two passes: frames spread over the recording show the body without the carer;
    then body and marker are followed through all frames.

    Args:
        recording: The recording.
        options: What the user says about it.
        progress: Told how many images of how many are done.

    Raises:
        DemonstrationError: If an image is damaged, or marker or back are not found.
    """
    count, name, camera = len(recording), str(recording.path), recording.camera
    if count < MIN_SAMPLES:
        raise DemonstrationError(
            f"{name}: found {count} frame{'s' if count > 1 else ''}, at least "
            f"{MIN_SAMPLES} are needed"
        )
    picks = np.unique(np.linspace(0, count - 1, BODY_FRAMES).astype(np.int64)).tolist()
    total = len(picks) + count
    frames: dict[int, Images] = {}
    for done, k in enumerate(picks, start=1):
        frames[k] = _images(recording, k)
        progress(done, total)
    marker, radius, places_C = find_marker(recording, options, frames)
    X_WC = recording.X_WC
    up_C = None if X_WC is None else np.array(X_WC[2, :3])
    body = build_body(frames, camera, up_C, places_C, name)
    found = _follow(
        recording,
        frames,
        body,
        marker,
        radius,
        lambda k: progress(len(picks) + k, total),
    )
    return _cut(recording, body, marker, radius, found)


@dataclass(frozen=True, eq=False)
class _Track:
    """Marker and body through all frames."""

    poses: list[TrackedPose | None]
    markers_C: FloatArray
    contacts_P: FloatArray
    heights: FloatArray
    reasons: list[str]


def _images(recording: RgbdFolder, index: int) -> Images:
    frame = recording.frame(index)
    return frame.colour, frame.depth


def _follow(
    recording: RgbdFolder,
    frames: Mapping[int, Images],
    body: Body,
    marker: MarkerColour,
    radius: float,
    progress: Callable[[int], None],
) -> _Track:
    camera, count, own = recording.camera, len(recording), body.canonical_map
    skin = Skin(body.skin)
    markers_C, contacts = np.full((count, 3), np.nan), np.full((count, 3), np.nan)
    found = _Track([], markers_C, contacts, np.full(count, np.nan), [])
    last: FloatArray | None = None
    last_seen = 0
    guess = body.poses[min(body.poses)]
    for k in range(count):
        colour, depth = frames[k] if k in frames else _images(recording, k)
        guess = body.poses.get(k, guess)
        pose = track(body.surface, depth, camera, guess)
        blobs = find_blobs(colour, depth, marker, camera)
        # The longer it was hidden, the farther it may have come.
        reach = NEAR * min(k - last_seen, MAX_REACH)
        sight = locate(blobs, depth, camera, radius, last, reach)
        if sight.seen:
            last, last_seen = sight.p_C, k
        markers_C[k] = sight.p_C
        on_body = pose.share >= MIN_SHARE
        found.poses.append(pose if on_body else None)
        found.reasons.append(sight.reason if on_body else "body lost")
        if on_body:
            guess = pose
        if on_body and sight.seen:
            p = pose.from_camera(sight.p_C)
            under = skin.under(p)
            if under is None:
                found.reasons[-1] = "off the skin"
            else:
                contacts[k] = own.plane_from_world(under[0])
                found.heights[k] = under[1]
        progress(k + 1)
    return found


def _cut(
    recording: RgbdFolder,
    body: Body,
    marker: MarkerColour,
    radius: float,
    found: _Track,
) -> Capture:
    times = np.array([files.t for files in recording.files])
    stroke = cut_stroke(
        times - times[0], found.contacts_P, found.heights, found.reasons
    )
    if stroke is None or len(stroke.t) < MIN_SAMPLES:
        raise DemonstrationError(
            f"{recording.path}: marker and body are seen together in fewer than "
            f"{MIN_SAMPLES} frames"
        )
    return Capture(stroke, body, marker, radius, tuple(found.poses), found.markers_C)
