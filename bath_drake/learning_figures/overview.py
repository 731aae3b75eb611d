"""What was learned, branch by branch, and how the cost fell."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from bath_drake.composition.result import whole_verdict
from bath_drake.learning.learner import LearningResult
from bath_drake.learning_figures import plane
from bath_drake.notation import FloatArray
from bath_drake.report import style

_COLUMNS = 3


def overview_figure(
    result: LearningResult, demonstrations: Sequence[FloatArray]
) -> Figure:
    """A panel for each branch, and the learning curve.

    Args:
        result: What was learned.
        demonstrations: All of them, (T, 2) in N, in the learner's order.
    """
    count = len(result.branches) + 1
    columns = min(_COLUMNS, count)
    rows = math.ceil(count / columns)
    figure = style.new_figure(5.9 * rows, width=6.0 * columns)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels[count:]:
        axes.set_visible(False)
    for b, axes in enumerate(panels[: count - 1]):
        _draw_branch(axes, result, b, demonstrations)
    _draw_curve(panels[count - 1], result)
    return figure


def _draw_branch(
    axes: Axes, result: LearningResult, b: int, demonstrations: Sequence[FloatArray]
) -> None:
    branch, found = result.branches[b], result.rollouts[b]
    chain = branch.chain
    own = [demonstrations[i] for i in result.groups[b]]
    gates = [gate.outline() for gate in chain.gates]
    near = [field.obstacles.theta[:, :2] for field in chain.fields]
    plane.show(axes, *own, found.path, *gates, *near)
    for index, outlier in enumerate(result.outliers):
        label = "left out" if index == 0 else None
        path = demonstrations[outlier.index]
        axes.plot(*path.T, color=style.MUTED, lw=1.0, ls=":", label=label)
    plane.draw_demonstrations(axes, own, branch.mean)
    if len(chain) == 1:
        plane.draw_flow(axes, chain.fields[0])
    plane.draw_chain(axes, chain, found)
    plane.draw_ends(axes, branch.start, chain.goal)
    axes.grid(len(chain) > 1)
    obstacles = chain.obstacle_count
    what = "One field" if len(chain) == 1 else f"Chain of {len(chain)} fields"
    whose = f"Branch {b + 1}: " if len(result.branches) > 1 else ""
    verdict = result.certificates[b].verdict
    axes.set_title(
        f"{whose}{what}, {obstacles} virtual obstacle{'s' if obstacles != 1 else ''}, "
        f"{verdict}"
    )
    plane.legend_below(axes)


def _draw_curve(axes: Axes, result: LearningResult) -> None:
    evaluations, cost = np.array(result.cost_history, dtype=np.float64).T
    figures = result.frechet
    axes.plot(
        evaluations,
        cost,
        "o-",
        ms=4,
        drawstyle="steps-post",
        color=style.DEMONSTRATION,
        label="best C of any member so far",
    )
    axes.axhline(
        figures["cost"],
        color=style.REPRODUCTION,
        lw=1.6,
        label=f"C of the skill: {figures['cost']:.4f}",
    )
    if figures["floor"] > 0.0:
        axes.axhline(
            figures["floor"],
            color=style.INK,
            lw=1.2,
            ls="--",
            label=f"spread of the demonstrations: {figures['floor']:.4f}",
        )
    log_scale(axes)
    axes.set_xlim(0.0, 1.04 * max(float(evaluations[-1]), 1.0))
    axes.set(xlabel="members evaluated", ylabel="mean Fréchet distance C, over scale")
    verdict, _ = whole_verdict(result.certificates)
    state = verdict if result.finished else f"{verdict}, unfinished"
    axes.set_title(
        f"Fréchet to the mean {figures['to_mean']:.4f}, {state}, {result.seconds:.1f} s"
    )
    plane.legend_below(axes, columns=1)


def log_scale(axes: Axes) -> None:
    """A logarithmic y axis with plain numbers on it."""
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    low, high = axes.get_ylim()
    if high < 6.0 * low:
        # At least two labelled ticks, however flat the curve.
        middle = np.sqrt(low * high)
        axes.set_ylim(middle / 2.5, middle * 2.5)
