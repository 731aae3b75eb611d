"""How many obstacles each stage of a chain was tried with, and what that gave."""

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bath_drake.learning.learner import LearningResult
from bath_drake.learning.trace import StageTrial
from bath_drake.learning_figures.overview import log_scale
from bath_drake.report import style

_COLUMNS = 4


def stages_figure(result: LearningResult) -> Figure | None:
    """A panel for each stage of each composed branch; None if there is no such branch.

    It shows the plan that won among those that were tried.
    """
    panels = []
    for b, branch in enumerate(result.branches):
        plan = result.trace.plan_of(b)
        if len(branch.chain) > 1 and plan is not None:
            panels += [(b, k, trials) for k, trials in enumerate(plan.stages)]
    if not panels:
        return None
    columns = min(_COLUMNS, len(panels))
    rows = math.ceil(len(panels) / columns)
    figure = style.new_figure(3.1 * rows + 0.5, width=max(3.3 * columns, 7.5))
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for axes in grid.ravel()[len(panels) :]:
        axes.set_visible(False)
    most = max(t.obstacles for _, _, trials in panels for t in trials)
    for axes, (b, k, trials) in zip(grid.ravel(), panels, strict=False):
        axes.set_xlim(-0.4, most + 0.4)
        _draw_stage(axes, trials)
        name = f"Stage {k + 1}"
        axes.set_title(
            f"Branch {b + 1}, stage {k + 1}" if len(result.branches) > 1 else name
        )
    log_scale(grid[0, 0])
    for axes in grid[:, 0]:
        axes.set_ylabel("error, in N")
    for index, axes in enumerate(grid.ravel()[: len(panels)]):
        if index + columns >= len(panels):
            axes.set_xlabel("virtual obstacles")
            axes.tick_params(labelbottom=True)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside lower center", ncols=min(len(labels), columns + 1)
    )
    return figure


def _draw_stage(axes: Axes, trials: Sequence[StageTrial]) -> None:
    counts = [t.obstacles for t in trials]
    best = min(trials, key=lambda t: t.rank)
    axes.plot(counts, [t.error for t in trials], color=style.DEMONSTRATION, lw=1.4)
    axes.plot(
        counts,
        [t.price for t in trials],
        color=style.MUTED,
        lw=1.2,
        ls="--",
        label="error and the obstacles' price",
    )
    for proved, face, label in (
        (True, style.DEMONSTRATION, "error, proved"),
        (False, "white", "error, not proved"),
    ):
        some = [t for t in trials if t.proved is proved]
        axes.plot(
            [t.obstacles for t in some],
            [t.error for t in some],
            "o",
            mec=style.DEMONSTRATION,
            mfc=face,
            ms=6,
            label=label,
            zorder=3,
        )
    axes.plot(
        best.obstacles,
        best.error,
        "o",
        ms=13,
        mfc="none",
        mec=style.REPRODUCTION,
        mew=2.0,
        label="chosen",
        zorder=4,
    )
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
