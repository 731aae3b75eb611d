"""A field and its certificate in one picture: what is proved, and where it is not."""

import textwrap
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon, Rectangle
from matplotlib.patheffects import withStroke
from scipy.ndimage import grey_dilation

from bath_drake.certificate.result import Box, Certificate
from bath_drake.field.navigation import NavigationField, min_beta, psi
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.field.rollout import RolloutStatus, rollout, rollout_ends
from bath_drake.notation import FloatArray, IntArray
from bath_drake.report import style
from bath_drake.report.field_figures import (
    draw_flow,
    draw_obstacles,
    workspace_outline,
)

# Even, so that no start lies on an axis of symmetry, whose flow leads onto a saddle.
_STARTS = 200
_GOAL, _TRAP, _STALLED = 0, 1, 2
_BASINS = {
    _GOAL: ("#dcefe4", "starts that end at the goal"),
    _TRAP: ("#f3bfb5", "starts that end in a trap"),
    _STALLED: ("#f5e7a8", "starts that stall, as at a saddle"),
}
_MARKS = {
    "saddle": ("X", "#e69f00", "saddle"),
    "minimum": ("v", style.FAIL, "minimum: a trap"),
    "maximum": ("^", style.DEMONSTRATION, "maximum"),
    "degenerate": ("P", style.RESTRICTED, "degenerate"),
}
VERDICTS = {"proved": style.PASS, "refuted": style.FAIL, "undecided": "#9a6b00"}
# A box narrower than this share of the picture is drawn as large, to be seen.
_SMALLEST = 0.035


def draw_certificate(
    field: NavigationField,
    certificate: Certificate,
    start: FloatArray | None = None,
    sensed: int = 0,
) -> Figure:
    """Draws a field, its critical points and basins, and what the proof left open.

    Args:
        field: The field that was certified.
        certificate: Of this field.
        start: (2,) a skill's start, if there is one.
        sensed: How many of the obstacles, the last, are restricted areas.
    """
    figure = style.new_figure(7.1, width=10.4)
    figure.set_layout_engine("constrained", h_pad=0.12, w_pad=0.08)
    axes = figure.subplots()
    handles: list[Artist] = [*draw_basins(axes, field, certificate)]
    draw_flow(axes, field, shade=False)
    learned = len(field.obstacles) - sensed
    theta = field.obstacles.theta
    draw_obstacles(axes, ObstacleSet(theta[:learned]), "obstacle")
    areas = ObstacleSet(theta[learned:])
    draw_obstacles(axes, areas, "restricted area", style.RESTRICTED)
    handles += draw_region(axes, field, certificate)
    handles += draw_boxes(axes, field, certificate)
    draw_points(axes, certificate)
    _draw_ways_into_traps(axes, field, certificate)
    common: dict[str, Any] = {"mec": "white", "mew": 0.9, "ls": "", "zorder": 6}
    if start is not None:
        path = rollout(start, field).path
        axes.plot(*path.T, color=style.INK, lw=2.0, zorder=4, label="way of the start")
        axes.plot(*start, "o", color=style.INK, ms=8, label="start", **common)
    axes.plot(*field.goal, "*", color=style.INK, ms=15, label="goal", **common)
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_xlabel("canonical x [–]")
    axes.set_ylabel("canonical y [–]")
    _write_title(figure, field, certificate)
    named, _ = axes.get_legend_handles_labels()
    axes.legend(
        handles=[*named, *handles],
        loc="upper left",
        bbox_to_anchor=(1.02, 1.0),
        borderaxespad=0.0,
        labelspacing=0.75,
    )
    return figure


@dataclass(frozen=True, eq=False)
class _Basins:
    """Where roll-outs from a grid end: the grid's extent and a kind for each cell."""

    extent: tuple[float, float, float, float]
    kinds: IntArray

    def share(self, kind: int) -> float:
        """Of the free cells, those of a kind; zero where none is free."""
        free = self.kinds[self.kinds >= 0]
        return float(np.mean(free == kind)) if free.size else 0.0


def _find_basins(
    field: NavigationField, certificate: Certificate, count: int
) -> _Basins:
    """Rolls out from the middle of every cell of the workspace's box."""
    centre, semi = field.workspace.centre, field.workspace.semi_axes
    t = (np.arange(count) + 0.5) / count * 2.0 - 1.0
    x, y = np.meshgrid(centre[0] + semi[0] * t, centre[1] + semi[1] * t)
    starts = np.stack([x.ravel(), y.ravel()], axis=1)
    kinds = np.full(len(starts), -1)
    free = np.flatnonzero(min_beta(starts, field) > 0.0)
    low, high = centre - semi, centre + semi
    extent = (low[0], high[0], low[1], high[1])
    if not min_beta(field.goal, field) > 0.0:
        # Nothing arrives at a goal that is covered or outside.
        kinds[free] = _STALLED
        return _Basins(extent, kinds.reshape(count, count))
    statuses, ends = rollout_ends(
        starts[free], field, step=float(semi.min()) / 100.0, max_steps=4000
    )
    kinds[free] = [
        _GOAL if status is RolloutStatus.ARRIVED else _end_kind(end, certificate)
        for status, end in zip(statuses, ends, strict=True)
    ]
    return _Basins(extent, kinds.reshape(count, count))


def _end_kind(end: FloatArray, certificate: Certificate) -> int:
    """A trap if of all critical points a minimum is nearest to where it ended."""
    points = certificate.critical_points
    if not points:
        return _STALLED
    nearest = min(points, key=lambda p: np.hypot(p.x - end[0], p.y - end[1]))
    return _TRAP if nearest.kind == "minimum" else _STALLED


def draw_basins(
    axes: Axes, field: NavigationField, certificate: Certificate, count: int = _STARTS
) -> list[Patch]:
    """Colours starts by where they end, ``count`` a side; returns the legend's part."""
    basins = _find_basins(field, certificate, count)
    # Cells cut by a boundary look like their neighbours, up to the boundary.
    beside = grey_dilation(basins.kinds, size=(3, 3))
    kinds = np.where(basins.kinds < 0, beside, basins.kinds)
    image = np.ones((*kinds.shape, 3))
    handles = []
    for kind, (colour, text) in _BASINS.items():
        image[kinds == kind] = style.rgb(colour)
        share = basins.share(kind)
        if share > 0.0:
            label = f"{text}: {100 * share:.3g} %"
            handles.append(Patch(facecolor=colour, edgecolor=style.MUTED, label=label))
    shown = axes.imshow(
        image,
        extent=basins.extent,
        origin="lower",
        interpolation="nearest",
        zorder=0.5,
        aspect="equal",
    )
    rim = Polygon(
        workspace_outline(field.workspace), facecolor="none", edgecolor="none"
    )
    axes.add_patch(rim)
    shown.set_clip_path(rim)
    return handles


def draw_region(
    axes: Axes, field: NavigationField, certificate: Certificate
) -> list[Line2D]:
    """The rim of the certified sublevel set, where it is not all free space."""
    if certificate.region is None:
        return []
    centre, semi = field.workspace.centre, field.workspace.semi_axes
    t = np.linspace(-1.0, 1.0, 301)
    x, y = centre[0] + semi[0] * t, centre[1] + semi[1] * t
    height = psi(np.stack(np.meshgrid(x, y), axis=-1), field)
    high = np.nanmax(height[np.isfinite(height)])
    height = np.clip(height, None, high)
    axes.contour(
        x, y, height, levels=[certificate.region], colors=style.PASS, linewidths=2.2
    )
    label = "rim of what was certified"
    if certificate.apart:
        label += ",\nof its part about the start"
    return [Line2D([], [], color=style.PASS, lw=2.2, label=label)]


def draw_boxes(
    axes: Axes, field: NavigationField, certificate: Certificate
) -> list[Patch]:
    """Boxes of traps and of doubts; tiny ones as frames around them."""
    smallest = _SMALLEST * 2.0 * float(field.workspace.semi_axes.max())
    handles = []
    traps = [trap.box for trap in certificate.traps]
    doubts = [doubt.box for doubt in certificate.doubts]
    for boxes, colour, text in (
        (traps, style.FAIL, "proved: a minimum in it"),
        (doubts, "#9a6b00", "undecided"),
    ):
        if not boxes:
            continue
        for box in boxes:
            axes.add_patch(_frame(box, smallest, colour))
        label = f"{text}, {_widths(boxes)}"
        handles.append(Patch(facecolor="none", edgecolor=colour, lw=1.8, label=label))
    return handles


def _frame(box: Box, smallest: float, colour: str) -> Rectangle:
    x, y = box.centre
    width = max(box.x_max - box.x_min, smallest)
    height = max(box.y_max - box.y_min, smallest)
    return Rectangle(
        (x - width / 2.0, y - height / 2.0),
        width,
        height,
        fill=False,
        edgecolor=colour,
        lw=1.8,
        zorder=5.5,
        path_effects=[withStroke(linewidth=4.0, foreground="white")],
    )


def _widths(boxes: Iterable[Box]) -> str:
    widths = [box.width for box in boxes]
    many = f"{len(widths)} boxes, up to" if len(widths) > 1 else "box"
    return f"{many} {max(widths):.1g} wide"


def draw_points(axes: Axes, certificate: Certificate) -> None:
    """Marks the critical points, with labels."""
    for kind, (mark, colour, text) in _MARKS.items():
        points = [(p.x, p.y) for p in certificate.critical_points if p.kind == kind]
        if points:
            label = text if len(points) == 1 else f"{text} ({len(points)})"
            axes.plot(
                *np.array(points).T,
                mark,
                color=colour,
                mec="white",
                mew=0.9,
                ms=10,
                ls="",
                zorder=5,
                label=label,
            )


def _draw_ways_into_traps(
    axes: Axes, field: NavigationField, certificate: Certificate
) -> None:
    label = "a way into it"
    for trap in certificate.traps:
        path = rollout(trap.start, field).path
        axes.plot(*path.T, color=style.FAIL, lw=2.0, zorder=4, label=label)
        label = ""


def _write_title(
    figure: Figure, field: NavigationField, certificate: Certificate
) -> None:
    colour = VERDICTS[certificate.verdict]
    figure.suptitle(
        textwrap.fill(f"{certificate.verdict.upper()}: {certificate.reason}", 84),
        color=colour,
        weight="bold",
        size=13,
    )
    count = len(field.obstacles)
    text = (
        f"{count} obstacle{'' if count == 1 else 's'}, κ {field.kappa:.4g}; "
        f"{certificate.boxes} boxes looked at"
    )
    figure.supxlabel(text, size=9, color=style.MUTED)
