"""The force over time: what was asked for, what was measured, what was true."""

import numpy as np
from matplotlib.figure import Figure

from bath_drake.report import style
from bath_drake.report.run_data import RunData
from bath_drake.report.time_figures import mark_holds, shade_phases
from bath_drake.verification.force_figures import BAND, normal_force, stroke_samples


def draw_force(run: RunData) -> Figure | None:
    """Draws force and stand-off over time; None of a run without contact."""
    if run.scenario.scene.arm.fidelity != "contact":
        return None
    log, force = run.log, run.scenario.control.force
    figure = style.new_figure(4.4)
    upper, lower = figure.subplots(
        2, 1, sharex=True, gridspec_kw={"height_ratios": [2.2, 1.0]}
    )
    for axes in (upper, lower):
        shade_phases(axes, run)
        mark_holds(axes, run)
        axes.margins(x=0.0)
    stroke = log.time[stroke_samples(log)]
    if len(stroke):
        upper.fill_between(
            stroke[[0, -1]],
            force - BAND,
            force + BAND,
            color=style.MASK,
            alpha=0.12,
            lw=0,
            label=f"±{BAND:.0f} N in the stroke",
        )
    measured = -log.measured_wrench[:, 5]
    upper.plot(log.time, measured, color=style.MUTED, lw=0.7, label="measured")
    true = normal_force(log)
    upper.plot(log.time, true, color=style.REPRODUCTION, lw=1.3, label="true")
    asked = np.where(log.asked_force > 0.0, log.asked_force, np.nan)
    upper.plot(log.time, asked, color=style.INK, lw=1.2, ls="--", label="asked for")
    upper.set_ylabel("force along\nthe tool [N]")
    upper.legend(loc="upper left", ncols=4)
    upper.set_ylim(top=1.25 * max(force + BAND, float(true.max()), measured.max()))
    lower.plot(log.time, 1e3 * log.standoff, color=style.INK, lw=1.3)
    lower.set_ylabel("stand-off\nasked for [mm]")
    lower.set_xlabel("simulated time [s]")
    return figure
