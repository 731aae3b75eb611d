"""The still body of a recording: its clean plate, its back, and the back's own map.

Everything is in the camera's frame of one frame of the recording, the reference,
where the body is at rest; `rigid_tracking` says where it is in the others.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bath_drake.demonstrations.capture.clean_plate import CleanPlate, clean_plate
from bath_drake.demonstrations.capture.rigid_tracking import (
    AT_REST,
    RigidSurface,
    TrackedPose,
    track,
)
from bath_drake.demonstrations.capture.symmetry import sagittal_plane, symmetric_map
from bath_drake.demonstrations.capture.view import View
from bath_drake.errors import DemonstrationError
from bath_drake.notation import BoolArray, ByteArray, FloatArray
from bath_drake.perception.camera import PinholeCamera
from bath_drake.perception.canonical import CanonicalMap

# The back lies within this of the marker's positions, m.
AROUND = 0.55
MAX_POINTS = 4000
# The reference is chosen among so many frames: the one in which this share of them
# show less of a back. Where most shows an arm counts in.
REFERENCE_FRAMES, REFERENCE_RANK = 14, 0.7
MIN_BACK_PIXELS = 400
# How wide and how long a back may be, child's or giant's, m.
SIZES = ((0.16, 0.6), (0.2, 0.8))
# By how much what is up on average counts against the body's own direction.
UP_SHARES = (0.5, 1.0, 2.0, 4.0, 8.0)
# A frame shows the body if so much of its surface is found.
MIN_SHARE = 0.3

Images = tuple[ByteArray, FloatArray]


@dataclass(frozen=True, eq=False)
class Body:
    """The body of a recording.

    Attributes:
        reference: Index of the frame in whose camera it is given.
        plate: The body without the carer.
        back: (H, W) the back in the plate.
        canonical_map: From the camera's frame (for W) to the back's own.
        skin: (n, 3) points of the back and its surroundings, not smoothed: that would
            bend them inwards at the edge.
        surface: What is tracked of it, smoothed.
        poses: Of the body in the frames it was made from.
    """

    reference: int
    plate: CleanPlate
    back: BoolArray
    canonical_map: CanonicalMap
    skin: FloatArray
    surface: RigidSurface
    poses: Mapping[int, TrackedPose]


def build_body(
    frames: Mapping[int, Images],
    camera: PinholeCamera,
    up_C: FloatArray | None,
    marker_C: FloatArray,
    name: str,
) -> Body:
    """Gathers the body from frames spread over a recording.

    Args:
        frames: Colour (H, W, 3) and depth (H, W) by index, in order.
        camera: The camera.
        up_C: (3,) up in the camera's frame; None if nobody knows: then up in the
            image serves to begin with, and the back's own midline after.
        marker_C: (m, 3) places of the marker in the camera's frame, m.
        name: What to name in messages.

    Raises:
        DemonstrationError: If no back is found where the marker is.
    """
    low, high = marker_C.min(axis=0) - AROUND, marker_C.max(axis=0) + AROUND
    up = np.array([0.0, -1.0, 0.0]) if up_C is None else up_C
    view = View(camera, low, high, up)
    reference, back = _reference(frames, view, name)
    colour, depth = frames[reference]
    surface = _thinned(view.surface(depth, view.skin(colour, depth, back)))
    poses = _follow(frames, camera, surface, reference)
    layers = ((*frames[k], pose) for k, pose in poses.items())
    plate = clean_plate(layers, camera, len(poses), low, high)
    back = view.back(plate.colour, plate.depth)
    if back.sum() >= MIN_BACK_PIXELS:
        view, back = _upright(plate, view, back, up_C, poses)
    if back.sum() < MIN_BACK_PIXELS:
        raise DemonstrationError(
            f"{name}: the back is too small or hidden too long: {back.sum()} pixels of "
            f"it are seen, at least {MIN_BACK_PIXELS} are needed"
        )
    skin = view.skin(plate.colour, plate.depth, back)
    surface = _thinned(view.surface(plate.depth, skin))
    own = _canonical_map(plate.depth, back, view, surface)
    _check_size(own, name)
    return Body(
        reference=reference,
        plate=plate,
        back=back,
        canonical_map=own,
        skin=view.points_C(plate.depth)[skin],
        surface=surface,
        poses=_follow(frames, camera, surface, reference),
    )


def _upright(
    plate: CleanPlate,
    view: View,
    back: BoolArray,
    up_C: FloatArray | None,
    poses: Mapping[int, TrackedPose],
) -> tuple[View, BoolArray]:
    """The back for an up that does not hang on the lean of one frame.

    Where shoulders end hangs on what is up, and a little more of it may add or take a
    whole shoulder. So several ups between the body's own direction to the head and
    what is up on average are tried, and the back in the middle is taken.
    """
    own = view.first_map(plate.depth, back).R_WP[:, 1]
    ups = [own]
    if up_C is not None:
        mean = np.mean([pose.R.T @ up_C for pose in poses.values()], axis=0)
        ups = [own + share * mean / np.linalg.norm(mean) for share in UP_SHARES]
    tried = []
    for up in ups:
        upright = View(view.camera, view.low, view.high, up)
        found = upright.back(plate.colour, plate.depth)
        if found.sum() >= MIN_BACK_PIXELS:
            tried.append((upright, found))
    if not tried:
        return view, np.zeros_like(back)
    tried.sort(key=lambda one: int(one[1].sum()))
    return tried[len(tried) // 2]


def _reference(
    frames: Mapping[int, Images], view: View, name: str
) -> tuple[int, BoolArray]:
    """The frame to start from, and its back."""
    keys = list(frames)
    picks = np.linspace(0, len(keys) - 1, min(REFERENCE_FRAMES, len(keys)))
    backs = {keys[k]: view.back(*frames[keys[k]]) for k in picks.astype(np.int64)}
    found = sorted(
        (k for k, back in backs.items() if back.sum() >= MIN_BACK_PIXELS),
        key=lambda k: int(backs[k].sum()),
    )
    if not found:
        raise DemonstrationError(
            f"{name}: no back found within {AROUND} m of the marker in {len(backs)} "
            "frames, expected bare skin that the camera sees from behind"
        )
    reference = found[int(REFERENCE_RANK * (len(found) - 1))]
    return reference, backs[reference]


def _canonical_map(
    depth: FloatArray, back: BoolArray, view: View, surface: RigidSurface
) -> CanonicalMap:
    first = view.first_map(depth, back)
    plane = sagittal_plane(surface, depth, view, first)
    return first if plane is None else symmetric_map(depth, back, view, *plane)


def _check_size(own: CanonicalMap, name: str) -> None:
    sizes = zip(own.half_extents.tolist(), SIZES, strict=True)
    if not all(low <= 2.0 * half <= high for half, (low, high) in sizes):
        found = " x ".join(f"{2e2 * half:.0f}" for half in own.half_extents.tolist())
        allowed = " x ".join(f"{1e2 * low:.0f}-{1e2 * high:.0f}" for low, high in SIZES)
        raise DemonstrationError(
            f"{name}: found a back of {found} cm, allowed: {allowed} cm (other "
            "intrinsics or depth_scale?)"
        )


def _thinned(skin: RigidSurface) -> RigidSurface:
    step = max(1, len(skin.points) // MAX_POINTS)
    return RigidSurface(skin.points[::step].copy(), skin.normals[::step].copy())


def _follow(
    frames: Mapping[int, Images],
    camera: PinholeCamera,
    surface: RigidSurface,
    reference: int,
) -> dict[int, TrackedPose]:
    """The body's poses, from the reference onwards and backwards."""
    keys = list(frames)
    start = keys.index(reference)
    poses: dict[int, TrackedPose] = {}
    for order in (keys[start:], keys[start::-1]):
        pose = AT_REST
        for k in order:
            found = track(surface, frames[k][1], camera, pose)
            if found.share >= MIN_SHARE:
                poses[k] = pose = found
    return poses
