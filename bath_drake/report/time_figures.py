"""Figures over time: errors, speed, phases, holds and the pace of the computer."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import blended_transform_factory

from bath_drake.control.approach import Phase
from bath_drake.notation import FloatArray
from bath_drake.report import style
from bath_drake.report.run_data import RunData
from bath_drake.safety.reasons import Mode

_PHASE_NAMES = {
    Phase.REACH: "line up",
    Phase.DESCEND: "come down",
    Phase.WASH: "wash",
}


@dataclass(frozen=True)
class _Panel:
    """One strip of the stack: limits are (value, what it is called)."""

    label: str
    time: FloatArray
    value: FloatArray
    limits: tuple[tuple[float, str], ...] = ()
    colour: str = style.INK


_MODES = {Mode.HOLD: style.BOX, Mode.RETREAT: style.RETREAT, Mode.STOP: style.FAIL}


def draw_over_time(run: RunData) -> Figure:
    """Draws distances, errors, speed, holds and real-time factor over time."""
    panels = [panel for panel in _panels(run) if len(panel.time)]
    figure = style.new_figure(0.9 + 1.25 * len(panels))
    column = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, panel in zip(column, panels, strict=True):
        shade_phases(axes, run)
        mark_holds(axes, run)
        axes.plot(panel.time, panel.value, color=panel.colour, lw=1.3)
        _draw_limits(axes, panel)
        axes.set_ylabel(panel.label, rotation=0, ha="right", va="center", labelpad=8)
        axes.yaxis.set_label_coords(-0.055, 0.5)
        axes.margins(x=0.0)
    _name_phases(column[0], run)
    column[-1].set_xlabel("simulated time [s]")
    column[0].set_xlim(0.0, float(run.log.time[-1]))
    return figure


def draw_clearance(run: RunData) -> Figure | None:
    """Draws the way from the washed point to the wound's rim; None without one."""
    clearance = run.evaluation.clearance_mm
    if clearance is None or not 0 < len(clearance) == len(run.evaluation.time):
        return None
    figure = style.new_figure(2.5)
    axes = figure.subplots()
    time = run.evaluation.time
    axes.plot(time, clearance, color=style.RESTRICTED, lw=1.6)
    axes.axhspan(
        min(0.0, float(np.min(clearance))), 0.0, color=style.RESTRICTED, alpha=0.2
    )
    axes.axhline(0.0, color=style.RESTRICTED, lw=1.0, ls="--")
    closest = int(np.argmin(clearance))
    axes.plot(
        time[closest], clearance[closest], "o", color=style.RESTRICTED, mec="white"
    )
    axes.annotate(
        f"closest {clearance[closest]:.0f} mm",
        (time[closest], clearance[closest]),
        xytext=(8, 8),
        textcoords="offset points",
    )
    axes.set_xlabel("simulated time [s]")
    axes.set_ylabel("clearance from\nthe wound [mm]")
    axes.margins(x=0.0)
    return figure


def _panels(run: RunData) -> list[_Panel]:
    log, series = run.log, run.evaluation
    control, limits = run.scenario.control, run.scenario.limits
    chain = run.skill.chain
    goal_distance = np.linalg.norm(log.canonical_position - chain.goal, axis=1)
    panels = [
        _Panel("distance\nto the goal\n[canonical]", log.time, goal_distance),
        _Panel(
            "stand-off\ncommanded\n[mm]",
            log.time,
            1e3 * log.standoff,
            ((1e3 * control.standoff, "washing"),),
        ),
        _Panel(
            "stand-off\nerror, signed\n[mm]",
            series.time,
            series.surface_error_mm,
            _both_sides(limits.surface_error_max_mm),
            style.REPRODUCTION,
        ),
        _Panel(
            "axis against\ntrue normal\n[°]",
            series.time,
            series.normal_error_deg,
            _one_side(limits.normal_error_mean_deg, "limit of the mean"),
            style.NORMAL,
        ),
    ]
    if len(chain) > 1:
        count = ((float(len(chain)), "the last"),)
        panels.insert(1, _Panel("field\nfollowed", log.time, log.stage + 1.0, count))
    # A jet that misses the body leaves no speed on its skin.
    if len(series.speed) == len(series.time):
        panels.append(
            _Panel(
                "speed along\nthe skin\n[mm/s]",
                series.time,
                1e3 * series.speed,
                ((1e3 * control.washing_speed, "commanded"), (100.0, "limit")),
                style.REPRODUCTION,
            )
        )
    pace = _pace(log.wall_time)
    if pace is not None:
        panels.append(_Panel("real-time\nfactor [–]", *pace, ((1.0, "real time"),)))
    return panels


def _one_side(limit: float | None, name: str) -> tuple[tuple[float, str], ...]:
    return () if limit is None else ((limit, name),)


def _both_sides(limit: float | None) -> tuple[tuple[float, str], ...]:
    return () if limit is None else ((limit, "limit"), (-limit, ""))


def _pace(wall_time: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Real-time factor between the samples of about every second."""
    simulated, wall = np.asarray(wall_time, dtype=np.float64).reshape(-1, 2).T
    if simulated.size < 3:
        return None
    grid = np.linspace(simulated[0], simulated[-1], max(3, int(simulated[-1]) + 1))
    passed = np.diff(np.interp(grid, simulated, wall))
    factor = np.diff(grid) / np.maximum(passed, 1e-9)
    return 0.5 * (grid[1:] + grid[:-1]), factor


def _draw_limits(axes: Axes, panel: _Panel) -> None:
    place = blended_transform_factory(axes.transAxes, axes.transData)
    for value, name in panel.limits:
        axes.axhline(value, color=style.MUTED, lw=1.0, ls=(0, (5, 3)))
        axes.text(
            1.005,
            value,
            name,
            transform=place,
            va="center",
            size=8.5,
            color=style.MUTED,
        )
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.06 * (high - low), high + 0.06 * (high - low))


def _spans(time: FloatArray, value: FloatArray) -> list[tuple[float, float, int]]:
    """Stretches of constant value: from, to, value."""
    edges = np.flatnonzero(np.diff(value)) + 1
    starts = np.append(0, edges)
    ends = np.append(edges, len(value) - 1)
    return [
        (float(time[a]), float(time[b]), int(value[a]))
        for a, b in zip(starts, ends, strict=True)
    ]


def shade_phases(axes: Axes, run: RunData) -> None:
    """Shades lining up and coming down."""
    for start, end, phase in _spans(run.log.time, run.log.phase):
        axes.axvspan(start, end, color=style.PHASES[phase % 3], lw=0, zorder=0)


def mark_holds(axes: Axes, run: RunData) -> None:
    """Colours the times in which the guard let nothing pass."""
    for start, end, now in _spans(run.log.time, run.log.guard_mode):
        if now != Mode.PASS:
            colour = _MODES[Mode(now)]
            axes.axvspan(start, end, color=colour, alpha=0.4, lw=0, zorder=0.5)


def _name_phases(axes: Axes, run: RunData) -> None:
    place = blended_transform_factory(axes.transData, axes.transAxes)
    total = float(run.log.time[-1])
    for start, end, phase in _spans(run.log.time, run.log.phase):
        if end - start > 0.03 * total:
            name = _PHASE_NAMES[Phase(phase)]
            axes.text(
                (start + end) / 2, 1.04, name, transform=place, ha="center", size=9
            )
