"""The picture of a capture: frames with the track on the body, and the stroke in N."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from bath_drake.demonstrations.canonical import CanonicalDemonstration
from bath_drake.demonstrations.capture.pipeline import Capture
from bath_drake.demonstrations.rgbd.folder import RgbdFolder
from bath_drake.notation import FloatArray
from bath_drake.report import style

ROWS, COLUMNS = 2, 3
# Around the back and the track are left, as a share of their size.
MARGIN = 0.25
TICKS = (-1.0, -0.5, 0.0, 0.5, 1.0)


def draw_capture(
    recording: RgbdFolder, found: Capture, learned: CanonicalDemonstration
) -> Figure:
    """Draws six frames of a stroke and, beside them, the stroke in N.

    Args:
        recording: The frames.
        found: What was captured from them.
        learned: How the stroke will be learned.
    """
    figure = style.new_figure(5.8, width=13.0)
    parts: Any = figure.subfigures(1, 2, width_ratios=[1.7, 1.0])
    frames, canonical = parts
    stroke = found.stroke
    shown = np.flatnonzero([pose is not None for pose in found.poses])
    shown = shown[(shown >= stroke.first) & (shown <= stroke.last)]
    picks = shown[np.linspace(0, len(shown) - 1, ROWS * COLUMNS).astype(np.int64)]
    grid = frames.subplots(ROWS, COLUMNS, sharex=True, sharey=True)
    for axes, k in zip(grid.flat, picks.tolist(), strict=True):
        _draw_frame(axes, recording, found, k)
    _crop(grid.flat[0], recording, found)
    frames.supxlabel("column [px]", fontsize=10.0)
    frames.supylabel("row [px]", fontsize=10.0)
    _draw_canonical(canonical.subplots(), found, learned)
    return figure


def _pixels(
    recording: RgbdFolder, found: Capture, frame: int, points_P: FloatArray
) -> FloatArray:
    """Where points (n, 3) of the back's frame are in a frame's image, (n, 2)."""
    pose, own = found.poses[frame], found.body.canonical_map
    assert pose is not None
    p_C = pose.to_camera(points_P @ own.R_WP.T + own.p_WP)
    # Matplotlib has a pixel's centre at its index, the camera half a pixel further.
    return recording.camera.project(p_C) - 0.5


def _draw_frame(axes: Axes, recording: RgbdFolder, found: Capture, frame: int) -> None:
    image = recording.frame(frame)
    time = recording.files[frame].t - recording.files[0].t
    stroke = found.stroke
    done = stroke.points[stroke.t <= time + 1e-9]
    axes.imshow(image.colour)
    half = found.body.canonical_map.half_extents
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * half
    box = np.column_stack([corners, np.zeros(5)])
    axes.plot(*_pixels(recording, found, frame, box).T, color=style.BOX, lw=1.0)
    track = _pixels(recording, found, frame, done)
    axes.plot(*track.T, color=style.REPRODUCTION, lw=1.3)
    if np.isfinite(found.markers_C[frame]).all():
        centre = recording.camera.project(found.markers_C[frame][None])[0] - 0.5
        axes.plot(*centre, "o", ms=9, mfc="none", mec="white", mew=1.4)
    axes.set_title(f"{time:.1f} s", fontsize=9.0)
    axes.tick_params(labelsize=7.0)
    axes.grid(False)


def _crop(axes: Axes, recording: RgbdFolder, found: Capture) -> None:
    rows, columns = np.nonzero(found.body.back)
    side = max(np.ptp(rows), np.ptp(columns)) * (0.5 + MARGIN)
    row, column = (rows.min() + rows.max()) / 2, (columns.min() + columns.max()) / 2
    axes.set_xlim(column - side, column + side)
    axes.set_ylim(row + side, row - side)


def _draw_canonical(
    axes: Axes, found: Capture, learned: CanonicalDemonstration
) -> None:
    stroke = found.stroke
    raw = learned.raw
    axes.add_patch(
        Rectangle((-1, -1), 2, 2, fill=False, ec=style.MUTED, ls=":", label="body box")
    )
    axes.plot(*raw.T, ".", color=style.DEMONSTRATION, ms=4, label="marker")
    if stroke.filled.any():
        axes.plot(
            *raw[stroke.filled].T, "x", color=style.INK, ms=6, label="filled (≤ 0.2 s)"
        )
    what = "stroke" if learned.periodic is None else "stroke without its cycles"
    axes.plot(*learned.points.T, color=style.REPRODUCTION, lw=1.3, label=what)
    label: str | None = "gap"
    for gap in stroke.gaps:
        if not gap.filled:
            ends = np.searchsorted(stroke.t, [gap.start - 1e-9, gap.end - 1e-9])
            axes.plot(*raw[ends].T, color=style.FAIL, lw=2.5, alpha=0.6, label=label)
            label = None
    axes.plot(*raw[0], "o", color=style.INK, ms=8, label="start")
    axes.plot(*raw[-1], "*", color=style.INK, ms=13, label="end")
    reach = 1.08 * max(1.0, float(np.abs(raw).max()))
    axes.set(
        xlim=(-reach, reach),
        ylim=(-reach, reach),
        aspect="equal",
        xticks=TICKS,
        yticks=TICKS,
        xlabel="canonical x, to the person's right [–]",
        ylabel="canonical y, to the head [–]",
        title="The stroke on the back",
    )
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3)
