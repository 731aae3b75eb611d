"""Demonstrations before anyone learns from them: paths, coordinates, speed, gaps."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bath_drake.demonstrations.canonical import CanonicalDemonstration, CanonicalFrame
from bath_drake.demonstrations.hand_motion import HandMotion
from bath_drake.demonstrations.recording import Recording
from bath_drake.report import style

_COLOURS = ("#0b5fa5", "#d7301f", "#00a37a", "#aa3377", "#e08214", "#4a4f57")
_DASHES = ("-", "--", ":")
_MOST_NAMED = 12


def draw_recordings(
    recordings: Sequence[Recording],
    demonstrations: Sequence[CanonicalDemonstration],
    motions: Sequence[HandMotion],
    frame: CanonicalFrame,
) -> Figure:
    """Draws recordings as they are and as processing sees them.

    Args:
        recordings: As read.
        demonstrations: The same, processed, in N.
        motions: The same, as the hand moved.
        frame: The map to N.
    """
    figure = style.new_figure(7.2, width=13.0)
    grid = figure.add_gridspec(3, 2, width_ratios=[1.25, 1.0])
    path = figure.add_subplot(grid[:, 0])
    x, y, speed = (figure.add_subplot(grid[k, 1]) for k in range(3))
    for index, (recording, d, motion) in enumerate(
        zip(recordings, demonstrations, motions, strict=True)
    ):
        _draw_path(path, index, d, motion)
        for axes, k in ((x, 0), (y, 1)):
            _draw_coordinate(axes, index, recording, d, k)
        colour, dash = _look(index)
        since = motion.t - recording.t[0]
        speed.plot(since, motion.speed, dash, color=colour, lw=1.2)
    if frame.kind == "body_box":
        square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
        path.plot(*square.T, ":", color=style.MUTED, lw=1.0, label="the body's box")
    if any(motion.outliers.size for motion in motions):
        path.plot([], [], "x", color=style.FAIL, label="outlier, left out")
    if len(recordings) > _MOST_NAMED:
        rest = len(recordings) - _MOST_NAMED
        path.plot([], [], " ", label=f"and {rest} more")
    path.set(
        xlabel="x in N"
        + (" (to the person's right)" if frame.kind == "body_box" else ""),
        ylabel="y in N" + (" (to the head)" if frame.kind == "body_box" else ""),
        aspect="equal",
    )
    path.set_title("Paths: as recorded (thin), processed (thick); o start, * goal")
    # Below the axis label, however low the axes are.
    path.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), borderaxespad=4, ncols=3)
    x.set(ylabel="x in N")
    y.set(ylabel="y in N")
    speed.set(ylabel="speed, m/s", xlabel="time, s")
    speed.set_ylim(bottom=0.0)
    x.set_title("Over time; gaps are shaded")
    for axes in (x, y):
        axes.tick_params(labelbottom=False)
        axes.sharex(speed)
    return figure


def _look(index: int) -> tuple[str, str]:
    dash = _DASHES[(index // len(_COLOURS)) % len(_DASHES)]
    return _COLOURS[index % len(_COLOURS)], dash


def _draw_path(
    axes: Axes, index: int, d: CanonicalDemonstration, motion: HandMotion
) -> None:
    colour, dash = _look(index)
    axes.plot(*d.raw.T, color=colour, lw=0.8, alpha=0.55)
    name = d.name if index < _MOST_NAMED else None
    axes.plot(*d.points.T, dash, color=colour, lw=2.2, label=name)
    axes.plot(*d.points[0], "o", color=colour, ms=7, mec="white")
    axes.plot(*d.points[-1], "*", color=colour, ms=12, mec="white")
    axes.plot(*d.raw[motion.outliers].T, "x", color=style.FAIL, ms=7, mew=1.6)


def _draw_coordinate(
    axes: Axes, index: int, recording: Recording, d: CanonicalDemonstration, k: int
) -> None:
    colour, dash = _look(index)
    since = recording.t - recording.t[0]
    axes.plot(since, d.raw[:, k], color=colour, lw=0.7, alpha=0.55)
    # The common goal is not the recording's own.
    own = d.points[:, k] + d.goal_offset[k]
    axes.plot(d.times, own, dash, color=colour, lw=1.8)
    for start, end in recording.metadata.gaps:
        low, high = start - recording.t[0], end - recording.t[0]
        axes.axvspan(low, high, color=colour, alpha=0.15, lw=0)
