"""Each demonstration against the skill learned from the others."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bath_drake.learning.held_out import HeldOut
from bath_drake.learning_figures import plane
from bath_drake.report import style


def held_out_figure(found: HeldOut) -> Figure:
    """The distances, in-sample and held out, and the motions beside the strokes."""
    count = len(found.names)
    figure = style.new_figure(max(5.2, 1.6 + 0.34 * count), width=12.5)
    left, right = figure.subplots(1, 2, width_ratios=[1.15, 1.0])
    _draw_distances(left, found)
    plane.show(right, *found.strokes, *found.paths)
    for i, (stroke, path) in enumerate(zip(found.strokes, found.paths, strict=True)):
        shown = "demonstrated" if i == 0 else None
        right.plot(*stroke.T, color=style.demonstration_shade(i), lw=1.6, label=shown)
        shown = "reproduced without having seen it" if i == 0 else None
        right.plot(*path.T, color=style.REPRODUCTION, lw=1.1, label=shown)
        right.plot(*stroke[0], "o", color=style.INK, ms=6, **plane.MARKS)
    _number_starts(right, found)
    right.set_title("What was foreseen from the start alone")
    plane.legend_below(right, columns=1)
    return figure


def _number_starts(axes: Axes, found: HeldOut) -> None:
    """Numbers in a row behind the starts, each with a line to its own."""
    starts = np.array([stroke[0] for stroke in found.strokes])
    ahead = np.array([stroke[min(8, len(stroke) - 1)] for stroke in found.strokes])
    back = (starts - ahead).mean(axis=0)
    back /= max(float(np.hypot(*back)), 1e-9)
    across = np.array([-back[1], back[0]])
    order = np.argsort(starts @ across)
    for rank, i in enumerate(order):
        aside = 24.0 * back + 15.0 * (rank - 0.5 * (len(order) - 1)) * across
        axes.annotate(
            str(i + 1),
            (float(starts[i, 0]), float(starts[i, 1])),
            (float(aside[0]), float(aside[1])),
            textcoords="offset points",
            ha="center",
            va="center",
            size=9,
            zorder=8,
            bbox={"fc": "white", "ec": "none", "pad": 0.8, "alpha": 0.85},
            arrowprops={"arrowstyle": "-", "color": style.MUTED, "lw": 0.6},
        )


def _draw_distances(axes: Axes, found: HeldOut) -> None:
    rows = np.arange(len(found.names))
    inside, outside = np.array(found.in_sample), np.array(found.distances)
    axes.hlines(rows, inside, outside, color=style.MUTED, lw=1.4, zorder=1)
    axes.plot(inside, rows, "o", color=style.DEMONSTRATION, ms=7, label="in-sample")
    axes.plot(outside, rows, "D", color=style.REPRODUCTION, ms=7, label="held out")
    lost = ~np.array(found.arrived, dtype=bool)
    if lost.any():
        axes.plot(
            outside[lost],
            rows[lost],
            "x",
            color=style.INK,
            ms=11,
            label="did not arrive",
        )
    median = float(np.median(outside))
    axes.axvline(
        median, color=style.REPRODUCTION, ls="--", lw=1.0, label=f"median {median:.4f}"
    )
    axes.set_yticks(rows, [f"{i + 1}  {name}" for i, name in enumerate(found.names)])
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_xlim(left=0.0)
    axes.set_xlabel("Fréchet distance, over scale")
    axes.set_title("Learned from all, and from all the others")
    plane.legend_below(axes, columns=4)
