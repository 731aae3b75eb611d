"""Checks that every imported track passes, and its gaps."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bath_drake.demonstrations.gaps import Gap, fill_gaps
from bath_drake.demonstrations.importing.source import Track
from bath_drake.demonstrations.recording import MAX_SPAN, MIN_POINTS, MIN_SPAN
from bath_drake.errors import DemonstrationError
from bath_drake.notation import FloatArray

# Half a day of 100 Hz. A stroke is seconds long.
MAX_SAMPLES = 5_000_000
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
    """

    t: FloatArray
    points: FloatArray
    gaps: tuple[Gap, ...]
    missing: int


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
    points, _, gaps = fill_gaps(t, points)
    there = np.isfinite(points).all(axis=1)
    _check_speed(path, track.what, t[there], points[there])
    return CheckedTrack(t[there], points[there], gaps, missing)


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
