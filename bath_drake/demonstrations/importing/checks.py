"""Checks that every imported track passes, and its gaps."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bath_drake.demonstrations.gaps import Gap, fill_gaps
from bath_drake.demonstrations.importing.source import Track
from bath_drake.demonstrations.recording import (
    MAX_DISTANCE,
    MAX_SPAN,
    MIN_POINTS,
    MIN_SPAN,
)
from bath_drake.demonstrations.recording_text import RESOLUTION
from bath_drake.errors import DemonstrationError
from bath_drake.notation import FloatArray

# Half a day of 100 Hz. A stroke is seconds long.
MAX_SAMPLES = 5_000_000
# More do not fit into a demonstration's file. Half an hour of 100 Hz.
MAX_STROKE = 200_000
# Strokes smaller than this, m, or sampled slower, s, look like those in other units.
USUAL_SPAN, USUAL_STEP = 5e-3, 0.5
# A hand that crosses the body in less than this many seconds is in other units.
MAX_SPEED = 20.0


@dataclass(frozen=True, eq=False)
class CheckedTrack:
    """A track fit for a demonstration.

    Attributes:
        t: (n,) s, from zero, increasing.
        points: (n, 2) or (n, 3) m, all finite.
        gaps: All gaps, filled or not, in the times of `t`.
        missing: Samples of the file with no point.
        notes: What is allowed, and yet looks like another unit.
    """

    t: FloatArray
    points: FloatArray
    gaps: tuple[Gap, ...]
    missing: int
    notes: tuple[str, ...]


def check_track(path: Path, track: Track) -> CheckedTrack:
    """Checks times, points and units of a track, and fills its short gaps.

    Raises:
        DemonstrationError: Naming the file and the sample, what was found and what is
            allowed.
    """
    t, points = track.t, track.points
    if t.size > MAX_SAMPLES:
        raise DemonstrationError(
            f"{path}: found {t.size} samples, allowed: {MAX_SAMPLES} at most"
        )
    _check_times(path, track)
    seen = np.flatnonzero(np.isfinite(points).all(axis=1))
    if seen.size < MIN_POINTS:
        raise DemonstrationError(
            f"{path}: {track.what}: found {seen.size} points, at least {MIN_POINTS} "
            "are needed"
        )
    missing = int(t.size - seen.size)
    stretch = slice(int(seen[0]), int(seen[-1]) + 1)
    t, points = t[stretch] - t[seen[0]], points[stretch]
    _check_size(path, track.what, points)
    _check_steps(path, track, t, int(seen[0]))
    points, _, gaps = fill_gaps(t, points)
    there = np.isfinite(points).all(axis=1)
    _check_speed(path, track.what, t[there], points[there])
    t, points = t[there], points[there]
    return CheckedTrack(t, points, gaps, missing, _notes(t, points))


def _check_times(path: Path, track: Track) -> None:
    bad = np.flatnonzero(~np.isfinite(track.t))
    if bad.size:
        raise DemonstrationError(
            f"{path}: {track.place(int(bad[0]))}: found time {track.t[bad[0]]}, "
            "expected a finite number"
        )
    bad = np.flatnonzero(np.diff(track.t) <= 0.0)
    if bad.size:
        k = int(bad[0])
        before, after = track.t[k], track.t[k + 1]
        how = "comes twice" if before == after else f"follows {before:.9g} s"
        raise DemonstrationError(
            f"{path}: {track.place(k + 1)}: time {after:.9g} s {how}; times must "
            "increase"
        )


def _check_size(path: Path, what: str, points: FloatArray) -> None:
    known = points[np.isfinite(points).all(axis=1)]
    span = float(np.ptp(known, axis=0).max())
    if span > MAX_SPAN:
        raise DemonstrationError(
            f"{path}: {what}: the path spans {span:.4g} m, at most {MAX_SPAN:g} m are "
            "allowed (millimetres? then --units mm)"
        )
    if (far := float(np.abs(known).max())) > MAX_DISTANCE:
        raise DemonstrationError(
            f"{path}: {what}: a point is {far:.4g} m from the origin, at most "
            f"{MAX_DISTANCE:g} m are allowed (millimetres? then --units mm)"
        )
    if span < MIN_SPAN:
        raise DemonstrationError(
            f"{path}: {what}: the path has no length (it spans {span:.3g} m)"
        )


def _check_speed(path: Path, what: str, t: FloatArray, points: FloatArray) -> None:
    speed = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(t)
    usual = float(np.median(speed))
    if usual > MAX_SPEED:
        raise DemonstrationError(
            f"{path}: {what}: the hand moves at {usual:.4g} m/s, at most "
            f"{MAX_SPEED:g} m/s are allowed (milliseconds? then --time-units s, or "
            "--units mm)"
        )


def _check_steps(path: Path, track: Track, t: FloatArray, first: int) -> None:
    """Refuses what a demonstration's file cannot hold."""
    if t.size > MAX_STROKE:
        raise DemonstrationError(
            f"{path}: {track.what}: the stroke has {t.size} samples, at most "
            f"{MAX_STROKE} are allowed; cut it out with --start and --end"
        )
    close = np.flatnonzero(np.diff(np.round(t / RESOLUTION)) <= 0.0)
    if close.size:
        k = int(close[0])
        raise DemonstrationError(
            f"{path}: {track.place(first + k + 1)}: follows after "
            f"{t[k + 1] - t[k]:.3g} s, at least {RESOLUTION:g} s are allowed (seconds? "
            "then --time-units s)"
        )


def _notes(t: FloatArray, points: FloatArray) -> tuple[str, ...]:
    notes = []
    span, step = float(np.ptp(points, axis=0).max()), float(np.median(np.diff(t)))
    if span < USUAL_SPAN:
        notes.append(f"the stroke is {1e3 * span:.3g} mm long: metres? then --units m")
    if step > USUAL_STEP:
        notes.append(f"a sample every {step:.3g} s: milliseconds? then --time-units ms")
    return tuple(notes)
