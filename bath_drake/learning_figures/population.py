"""The population of the search for a single field, step by step."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure

from bath_drake.learning.trace import SIDES, Generation, Trace
from bath_drake.learning_figures.overview import log_scale
from bath_drake.notation import FloatArray
from bath_drake.report import style

_TICKS = 12
_FINISH = "finish"


def population_figure(trace: Trace, ways: int) -> Figure | None:
    """Costs, and on which side of the stroke the obstacles stand, over the steps.

    Args:
        trace: What was tried.
        ways: How many ways of doing the stroke there are.

    Returns:
        A column for each way that single fields were sought for; None without any.
    """
    searched = [w for w in range(ways) if trace.generations_of(w)]
    if not searched:
        return None
    width = max(7.5, 6.0 * len(searched))
    figure = style.new_figure(7.4, width=width)
    panels = figure.subplots(
        2, len(searched), squeeze=False, sharex="col", height_ratios=[1.2, 1.0]
    )
    counts = [
        len(p) for w in searched for g in trace.generations_of(w) for p in g.places
    ]
    least, most = (min(counts), max(counts)) if counts else (0, 0)
    shades = mpl.colormaps["viridis"].resampled(most - least + 1)
    norm = BoundaryNorm(np.arange(least, most + 2) - 0.5, shades.N)
    for column, way in enumerate(searched):
        steps = trace.generations_of(way)
        named = f"Way {way + 1}: " if ways > 1 else ""
        dots = _draw_costs(panels[0, column], steps, shades, norm)
        panels[0, column].set_title(f"{named}Every member's cost, step by step")
        image = _draw_sides(panels[1, column], steps)
        panels[1, column].set_title(f"{named}Left or right of the stroke, bend by bend")
    numbers = np.arange(least, most + 1)
    bar = figure.colorbar(dots, ax=panels[0].tolist(), ticks=numbers, pad=0.01)
    bar.set_label("virtual obstacles")
    bar.ax.minorticks_off()
    share = figure.colorbar(image, ax=panels[1].tolist(), pad=0.01)
    share.set_label("share of the members\nwith an obstacle there")
    return figure


def _draw_costs(
    axes: Axes,
    steps: Sequence[Generation],
    shades: mpl.colors.Colormap,
    norm: BoundaryNorm,
) -> mpl.collections.PathCollection:
    x = np.repeat(np.arange(len(steps)), [len(g.costs) for g in steps]).astype(float)
    cost = np.concatenate([g.costs for g in steps])
    count = np.array([len(p) for g in steps for p in g.places], dtype=float)
    # Beside each other, or equal costs would hide each other.
    aside = np.concatenate([_spread(len(g.costs)) for g in steps])
    dots = axes.scatter(
        x + aside, cost, c=count, cmap=shades, norm=norm, s=18, lw=0.0, zorder=3
    )
    # The last step's cost is another one: C itself.
    some = [i for i, g in enumerate(steps) if len(g.costs) and g.name != _FINISH]
    best = [steps[i].costs[0] for i in some]
    at = [i + _spread(len(steps[i].costs))[0] for i in some]
    axes.plot(at, best, color=style.REPRODUCTION, lw=1.2, zorder=2)
    if steps[-1].name == _FINISH:
        axes.axvline(len(steps) - 1.5, color=style.MUTED, lw=1.0, ls="--")
    log_scale(axes)
    axes.set_ylabel("cost with penalties, in N\n(the search's; after finish, C)")
    return dots


def _spread(count: int) -> FloatArray:
    return np.linspace(-0.3, 0.3, count) if count > 1 else np.zeros(count)


def _draw_sides(axes: Axes, steps: Sequence[Generation]) -> mpl.image.AxesImage:
    used = [place for g in steps for member in g.places for place in member]
    rows = 2 * (max(used, default=0) // 2 + 1)
    share = np.zeros((rows, len(steps)))
    for i, step in enumerate(steps):
        for place in range(rows):
            has = [place in member for member in step.places]
            share[place, i] = np.mean(has) if has else 0.0
    image = axes.imshow(
        share, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto", interpolation="nearest"
    )
    label: str | None = "the best member's choice"
    for i, step in enumerate(steps):
        for place in step.places[0] if step.places else ():
            axes.plot(i, place, "o", color=style.REPRODUCTION, ms=5, label=label)
            label = None
    axes.plot([], [], color=style.REPRODUCTION, lw=1.2, label="the best member's cost")
    for part in range(1, rows // 2):
        axes.axhline(2 * part - 0.5, color=style.INK, lw=0.8)
    names = [f"bend {row // 2 + 1}, {SIDES[row % 2]}" for row in range(rows)]
    axes.set_yticks(range(rows), names)
    every = max(1, int(np.ceil(len(steps) / _TICKS)))
    at = [i for i in range(len(steps)) if i % every == 0 or i == len(steps) - 1]
    if len(at) > 1 and at[-1] - at[-2] < every:
        del at[-2]
    axes.set_xticks(at, [_short(steps[i].name) for i in at])
    axes.set_xlabel("step (numbers: generations)")
    axes.grid(False)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.26), ncols=2)
    return image


def _short(name: str) -> str:
    return name.removeprefix("generation ").replace(" ", "\n")
