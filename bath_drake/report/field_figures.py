"""Figures in canonical space: demonstrations, learned field, executed path."""

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from bath_drake.composition.chain import Chain
from bath_drake.composition.rollout import chain_rollout
from bath_drake.field.navigation import (
    NavigationField,
    flow_direction,
    ln_phi,
    min_beta,
)
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import FloatArray
from bath_drake.report import style

_GRID = 181
_LEVELS = 14
_HEIGHT_MAP = LinearSegmentedColormap.from_list("height", ["#ffffff", "#c3ccd6"])


def draw_demonstrations(
    raw: Sequence[FloatArray], processed: Sequence[FloatArray], mean: FloatArray
) -> Figure:
    """Draws demonstrations as recorded and as processed, (n, 2) each, in N."""
    figure = style.new_figure(4.6)
    left, right = figure.subplots(1, 2)
    for index, path in enumerate(raw):
        shade = style.demonstration_shade(index)
        label = f"recording {index + 1}"
        left.plot(*path.T, ".-", color=shade, lw=0.8, ms=3.0, label=label)
    left.set_title("As recorded")
    for index, path in enumerate(processed):
        shade = style.demonstration_shade(index)
        right.plot(*path.T, color=shade, lw=1.6, label=f"demonstration {index + 1}")
    right.plot(*mean.T, color=style.DEMONSTRATION, lw=2.4, label="arc-length mean")
    right.set_title("Denoised, equally spaced by arc length")
    _mark_ends(right, mean[0], mean[-1])
    for axes in (left, right):
        _canonical_axes(axes)
        _body_box(axes)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2)
    return figure


def draw_chain(
    chain: Chain,
    demonstrations: Sequence[FloatArray],
    mean: FloatArray,
    rollout: FloatArray,
    frechet: str,
) -> Figure:
    """Draws the learned fields, and their roll-out on the demonstrations.

    Args:
        chain: The learned fields, one or more.
        demonstrations: Paths (n, 2) in N.
        mean: Their mean (n, 2).
        rollout: The chain's own path (n, 2) from the learned start.
        frechet: What to say about the distance of the two.
    """
    figure = style.new_figure(5.4)
    left, right = figure.subplots(1, 2, width_ratios=[1.12, 1.0])
    if len(chain) == 1:
        draw_flow(left, chain.fields[0])
        draw_obstacles(left, chain.fields[0].obstacles, "virtual obstacle")
        left.plot(*rollout.T, color=style.REPRODUCTION, lw=2.4, label="reproduction")
        left.set_title("Learned field: ln φ (grey) and flow along −∇φ")
    else:
        _draw_stages(left, chain, rollout[0])
        left.set_title(f"Learned chain of {len(chain)} fields, followed in turn")
    _mark_ends(left, rollout[0], chain.goal)
    _canonical_axes(left, grid=False)
    for index, path in enumerate(demonstrations):
        right.plot(*path.T, color=style.demonstration_shade(index), lw=1.2)
    right.plot(*mean.T, color=style.DEMONSTRATION, lw=2.4, label="demonstrations, mean")
    right.plot(*rollout.T, color=style.REPRODUCTION, lw=2.0, label="reproduction")
    _mark_ends(right, rollout[0], chain.goal)
    _zoom(right, [*demonstrations, mean, rollout])
    _canonical_axes(right)
    right.set_title(f"Reproduction: {frechet}")
    for axes in (left, right):
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.11), ncols=2)
    return figure


def _draw_stages(axes: Axes, chain: Chain, start: FloatArray) -> None:
    """Obstacles, gates and pieces of the path of a chain, a colour for each field."""
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.88, len(chain)))
    found = chain_rollout(start, chain)
    for k, (field, colour) in enumerate(zip(chain.fields, colours, strict=True)):
        draw_obstacles(axes, field.obstacles, f"obstacles of field {k + 1}", colour)
        at = np.flatnonzero(found.stages == k)
        if len(at):
            piece = found.path[at[0] : at[-1] + 2]
            axes.plot(*piece.T, color=colour, lw=2.6, zorder=3)
        if k < len(chain.gates):
            axes.plot(*chain.gates[k].outline().T, color=colour, lw=0.9, ls="--")
    rim = workspace_outline(chain.fields[0].workspace)
    _zoom(axes, [found.path, *(gate.outline() for gate in chain.gates)])
    axes.plot(*rim.T, color=style.INK, lw=1.4, scalex=False, scaley=False)


def draw_executed(
    executed: FloatArray,
    mean: FloatArray,
    demonstrations: Sequence[FloatArray],
    rollout: FloatArray,
    wounds: Sequence[FloatArray],
    areas: ObstacleSet,
    frechet: str,
    discrete: FloatArray | None = None,
) -> Figure:
    """Draws where the skin was washed, in the true canonical space.

    Args:
        executed: Washed points (n, 2).
        mean: Mean demonstration (n, 2).
        demonstrations: Paths (n, 2).
        rollout: The plan without restricted areas (n, 2).
        wounds: True outlines (m, 2) of restricted areas.
        areas: The areas as last sensed by the camera.
        frechet: What to say about the distance to the mean demonstration.
        discrete: Washed points (n, 2) without the periodic motion, if there is one.
    """
    figure = style.new_figure(5.6, width=8.2)
    axes = figure.subplots()
    for index, path in enumerate(demonstrations):
        shade = style.demonstration_shade(index)
        axes.plot(*path.T, color=shade, lw=1.2, alpha=0.8)
    axes.plot(*mean.T, color=style.DEMONSTRATION, lw=2.4, label="demonstrations, mean")
    axes.plot(
        *rollout.T,
        color=style.REPRODUCTION,
        lw=1.1,
        ls=(0, (4, 3)),
        label="learned plan",
    )
    thick = 2.4 if discrete is None else 1.2
    axes.plot(
        *executed.T, color=style.REPRODUCTION, lw=thick, label="washed on the skin"
    )
    if discrete is not None:
        label = "washed, less the cycles"
        axes.plot(*discrete.T, color=style.INK, lw=1.6, label=label)
    for index, outline in enumerate(wounds):
        axes.add_patch(
            Polygon(
                outline,
                facecolor=style.RESTRICTED,
                alpha=0.55,
                edgecolor=style.RESTRICTED,
                label="wound, true outline" if index == 0 else None,
            )
        )
    for index, outline in enumerate(areas.boundary(96)):
        axes.add_patch(
            Polygon(
                outline,
                fill=False,
                edgecolor=style.RESTRICTED,
                lw=1.6,
                ls="--",
                label="restricted area as sensed" if index == 0 else None,
            )
        )
    _mark_ends(axes, rollout[0], rollout[-1])
    _canonical_axes(axes)
    _body_box(axes)
    axes.set_title(f"Executed against demonstrated\n{frechet}")
    axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    return figure


def draw_flow(axes: Axes, field: NavigationField, *, shade: bool = True) -> None:
    """Draws level sets of ln phi, shaded or as lines alone, flow and workspace."""
    centre, semi = field.workspace.centre, field.workspace.semi_axes
    reach = 1.04 * semi
    x = np.linspace(centre[0] - reach[0], centre[0] + reach[0], _GRID)
    y = np.linspace(centre[1] - reach[1], centre[1] + reach[1], _GRID)
    q = np.stack(np.meshgrid(x, y), axis=-1)
    free = min_beta(q, field) > 0.0
    height = np.where(free, ln_phi(q, field), np.nan)
    known = height[np.isfinite(height)]
    # phi is close to 1 nearly everywhere: equal shares of the area, not equal steps.
    shares = np.linspace(0.002, 1.0, _LEVELS)
    levels = np.unique(np.quantile(known, shares)) if known.size else known
    if levels.size > 2:
        if shade:
            axes.contourf(x, y, height, levels=levels, cmap=_HEIGHT_MAP, extend="min")
        axes.contour(
            x,
            y,
            height,
            levels=levels,
            colors="#aab4bf",
            linewidths=0.5,
            linestyles="-",
        )
    flow = flow_direction(q, field)
    axes.streamplot(
        x,
        y,
        np.where(free, flow[..., 0], np.nan),
        np.where(free, flow[..., 1], np.nan),
        color="#8792a0",
        density=1.25,
        linewidth=0.6,
        arrowsize=0.7,
    )
    rim = workspace_outline(field.workspace)
    axes.plot(*rim.T, color=style.INK, lw=1.4, label="workspace")
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(y[0], y[-1])


def workspace_outline(workspace: Workspace) -> FloatArray:
    """Points (n, 2) once around the workspace."""
    t = np.linspace(0.0, 2.0 * np.pi, 361)
    rim = np.stack([np.cos(t), np.sin(t)], axis=1)
    rim = np.sign(rim) * np.abs(rim) ** (2.0 / workspace.power)
    return np.asarray(workspace.centre + workspace.semi_axes * rim)


def draw_obstacles(
    axes: Axes, obstacles: ObstacleSet, label: str, colour: Any = style.OBSTACLE
) -> None:
    """Draws ellipses; the legend names them once."""
    for index, outline in enumerate(obstacles.boundary(96)):
        axes.add_patch(
            Polygon(
                outline,
                facecolor=colour,
                edgecolor="black",
                lw=0.8,
                zorder=2.5,
                label=label if index == 0 else None,
            )
        )


def _mark_ends(axes: Axes, start: FloatArray, goal: FloatArray) -> None:
    common: dict[str, Any] = {"mec": "white", "mew": 0.9, "ls": "", "zorder": 6}
    axes.plot(*start, "o", color=style.INK, ms=8, label="start", **common)
    axes.plot(*goal, "*", color=style.INK, ms=14, label="goal", **common)


def _body_box(axes: Axes) -> None:
    box = Rectangle((-1, -1), 2, 2, fill=False, ec=style.MUTED, lw=1.0, ls=(0, (1, 2)))
    axes.add_patch(box)
    axes.set_xlim(-1.08, 1.08)
    axes.set_ylim(-1.08, 1.08)


def _zoom(axes: Axes, paths: Sequence[FloatArray]) -> None:
    points = np.concatenate(paths)
    low, high = points.min(axis=0), points.max(axis=0)
    half = 0.56 * float((high - low).max()) + 0.02
    middle = (low + high) / 2.0
    axes.set_xlim(middle[0] - half, middle[0] + half)
    axes.set_ylim(middle[1] - half, middle[1] + half)


def _canonical_axes(axes: Axes, grid: bool = True) -> None:
    axes.set_aspect("equal")
    axes.set_xlabel("canonical x, to the person's right [–]")
    axes.set_ylabel("canonical y, to the head [–]")
    axes.grid(grid)
