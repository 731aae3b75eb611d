"""What the pictures of the canonical plane have in common."""

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from bath_drake.composition.chain import Chain
from bath_drake.composition.rollout import ChainRollout
from bath_drake.field.navigation import NavigationField, flow_direction, min_beta
from bath_drake.notation import FloatArray
from bath_drake.report import style

MARKS: dict[str, Any] = {"mec": "white", "mew": 0.9, "ls": "", "zorder": 7}
_ARROWS = 21  # a side of the view
_VIEW = 0.58  # of the content's longer side, from the middle to an edge


def stage_colours(count: int) -> FloatArray:
    """A colour for each stage of a chain, shape (count, 4); red for a single field."""
    if count == 1:
        return np.array([mpl.colors.to_rgba(style.REPRODUCTION)])
    return np.asarray(mpl.colormaps["viridis"](np.linspace(0.0, 0.8, count)))


def show(axes: Axes, *points: FloatArray) -> None:
    """A square view on points (n, 2), with named axes."""
    every = np.concatenate(points)
    low, high = every.min(axis=0), every.max(axis=0)
    half = _VIEW * max(float((high - low).max()), 0.1)
    middle = 0.5 * (low + high)
    axes.set_xlim(middle[0] - half, middle[0] + half)
    axes.set_ylim(middle[1] - half, middle[1] + half)
    axes.set_aspect("equal")
    axes.set(xlabel="canonical x", ylabel="canonical y")


def draw_demonstrations(
    axes: Axes, paths: Sequence[FloatArray], mean: FloatArray | None = None
) -> None:
    """Demonstrations (T, 2) in light blue, their mean dashed."""
    for index, path in enumerate(paths):
        colour = style.demonstration_shade(index)
        label = "demonstrations" if index == 0 else None
        axes.plot(*path.T, color=colour, lw=1.4, label=label)
    if mean is not None:
        axes.plot(*mean.T, color=style.INK, lw=1.2, ls="--", label="their mean")


def draw_ends(axes: Axes, start: FloatArray, goal: FloatArray) -> None:
    """Start and goal, both (2,)."""
    axes.plot(*start, "o", color=style.INK, ms=8, label="start", **MARKS)
    axes.plot(*goal, "*", color=style.INK, ms=14, label="goal", **MARKS)


def draw_chain(axes: Axes, chain: Chain, found: ChainRollout) -> None:
    """Obstacles, gates and path of each stage in its colour, numbered on the path."""
    colours = stage_colours(len(chain))
    for k, colour in enumerate(colours):
        label = "virtual obstacles" if k == 0 else None
        shade = style.OBSTACLE if len(chain) == 1 else colour
        draw_obstacles(axes, chain.fields[k], shade, label)
        if k < len(chain.gates):
            label = "gates" if k == 0 else None
            outline = chain.gates[k].outline()
            axes.plot(*outline.T, color=colour, lw=1.0, ls="--", label=label)
        part = path_of(found, k)
        if part is not None:
            label = "reproduction" if k == 0 else None
            axes.plot(*part.T, color=colour, lw=2.6, zorder=4, label=label)
            if len(chain) > 1:
                number(axes, part[len(part) // 2], k + 1, colour)


def number(axes: Axes, at: FloatArray, value: int, colour: Any) -> None:
    """A stage's number in a disc at a point (2,)."""
    axes.text(
        float(at[0]),
        float(at[1]),
        str(value),
        size=8,
        weight="bold",
        ha="center",
        va="center",
        zorder=6,
        bbox={"boxstyle": "circle,pad=0.25", "fc": "white", "ec": colour, "lw": 1.3},
    )


def path_of(found: ChainRollout, stage: int) -> FloatArray | None:
    """The part (n, 2) of a path that a stage leads, to where the next takes over."""
    at = np.flatnonzero(found.stages == stage)
    return found.path[at[0] : at[-1] + 2] if len(at) else None


def draw_obstacles(
    axes: Axes, field: NavigationField, colour: Any, label: str | None = None
) -> None:
    """Ellipses, which do not change the view."""
    for outline in field.obstacles.boundary(96):
        axes.add_patch(
            Polygon(
                outline,
                facecolor=mpl.colors.to_rgba(colour, 0.45),
                edgecolor=colour,
                lw=1.0,
                zorder=2.5,
                label=label,
            )
        )
        label = None


def draw_flow(axes: Axes, field: NavigationField) -> None:
    """The flow's direction in the view, where the field is free."""
    x = np.linspace(*axes.get_xlim(), 2 * _ARROWS + 1)[1::2]
    y = np.linspace(*axes.get_ylim(), 2 * _ARROWS + 1)[1::2]
    q = np.stack(np.meshgrid(x, y), axis=-1)
    q = q[min_beta(q, field) > 0.0]
    axes.quiver(
        *q.T,
        *flow_direction(q, field).T,
        color="#b4bcc6",
        pivot="mid",
        angles="xy",
        units="width",
        width=0.0026,
        scale=1.45 * _ARROWS,
        zorder=1,
    )


def legend_below(axes: Axes, columns: int = 3) -> None:
    """The legend under the axes, off everything that is drawn."""
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=columns)
