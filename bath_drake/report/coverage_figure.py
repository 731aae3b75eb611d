"""The coverage map: the back in true canonical space, and for how long it was wet."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Polygon
from scipy.spatial import cKDTree

from bath_drake.notation import FloatArray
from bath_drake.report import style
from bath_drake.washing.outcome import WashOutcome

_REACH, _CELLS = 1.1, 221
# Nothing further from a place than this, in N, is drawn as skin.
_NO_SKIN = 0.05
_WET = LinearSegmentedColormap.from_list("wet", ["#cfe6f2", "#4292c6", "#08306b"])


def draw_coverage(
    wash: WashOutcome,
    path: FloatArray,
    wounds: Sequence[FloatArray],
    coverage: str,
    asked: float | None = None,
) -> Figure | None:
    """Draws what was washed, what was missed and what was to be spared.

    Args:
        wash: Of the run.
        path: (n, 2) of the tool's axis on the skin, in N.
        wounds: Outlines (m, 2) of restricted areas, in N.
        coverage: What to say about the share.
        asked: The least share asked for; None if none was.

    Returns:
        The figure; None where nothing was to be washed.
    """
    if wash.coverage is None:
        return None
    steps = np.linspace(-_REACH, _REACH, _CELLS)
    cells = np.stack(np.meshgrid(steps, steps), axis=-1)
    away, nearest = cKDTree(wash.places.p_N).query(cells.reshape(-1, 2))
    shape = cells.shape[:2]
    skin = np.asarray(away < _NO_SKIN).reshape(shape)
    seconds = wash.seconds[nearest].reshape(shape)
    target = wash.target[nearest].reshape(shape) & skin
    figure = style.new_figure(5.6, width=8.2)
    axes = figure.subplots()
    axes.grid(False)
    back = np.where(skin, 1.0, np.nan)
    axes.pcolormesh(steps, steps, back, cmap=ListedColormap(["#f3efeb"]))
    wet = np.where(skin & (seconds > 0.0), seconds, np.nan)
    longest = (
        float(np.quantile(wash.seconds[wash.washed], 0.99))
        if wash.washed.any()
        else 1.0
    )
    image = axes.pcolormesh(steps, steps, wet, cmap=_WET, vmin=0.0, vmax=longest)
    bar = figure.colorbar(image, cax=axes.inset_axes((1.06, 0.02, 0.035, 0.5)))
    bar.set_label("under the tool [s]")
    missed = np.where(target & ~(seconds > 0.0), 1.0, np.nan)
    axes.pcolormesh(steps, steps, missed, cmap=ListedColormap([style.RETREAT]))
    if target.any() and not target.all():
        axes.contour(
            steps,
            steps,
            target.astype(float),
            levels=[0.5],
            colors=style.INK,
            linewidths=1.0,
            linestyles="--",
        )
    axes.plot(*path.T, color=style.REPRODUCTION, lw=1.2, label="the tool's axis")
    _draw_wounds(axes, wounds)
    _dress(axes)
    asked_for = "" if asked is None else f", asked for {100 * asked:.0f} %"
    axes.set_title(f"Washed skin\n{coverage} of the target{asked_for}")
    return figure


def _draw_wounds(axes: Axes, wounds: Sequence[FloatArray]) -> None:
    for index, outline in enumerate(wounds):
        patch = Polygon(
            outline,
            facecolor=style.RESTRICTED,
            alpha=0.55,
            edgecolor=style.RESTRICTED,
            lw=1.4,
            zorder=4,
            label="wound, true outline" if index == 0 else None,
        )
        axes.add_patch(patch)


def _dress(axes: Axes) -> None:
    axes.set_aspect("equal")
    axes.set_xlim(-_REACH, _REACH)
    axes.set_ylim(-_REACH, _REACH)
    axes.set_xlabel("canonical x, to the person's right [–]")
    axes.set_ylabel("canonical y, to the head [–]")
    handles, labels = axes.get_legend_handles_labels()
    handles += [
        Patch(facecolor=_WET(0.6)),
        Patch(facecolor=style.RETREAT),
        Patch(fill=False, edgecolor=style.INK, ls="--"),
    ]
    labels += ["washed", "missed", "to be washed"]
    axes.legend(handles, labels, loc="upper left", bbox_to_anchor=(1.02, 1.0))
