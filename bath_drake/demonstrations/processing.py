"""From recordings to demonstrations in canonical space (paper, section III-A)."""

import logging
from collections.abc import Sequence

import numpy as np

from bath_drake.demonstrations.agreement import find_strays
from bath_drake.demonstrations.canonical import (
    CanonicalDemonstration,
    CanonicalFrame,
    FrameKind,
    PeriodicPart,
)
from bath_drake.demonstrations.denoise import DenoisedPath, denoise
from bath_drake.demonstrations.metadata import BodyBox
from bath_drake.demonstrations.outliers import find_outliers
from bath_drake.demonstrations.recording import Recording
from bath_drake.demonstrations.separation import Separation, separate
from bath_drake.errors import DemonstrationError
from bath_drake.notation import FloatArray

POINT_COUNT = 200
# Without a body box the joint box's longest side spans this much of N's 2 units.
CANONICAL_SPAN = 1.6
# A stroke may leave the body part a little; further out the box is not its box.
MAX_CANONICAL = 1.25
# Samples of the smooth path a resampled point: its chords are then the arc.
OVERSAMPLING = 20

_log = logging.getLogger(__name__)


def canonical_demonstrations(
    recordings: Sequence[Recording], count: int = POINT_COUNT
) -> tuple[tuple[CanonicalDemonstration, ...], CanonicalFrame]:
    """Denoises recordings, maps them to N and resamples them by arc length.

    Circles or scrubbing on top of a stroke are taken off first and kept beside it
    (`separation`); what follows is about the discrete part alone.

    With body boxes each recording goes through its own box, and the frame returned
    is the first one's. Without, all share the best plane of all paths (or the plane
    they were recorded in). One that does not belong to the others (broken off, the
    other way round, there twice) is marked as a stray and told by a warning (see
    `agreement`). Each other one is moved as a whole so that all end
    at their mean goal; `goal_offset` keeps by how much.

    Args:
        recordings: One or more, all 2-D or all 3-D, all with a body box or none.
        count: Points of each demonstration, at least 2.

    Raises:
        DemonstrationError: Naming the file, when the recordings do not go together
            or a path lies outside its body box.
        ValueError: Without recordings, or for fewer than 2 points.
    """
    if not recordings:
        raise ValueError("no recordings given")
    _check_alike(recordings)
    parts = [take_apart(recording) for recording in recordings]
    smooth = [
        denoise(recording.t, recording.points)
        if part.period is None
        else denoise(part.t, part.discrete)
        for recording, part in zip(recordings, parts, strict=True)
    ]
    for recording, path, part in zip(recordings, smooth, parts, strict=True):
        _tell(recording, path, part)
    frames = _frames(recordings, smooth)
    resampled = [
        _resampled(path, frame, count)
        for path, frame in zip(smooth, frames, strict=True)
    ]
    strays = _strays(recordings, [points for _, points in resampled])
    ends = [points[-1] for i, (_, points) in enumerate(resampled) if i not in strays]
    goal = np.mean(ends, axis=0)
    demonstrations = []
    for i, (recording, part, frame, (times, points)) in enumerate(
        zip(recordings, parts, frames, resampled, strict=True)
    ):
        _check_on_body(recording, points)
        offset = np.zeros(2) if i in strays else points[-1] - goal
        moved = points - offset
        if i in strays:
            _log.warning("%s: left out, it %s", recording.path, strays[i])
        else:
            # Rounding apart, one goal: all end on the same bits.
            moved[-1] = goal
        demonstrations.append(
            CanonicalDemonstration(
                name=recording.name,
                times=times,
                points=moved,
                raw=frame.to_canonical(recording.points),
                sha256=recording.sha256,
                goal_offset=offset,
                periodic=_periodic(part, frame),
                stray=strays.get(i, ""),
            )
        )
    return tuple(demonstrations), frames[0]


def _tell(recording: Recording, path: DenoisedPath, part: Separation) -> None:
    if gaps := recording.metadata.gaps:
        _log.warning(
            "%s: %d gaps, %.2f s in all, are bridged",
            recording.path,
            len(gaps),
            sum(end - start for start, end in gaps),
        )
    if part.period is not None:
        _log.info(
            "%s: %.1f cycles of %.2f s and %.3g m taken off",
            recording.path,
            part.cycles,
            part.period,
            part.amplitude,
        )
    _log.info(
        "%s: %d outliers left out, smoothed at %.2f Hz",
        recording.path,
        path.outliers.size,
        path.cutoff,
    )


def without_strays(
    demonstrations: Sequence[CanonicalDemonstration],
) -> tuple[CanonicalDemonstration, ...]:
    """Those that belong together, in their order."""
    return tuple(d for d in demonstrations if not d.stray)


def _strays(
    recordings: Sequence[Recording], paths: Sequence[FloatArray]
) -> dict[int, str]:
    return find_strays(
        starts=np.array([path[0] for path in paths]),
        ends=np.array([path[-1] for path in paths]),
        scale=float(np.ptp(np.concatenate(paths), axis=0).max()),
        names=[recording.name for recording in recordings],
        hashes=[recording.sha256 for recording in recordings],
    )


def take_apart(recording: Recording) -> Separation:
    """A recording without its outliers: the stroke, and circles or scrubbing on it."""
    outliers = find_outliers(recording.t, recording.points)
    return separate(
        np.delete(recording.t, outliers), np.delete(recording.points, outliers, axis=0)
    )


def _periodic(part: Separation, frame: CanonicalFrame) -> PeriodicPart | None:
    if part.period is None:
        return None
    hand = frame.to_canonical(part.discrete + part.periodic)
    return PeriodicPart(
        times=part.t - part.t[0],
        offsets=hand - frame.to_canonical(part.discrete),
        phase=part.phase,
        envelope=part.envelope,
        period=part.period,
    )


def resample_by_arc_length(
    times: FloatArray, points: FloatArray, count: int
) -> tuple[FloatArray, FloatArray]:
    """Resamples a polyline to points equally spaced along it; both ends stay.

    Args:
        times: Shape (n,), s, not decreasing.
        points: Shape (n, d), n >= 2, not all equal.
        count: How many points, at least 2.

    Returns:
        Times, shape (count,), and points, shape (count, d).

    Raises:
        ValueError: When count is too small or the path has no length.
    """
    if count < 2:
        raise ValueError(f"count must be at least 2, got {count}")
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    # Where the hand rests there is no arc; interpolation needs increasing lengths.
    moves = np.r_[True, steps > 0.0]
    length = np.r_[0.0, np.cumsum(steps)][moves]
    if length.size < 2:
        raise ValueError("a path without length cannot be resampled")
    wanted = np.linspace(0.0, length[-1], count)
    columns = [
        np.interp(wanted, length, column[moves]) for column in (times, *points.T)
    ]
    new_times, new_points = columns[0], np.stack(columns[1:], axis=-1)
    new_times[-1] = times[-1]
    new_points[0], new_points[-1] = points[0], points[-1]
    return new_times, new_points


def arc_length_mean(demonstrations: Sequence[CanonicalDemonstration]) -> FloatArray:
    """The mean of demonstrations at equal shares of their arc length, (T, 2), in N.

    Raises:
        ValueError: Without demonstrations, or when their numbers of points differ.
    """
    counts = sorted({demonstration.times.size for demonstration in demonstrations})
    if len(counts) != 1:
        raise ValueError(f"demonstrations must have one number of points, got {counts}")
    mean: FloatArray = np.mean([d.points for d in demonstrations], axis=0)
    return mean


def _check_alike(recordings: Sequence[Recording]) -> None:
    first = recordings[0]
    for other in recordings[1:]:
        if other.points.shape[1] != first.points.shape[1]:
            raise DemonstrationError(
                f"{other.path}: {other.points.shape[1]}-D points, but {first.path} has "
                f"{first.points.shape[1]}-D ones; all must be alike"
            )
        boxes = [r.metadata.body_box is not None for r in (first, other)]
        if boxes[0] != boxes[1]:
            boxed, bare = (first, other) if boxes[0] else (other, first)
            raise DemonstrationError(
                f"{bare.path}: no body_box, but {boxed.path} has one; all or none"
            )
        names = [r.metadata.frame for r in (first, other)]
        if not boxes[0] and all(names) and names[0] != names[1]:
            raise DemonstrationError(
                f"{other.path}: frame {names[1]!r}, but {first.path} has {names[0]!r}; "
                "without body boxes all must be in one frame"
            )


def _check_on_body(recording: Recording, points: FloatArray) -> None:
    furthest = float(np.max(np.abs(points)))
    if recording.metadata.body_box is not None and furthest > MAX_CANONICAL:
        raise DemonstrationError(
            f"{recording.path}: the path reaches {furthest:.3g} half-extents from the "
            f"body box's centre, at most {MAX_CANONICAL} are allowed (another frame?)"
        )


def _frames(
    recordings: Sequence[Recording], smooth: Sequence[DenoisedPath]
) -> list[CanonicalFrame]:
    boxes = [recording.metadata.body_box for recording in recordings]
    if all(box is not None for box in boxes):
        return [_body_frame(box) for box in boxes if box is not None]
    paths = [_sampled(path, POINT_COUNT)[1] for path in smooth]
    # By arc length, so that a rest of the hand does not pull the plane.
    points = np.concatenate(
        [resample_by_arc_length(np.zeros(len(p)), p, POINT_COUNT)[1] for p in paths]
    )
    frame = planar_frame(points) if points.shape[1] == 2 else plane_frame(points)
    return [frame] * len(recordings)


def _body_frame(box: BodyBox) -> CanonicalFrame:
    return CanonicalFrame("body_box", box.centre, box.axes[:2], box.extents[:2] / 2.0)


def planar_frame(points: FloatArray) -> CanonicalFrame:
    """The frame of a 2-D path, shape (n, 2), m: scaled and centred, not rotated."""
    return _box_frame("planar", points, np.eye(2))


def plane_frame(points: FloatArray) -> CanonicalFrame:
    """The frame of a 3-D path, shape (n, 3), m, in its own best plane.

    x is the principal axis of the points, y the second one. Each axis points
    where its largest component is positive, so that the same path gives the same
    frame however it was traversed.
    """
    centred = points - np.mean(points, axis=0)
    axes = np.linalg.svd(centred, full_matrices=False)[2][:2]
    largest = np.argmax(np.abs(axes), axis=1)
    return _box_frame(
        "path_plane", points, axes * np.sign(axes[[0, 1], largest])[:, None]
    )


def _box_frame(kind: FrameKind, points: FloatArray, axes: FloatArray) -> CanonicalFrame:
    middle = np.mean(points, axis=0)
    in_plane = (points - middle) @ axes.T
    low, high = np.min(in_plane, axis=0), np.max(in_plane, axis=0)
    scale = float(np.max(high - low)) / CANONICAL_SPAN
    origin = middle + (low + high) / 2.0 @ axes
    return CanonicalFrame(kind, origin, axes, np.array([scale, scale]))


def _sampled(path: DenoisedPath, count: int) -> tuple[FloatArray, FloatArray]:
    even = np.linspace(path.start, path.end, OVERSAMPLING * count)
    # The samples' own times too: a long recording may have more than the even ones.
    times = np.union1d(even, np.clip(path.knots, path.start, path.end))
    return times - path.start, path(times)


def _resampled(
    path: DenoisedPath, frame: CanonicalFrame, count: int
) -> tuple[FloatArray, FloatArray]:
    times, points = _sampled(path, count)
    return resample_by_arc_length(times, frame.to_canonical(points), count)
