"""The periodic motion: what was shown of it, what was learned, what was washed."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bath_drake.demonstrations.canonical import CanonicalDemonstration
from bath_drake.notation import FloatArray
from bath_drake.report import style
from bath_drake.rhythm.limit_cycle import LimitCycle

_TURN = np.linspace(0.0, 2.0 * np.pi, 361)


def draw_cycle(
    cycle: LimitCycle,
    demonstrations: Sequence[CanonicalDemonstration],
    asked: FloatArray | None = None,
    washed: FloatArray | None = None,
) -> Figure:
    """Draws the cycle round the discrete motion's point, in N.

    Args:
        cycle: The learned one.
        demonstrations: Their periodic parts are drawn, where they have one.
        asked: Offsets (n, 2) that a run asked for; None draws no second panel.
        washed: Where the skin was washed (n, 2), seen from the discrete motion.
    """
    count = 1 if asked is None else 2
    figure = style.new_figure(5.6, width=5.4 * count)
    panels = figure.subplots(1, count, squeeze=False, sharex=True, sharey=True)[0]
    curve = cycle.offset(_TURN)
    _draw_shown(panels[0], demonstrations)
    panels[0].plot(*curve.T, color=style.REPRODUCTION, lw=2.6, label="learned cycle")
    _draw_direction(panels[0], cycle)
    panels[0].set_title(
        f"Learned: {cycle.period:.2f} s a cycle,\n"
        f"one every {cycle.pitch:.3f} of the way"
    )
    if asked is not None and washed is not None:
        right = panels[1]
        right.plot(*washed.T, color=style.REPRODUCTION, lw=1.0, label="washed")
        right.plot(*asked.T, color=style.INK, lw=1.2, ls="--", label="asked for")
        right.set_title("Executed: seen from the\ndiscrete motion")
    for axes in panels:
        axes.set(xlabel="x from the discrete motion, in N", aspect="equal")
        axes.axhline(0.0, color=style.MUTED, lw=0.6)
        axes.axvline(0.0, color=style.MUTED, lw=0.6)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)
    panels[0].set_ylabel("y from the discrete motion, in N")
    return figure


def _draw_shown(axes: Axes, demonstrations: Sequence[CanonicalDemonstration]) -> None:
    parts = [d.periodic for d in demonstrations if d.periodic is not None]
    for index, part in enumerate(parts):
        shade = style.demonstration_shade(index)
        label = "demonstrated" if index == 0 else None
        axes.plot(*part.offsets.T, color=shade, lw=1.0, label=label)


def _draw_direction(axes: Axes, cycle: LimitCycle) -> None:
    """Arrow heads along the cycle."""
    for phase in (0.5, 0.5 + np.pi):
        tip, along = cycle.offset(phase), cycle.tangent(phase)
        tail = tip - 1e-3 * along
        axes.annotate(
            "",
            (float(tip[0]), float(tip[1])),
            (float(tail[0]), float(tail[1])),
            arrowprops={
                "arrowstyle": "-|>",
                "color": style.REPRODUCTION,
                "mutation_scale": 22,
            },
        )
