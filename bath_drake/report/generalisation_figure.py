"""A skill's motions between ends that nobody demonstrated."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle

from bath_drake.composition.branch import Branch
from bath_drake.learning.generalisation import Generalisation, Ring
from bath_drake.report import style

_PROVED, _ARRIVED, _LOST = style.MASK, "#e08a00", style.FAIL
_TITLES = {
    "near": "As far out as demonstrated",
    "far": "Up to {:g} times as far",
    "anywhere": "Anywhere in the canonical box",
}


def draw_generalisation(found: Generalisation, branches: tuple[Branch, ...]) -> Figure:
    """A panel for each ring: its ends, and the paths between them.

    Args:
        found: The trials.
        branches: What they were trials of.
    """
    figure = style.new_figure(5.6, width=13.5)
    panels = figure.subplots(1, len(found.rings))
    paths = [path for ring in found.rings for path in ring.paths]
    every = np.concatenate([*paths, *found.corridor])
    half = 1.04 * max(1.0, float(np.abs(every).max()), *_extents(found, branches))
    for axes, ring in zip(panels, found.rings, strict=True):
        _draw_ring(axes, ring, found, branches)
        axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal")
        axes.set(xlabel="canonical x", ylabel="canonical y")
    figure.legend(handles=_legend(), loc="outside lower center", ncols=4)
    return figure


def _extents(found: Generalisation, branches: tuple[Branch, ...]) -> list[float]:
    """How far from the origin the second ring goes along an axis."""
    return [
        float(np.abs([branch.start, branch.chain.goal]).max()) + found.spread * radius
        for branch, radius in zip(branches, found.radius, strict=True)
    ]


def _draw_ring(
    axes: Axes, ring: Ring, found: Generalisation, branches: tuple[Branch, ...]
) -> None:
    for path in found.corridor:
        axes.plot(*path.T, color=style.DEMONSTRATION_SHADES[0], lw=4.0, alpha=0.7)
    frame: dict[str, Any] = {
        "fill": False,
        "ec": style.MUTED,
        "lw": 1.0,
        "ls": (0, (1, 2)),
    }
    if ring.name == "anywhere":
        axes.add_patch(Rectangle((-1, -1), 2, 2, **frame))
    else:
        times = found.spread if ring.name == "far" else 1.0
        for branch, radius in zip(branches, found.radius, strict=True):
            for centre in (branch.start, branch.chain.goal):
                axes.add_patch(Circle(tuple(centre.tolist()), times * radius, **frame))
    proved = ring.proved
    for i, path in enumerate(ring.paths):
        colour = _LOST
        if ring.arrived[i]:
            colour = _PROVED if proved[i] else _ARRIVED
        axes.plot(*path.T, color=colour, lw=0.9, alpha=0.8)
        axes.plot(*ring.starts[i], "o", color=colour, ms=4, mec="white", mew=0.4)
        axes.plot(*ring.goals[i], "*", color=colour, ms=7, mec="white", mew=0.4)
    count = len(ring.arrived)
    lines = [
        _TITLES[ring.name].format(found.spread),
        f"{int(ring.arrived.sum())} of {count} arrive, {int(proved.sum())} proved",
    ]
    axes.set_title("\n".join(lines))


def _legend() -> list[Line2D]:
    shade = style.DEMONSTRATION_SHADES[0]
    ends: dict[str, Any] = {"color": style.INK, "ls": ""}
    dotted: dict[str, Any] = {"color": style.MUTED, "lw": 1.0, "ls": (0, (1, 2))}
    return [
        Line2D([], [], color=shade, lw=4.0, label="demonstrated"),
        Line2D([], [], color=_PROVED, label="arrives, proved"),
        Line2D([], [], color=_ARRIVED, label="arrives, not proved"),
        Line2D([], [], color=_LOST, label="does not arrive"),
        Line2D([], [], marker="o", label="start", **ends),
        Line2D([], [], marker="*", ms=9, label="goal asked for", **ends),
        Line2D([], [], label="where ends are drawn", **dotted),
    ]
