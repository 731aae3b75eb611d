"""The fields that were learned, a panel for each stage of each branch."""

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bath_drake.learning.learner import LearningResult
from bath_drake.learning_figures import plane
from bath_drake.notation import FloatArray
from bath_drake.report import style

_COLUMNS = 3


def fields_figure(
    result: LearningResult, demonstrations: Sequence[FloatArray]
) -> Figure:
    """Flow, obstacles, gate and the demonstrations' pieces of every stage.

    Args:
        result: What was learned.
        demonstrations: All of them, (T, 2) in N, in the learner's order.
    """
    panels = [
        (b, k) for b, br in enumerate(result.branches) for k in range(len(br.chain))
    ]
    # Four are a square, not a row and one more.
    columns = 2 if len(panels) == 4 else min(_COLUMNS, len(panels))
    rows = math.ceil(len(panels) / columns)
    figure = style.new_figure(4.4 * rows + 0.6, width=max(4.2 * columns, 6.5))
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in grid[len(panels) :]:
        axes.set_visible(False)
    labels = {}
    for axes, (b, k) in zip(grid, panels, strict=False):
        own = [demonstrations[i] for i in result.groups[b]]
        _draw_stage(axes, result, b, k, own)
        handles, names = axes.get_legend_handles_labels()
        labels.update(dict(zip(names, handles, strict=True)))
    figure.legend(
        handles=list(labels.values()),
        labels=list(labels),
        loc="outside lower center",
        ncols=min(4, 2 * columns),
    )
    return figure


def _draw_stage(
    axes: Axes,
    result: LearningResult,
    b: int,
    k: int,
    demonstrations: Sequence[FloatArray],
) -> None:
    branch, found = result.branches[b], result.rollouts[b]
    chain, field = branch.chain, branch.chain.fields[k]
    plan = result.trace.plan_of(b)
    pieces: Sequence[FloatArray] = demonstrations
    if len(chain) > 1 and plan is not None and len(plan.pieces) == len(chain):
        pieces = list(plan.pieces[k])
    part = plane.path_of(found, k)
    path = branch.start[None] if part is None else part
    shown = [
        *pieces,
        path,
        field.goal[None],
        field.obstacles.boundary(24).reshape(-1, 2),
    ]
    gates = []
    if k > 0:
        gates.append((chain.gates[k - 1], ":", "gate it is entered by"))
    if k < len(chain.gates):
        gates.append((chain.gates[k], "--", "gate it is left by"))
    plane.show(axes, *shown, *(gate.outline() for gate, _, _ in gates))
    plane.draw_flow(axes, field)
    plane.draw_demonstrations(axes, pieces)
    plane.draw_obstacles(axes, field, style.OBSTACLE, "virtual obstacle")
    for gate, line, label in gates:
        axes.plot(*gate.outline().T, color=style.INK, lw=1.3, ls=line, label=label)
    axes.plot(*path.T, color=style.REPRODUCTION, lw=2.4, label="reproduction", zorder=4)
    axes.plot(
        *path[0], "o", color=style.INK, ms=7, label="where it begins", **plane.MARKS
    )
    axes.plot(*field.goal, "*", color=style.INK, ms=13, label="its goal", **plane.MARKS)
    axes.grid(False)
    name = "The field" if len(chain) == 1 else f"Stage {k + 1} of {len(chain)}"
    if len(result.branches) > 1:
        name = f"Branch {b + 1}, {name[0].lower()}{name[1:]}"
    verdict = result.certificates[b].stages[k].verdict
    axes.set_title(f"{name}: κ {field.kappa:.3g}, {verdict}")
