"""Where the arm gets on the back, and from where its base would get farther."""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from bath_drake.errors import RunFolderError
from bath_drake.files import write_atomically
from bath_drake.notation import FloatArray
from bath_drake.reach.judge import Cause, Places
from bath_drake.reach.placement import Placement, PlacementMap
from bath_drake.reach.precheck import Reachability
from bath_drake.report import style

# From well to badly conditioned, and for shares; light where it is well.
_WORSE = LinearSegmentedColormap.from_list(
    "worse", ["#f1f6fb", "#9ecae1", "#4292c6", "#f6c35b", "#e0742a", "#7a1f14"]
)
_SHARES = LinearSegmentedColormap.from_list("shares", ["#7a1f14", "#f6c35b", "#1a7f4b"])
_MARKS = {
    Cause.TOO_FAR: ("^", "too far"),
    Cause.JOINT_LIMIT: ("s", "joint limit"),
    Cause.SINGULAR: ("x", "singular"),
    Cause.SELF_COLLISION: ("P", "touches itself"),
    Cause.LINK_NEAR: ("D", "too near to a thing"),
}


def draw_reachability(found: Reachability) -> Figure | None:
    """Draws the back in N, coloured by condition number and by joint margin.

    Returns:
        None if nobody went over the back.
    """
    if found.back is None:
        return None
    joints = found.limits.joints
    figure = style.new_figure(4.9)
    left, right = figure.subplots(1, 2)
    slow, stop = joints.condition_slow, joints.condition_stop
    levels = [0.0, 0.6 * slow, 0.8 * slow, slow, (slow + stop) / 2.0, stop]
    norm = BoundaryNorm([*levels, 1.5 * stop], _WORSE.N)
    shown = np.minimum(found.back.condition, 1.4 * stop)
    tiles = _tiles(left, found.back, shown, _WORSE, norm)
    bar = figure.colorbar(tiles, ax=left, ticks=levels, shrink=0.75)
    bar.ax.set_yticklabels([f"{level:.0f}" for level in levels])
    left.set_title(f"Condition number ({slow:g} slows, {stop:g} stops)")
    tiles = _tiles(right, found.back, found.back.margin, _SHARES, None, (0.0, 0.8))
    figure.colorbar(tiles, ax=right, shrink=0.75, label="rad", extend="max")
    right.set_title("Least margin to a joint's end")
    for axes in (left, right):
        _mark_causes(axes, found.back)
        _draw_path(axes, found.path)
        _canonical(axes)
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=6)
    return figure


def draw_placement(found: Reachability) -> Figure | None:
    """Draws the floor, coloured by what a base there would reach; None without map."""
    plan = found.map
    if plan is None:
        return None
    figure = style.new_figure(4.8)
    left, right = figure.subplots(1, 2)
    for axes, share, title in (
        (left, plan.share, "Share of the back, |x|, |y| ≤ 0.75 of N"),
        (right, plan.path_share, "Share of the path"),
    ):
        tiles = axes.pcolormesh(
            plan.x, plan.y, share, cmap=_SHARES, vmin=0.0, vmax=1.0, shading="nearest"
        )
        figure.colorbar(tiles, ax=axes, shrink=0.8)
        axes.set_title(title)
        _mark_bases(axes, plan)
        axes.set_aspect("equal")
        axes.set_facecolor(style.GRID)
        axes.grid(False)
        axes.set_xlabel("x of W, to the person [m]")
        axes.set_ylabel("y of W [m]")
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    figure.suptitle(
        f"Base at z = {plan.z:.2f} m, yaw {plan.yaw:.2f} rad, person at rest; "
        # A line between this and the titles below.
        "grey: too near the person\n",
        x=0.01,
        ha="left",
        fontsize=10.0,
    )
    return figure


def write_reachability(folder: Path, found: Reachability) -> list[Path]:
    """Writes reach.json and the pictures there are, reach.svg and base.svg.

    Raises:
        RunFolderError: If a file cannot be written.
    """
    written = [folder / "reach.json"]
    text = json.dumps(found.metrics(), indent=2, allow_nan=False) + "\n"
    write_atomically(written[0], text, error=RunFolderError)
    with style.figure_style():
        for name, figure in (
            ("reach.svg", draw_reachability(found)),
            ("base.svg", draw_placement(found)),
        ):
            if figure is None:
                continue
            content = io.BytesIO()
            metadata = {"Date": None, "Creator": None}
            figure.savefig(content, format="svg", metadata=metadata)
            written.append(folder / name)
            write_atomically(written[-1], content.getvalue(), error=RunFolderError)
    return written


def _tiles(
    axes: Axes,
    back: Places,
    values: FloatArray,
    colours: Any,
    norm: Any,
    ends: tuple[float | None, float | None] = (None, None),
) -> Any:
    x, y = (np.unique(back.p_N[:, k].round(6)) for k in range(2))
    return axes.pcolormesh(
        x,
        y,
        values.reshape(len(y), len(x)),
        cmap=colours,
        norm=norm,
        vmin=ends[0],
        vmax=ends[1],
        shading="nearest",
    )


def _mark_causes(axes: Axes, back: Places) -> None:
    for cause, (marker, label) in _MARKS.items():
        there = back.p_N[back.cause == cause]
        if len(there):
            axes.plot(
                *there.T, marker, ms=4.0, mew=1.0, color=style.INK, label=label, ls=""
            )


def _draw_path(axes: Axes, path: Places) -> None:
    axes.plot(*path.p_N.T, color="white", lw=3.6, zorder=3)
    axes.plot(*path.p_N.T, color=style.INK, lw=1.8, zorder=3.1, label="path")
    failed = path.p_N[path.cause > Cause.NO_SKIN]
    if len(failed):
        axes.plot(
            *failed.T,
            "o",
            ms=5.0,
            color=style.REPRODUCTION,
            mec="white",
            mew=0.5,
            zorder=3.2,
            label="path, not reached",
        )


def _canonical(axes: Axes) -> None:
    box = Rectangle((-1, -1), 2, 2, fill=False, ec=style.MUTED, lw=1.0, ls=(0, (1, 2)))
    axes.add_patch(box)
    axes.set_xlim(-1.08, 1.08)
    axes.set_ylim(-1.08, 1.08)
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_xlabel("canonical x, to the person's right [–]")
    axes.set_ylabel("canonical y, to the head [–]")


def _mark_bases(axes: Axes, plan: PlacementMap) -> None:
    def told(what: str, place: Placement) -> str:
        x, y, z = place.position
        share = f"{100.0 * place.path_share:.0f} % of the path"
        return f"{what}: ({x:.2f}, {y:.2f}, {z:.2f}), {share}"

    places = [(plan.here, "o", "here")]
    if plan.best is not plan.here:
        places.append((plan.best, "*", "best found"))
    for place, marker, what in places:
        axes.plot(
            *place.position[:2],
            marker,
            ms=8.0 if marker == "o" else 14.0,
            color=style.INK,
            mec="white",
            ls="",
            label=told(what, place),
        )
