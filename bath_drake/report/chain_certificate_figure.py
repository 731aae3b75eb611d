"""Chains and their certificates in one picture: a panel a stage, with its gates."""

import math
import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from bath_drake.composition.chain import Chain, Gate
from bath_drake.composition.result import ChainCertificate, whole_verdict
from bath_drake.composition.rollout import chain_rollout
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.notation import FloatArray
from bath_drake.report import style
from bath_drake.report.certificate_figure import (
    VERDICTS,
    draw_basins,
    draw_boxes,
    draw_points,
    draw_region,
)
from bath_drake.report.field_figures import draw_flow, draw_obstacles

# Starts a side of a panel, even for the reason given beside the single field's.
_STARTS = 100
_COLUMNS = 3
_ENTRY, _EXIT = "#1763e0", "#00a37a"
_MARKS: dict[str, Any] = {"mec": "white", "mew": 0.9, "ls": "", "zorder": 6}


def draw_chain_certificates(
    chains: Sequence[Chain],
    certificates: Sequence[ChainCertificate],
    starts: Sequence[FloatArray] = (),
) -> Figure:
    """Draws every stage of every branch: field, basins, gates and critical points.

    Args:
        chains: The branches' chains.
        certificates: Of each chain.
        starts: (2,) each branch's start, if there are any.
    """
    panels = [(b, k) for b, chain in enumerate(chains) for k in range(len(chain))]
    columns = min(_COLUMNS, len(panels))
    rows = math.ceil(len(panels) / columns)
    figure = style.new_figure(5.0 * rows, width=4.0 * columns)
    grid = np.atleast_1d(figure.subplots(rows, columns, squeeze=False).ravel())
    for axes in grid[len(panels) :]:
        axes.set_visible(False)
    labels: dict[str, Artist] = {}
    for axes, (b, k) in zip(grid, panels, strict=False):
        start = starts[b] if starts else None
        _draw_stage(axes, chains[b], certificates[b], k, start, labels)
        name = f"Branch {b}, stage {k}" if len(chains) > 1 else f"Stage {k}"
        _write_facts(axes, certificates[b], k, name)
    lines = math.ceil(len(labels) / columns)
    figure.set_size_inches(4.0 * columns, 5.0 * rows + 0.8 + 0.22 * lines)
    figure.legend(
        handles=list(labels.values()),
        labels=list(labels),
        loc="outside lower center",
        ncols=columns,
    )
    verdict, reason = whole_verdict(certificates)
    figure.suptitle(
        textwrap.fill(f"{verdict.upper()}: {reason}", 38 * columns),
        color=VERDICTS[verdict],
        weight="bold",
        size=12,
    )
    return figure


def _draw_stage(
    axes: Axes,
    chain: Chain,
    certificate: ChainCertificate,
    k: int,
    start: FloatArray | None,
    labels: dict[str, Artist],
) -> None:
    field, stage = chain.fields[k], certificate.stages[k]
    for handle in draw_basins(axes, field, stage, _STARTS):
        # Shares differ from panel to panel; the legend is of all.
        labels.setdefault(str(handle.get_label()).split(":")[0], handle)
    draw_flow(axes, field, shade=False)
    draw_obstacles(axes, ObstacleSet(field.obstacles.theta), "obstacle")
    for line in draw_region(axes, field, stage):
        labels.setdefault("rim of what was certified", line)
    for box in draw_boxes(axes, field, stage):
        labels.setdefault(str(box.get_label()).split(",")[0], box)
    if k > 0:
        _draw_gate(axes, chain.gates[k - 1], _ENTRY, "gate in: hand-over from before")
    if k < len(chain.gates):
        _draw_gate(axes, chain.gates[k], _EXIT, "gate out: the next stage takes over")
    if start is not None:
        _draw_way(axes, chain, k, start)
    draw_points(axes, stage)
    axes.plot(*field.goal, "*", color=style.INK, ms=13, label="goal", **_MARKS)
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_ylabel("canonical y [–]")
    for named, label in zip(*axes.get_legend_handles_labels(), strict=True):
        labels.setdefault(label.split(" (")[0], named)


def _draw_gate(axes: Axes, gate: Gate, colour: str, label: str) -> None:
    axes.add_patch(
        Polygon(
            gate.outline(),
            facecolor=(*style.rgb(colour), 0.3),
            edgecolor=colour,
            lw=1.8,
            zorder=3.5,
            label=label,
        )
    )
    tip = gate.centre + 1.4 * gate.radius * gate.direction
    axes.annotate(
        "",
        xy=tuple(tip),
        xytext=tuple(gate.centre),
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.4},
        zorder=3.6,
    )


def _draw_way(axes: Axes, chain: Chain, k: int, start: FloatArray) -> None:
    """This stage's part of the motion from the branch's start."""
    found = chain_rollout(start, chain)
    (at,) = np.nonzero(found.stages == k)
    if len(at):
        part = found.path[at[0] : at[-1] + 2]
        axes.plot(*part.T, color=style.INK, lw=2.2, zorder=4, label="way of the start")
        axes.plot(*part[0], "o", color=style.INK, ms=6, label="it begins", **_MARKS)


def _write_facts(axes: Axes, certificate: ChainCertificate, k: int, name: str) -> None:
    stage = certificate.stages[k]
    axes.set_title(f"{name}: {stage.verdict}", color=VERDICTS[stage.verdict])
    facts = stage.reason
    if k > 0:
        passage = certificate.handovers[k - 1]
        facts += f". Gate in: {passage.verdict}, {passage.reason}"
        if passage.arrival != "not shown":
            facts += f"; {passage.arrival} motion through it arrives"
    text = textwrap.fill(facts + ".", 48)
    # As part of the label, so that the layout leaves room for it.
    axes.set_xlabel(f"canonical x [–]\n\n{text}", size=8.5)
